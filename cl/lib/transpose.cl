// Structure of arrays to records: what a vector kernel computes for LANES triangles becomes one record a triangle.

#include "lib/lanes.cl"

#if LANES == 16
// Four perfect shuffles of 16 rows transpose them.
static inline void transpose16(UintL rows[16])
{
#pragma unroll
  for (int stage = 0; stage < 4; stage++) {
    UintL out[16];
#pragma unroll
    for (int i = 0; i < 8; i++) {
      out[2 * i].even = rows[i].lo;
      out[2 * i].odd = rows[i + 8].lo;
      out[2 * i + 1].even = rows[i].hi;
      out[2 * i + 1].odd = rows[i + 8].hi;
    }
#pragma unroll
    for (int i = 0; i < 16; i++) rows[i] = out[i];
  }
}
#endif

// Writes the lanes of `bits` as records of `words` words behind each other, from an address that is a multiple of 64
// bytes on; words is a constant multiple of 16. `fields` is used up.
static inline void records_store(UintL *fields, uint words, uint bits, global uint *to)
{
#if LANES == 16
#pragma unroll
  for (uint part = 0; part < words; part += 16) {
    transpose16(fields + part);
    global uint *next = to + part;
#pragma unroll
    for (uint lane = 0; lane < 16; lane++) {
      *(global UintL *)next = fields[part + lane];
      next += bits >> lane & 1 ? words : 0;
    }
  }
#else
  for (; bits; bits &= bits - 1, to += words) {
    uint lane = lowest_bit(bits);
    for (uint word = 0; word < words; word++) to[word] = LANE_UINT(fields[word], lane);
  }
#endif
}
