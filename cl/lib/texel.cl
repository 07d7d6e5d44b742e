// Texels: packed colours, decoded by tables of 256 entries. Registers hold a table where the compiler can look entries
// up by permutations: these take less time than loads, and those of 16 bits half as long as those of 32.

#include "lib/lanes.cl"

typedef struct Color4L {
  Vec3L rgb;
  FloatL a;
} Color4L;

// Where texels are read from: those of one texture, and how their three colour channels are decoded (256 entries, and
// DECODE_HALVES after them their lower 16 bits, then their upper ones); alpha is always linear.
typedef struct Texels {
  global const uint *packed;  // RGBA from the low byte up
  constant float *linear_from_byte;
} Texels;

#define DECODE_HALVES 512

#if defined(HAS_MASK) || defined(HAS_BLEND)
#define HAS_ALPHA
#endif

#ifdef HAS_PERMUTATION
#if defined(__AVX512BW__) && __has_builtin(__builtin_ia32_vpermi2varhi512)
#define HAS_HALVES
#endif
#endif

#ifdef HAS_HALVES
typedef short Halves __attribute__((ext_vector_type(32)));

// Entries of 16 bits, for two bytes of each lane: its lower and its upper half hold a number below 256. A permutation
// picks from 64 of them.
static inline Halves halves_pick(constant float *table, Halves index)
{
  Halves parts[4];
#pragma unroll
  for (uint i = 0; i < 4; i++)
    parts[i] = __builtin_ia32_vpermi2varhi512(__builtin_astype(vload16(2 * i, table), Halves), index,
                                              __builtin_astype(vload16(2 * i + 1, table), Halves));
  Halves second = (index & (Halves)(64)) != (Halves)(0), last = (index & (Halves)(128)) != (Halves)(0);
  return last ? (second ? parts[3] : parts[2]) : (second ? parts[1] : parts[0]);
}

// The table's entries for both numbers of each lane.
static inline __attribute__((always_inline)) void pairs_decode(FloatL *first, FloatL *second, constant float *table,
                                                               UintL pairs)
{
  const UintL half_word = UINTL(0xffffu), shift = UINTL(16);
  Halves index = __builtin_astype(pairs, Halves);
  UintL low = __builtin_astype(halves_pick(table + DECODE_HALVES, index), UintL);
  UintL high = __builtin_astype(halves_pick(table + DECODE_HALVES + 128, index), UintL);
  *first = LANE_AS_FLOAT((low & half_word) | high << shift);
  *second = LANE_AS_FLOAT(low >> shift | (high & ~half_word));
}
#endif

static inline FloatL texel_alpha(UintL packed)
{
#ifdef HAS_ALPHA
  return LANE_CONVERT_FLOAT(packed >> UINTL(24)) * FLOATL(1.0f / 255.0f);
#else
  return FLOATL(1);  // nothing asks for it
#endif
}

// Texels at two places by lane. (Inlined always: registers hold the table. By a pointer: Oclgrind does not know what
// the compiler puts in where a structure that is returned is.)
static inline __attribute__((always_inline)) void texels_load(Color4L out[2], const Texels *from, IntL first,
                                                              IntL second)
{
  const UintL packed[2] = {LANE_GATHER(UintL, from->packed, first), LANE_GATHER(UintL, from->packed, second)};
  const UintL byte = UINTL(255), eight = UINTL(8), sixteen = UINTL(16);
  constant float *table = from->linear_from_byte;
#ifdef HAS_HALVES
  const UintL pair = UINTL(0x00ff00ffu),
              greens[2] = {(packed[0] >> eight) & byte, (packed[1] << eight) & (byte << sixteen)};
#pragma unroll
  for (uint i = 0; i < 2; i++) pairs_decode(&out[i].rgb.x, &out[i].rgb.z, table, packed[i] & pair);
  pairs_decode(&out[0].rgb.y, &out[1].rgb.y, table, greens[0] | greens[1]);
#else
#pragma unroll
  for (uint i = 0; i < 2; i++) {
    UintL r = packed[i] & byte, g = (packed[i] >> eight) & byte, b = (packed[i] >> sixteen) & byte;
    out[i].rgb = vec3l(LANE_GATHER(FloatL, table, r), LANE_GATHER(FloatL, table, g), LANE_GATHER(FloatL, table, b));
  }
#endif
#pragma unroll
  for (uint i = 0; i < 2; i++) out[i].a = texel_alpha(packed[i]);
}
