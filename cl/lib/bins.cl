// Sorting a chunk's records into bins of RASTER_BIN_PX pixels: count, scan, fill, by the one work-item that made them.
//
// `starts` [bin_count + 2] belongs to the chunk; bin_count is the number of the list of large triangles. Counts go one
// place up, so that after the fill list b is [starts[b], starts[b + 1]) (counting sort's usual shift).

#include "lib/transpose.cl"
#include "shared/raster.h"

// The bins of a view that one pass covers: columns of the whole view, rows [first_row, first_row + rows).
typedef struct Bins {
  uint columns, first_row, rows;
} Bins;

static inline uint bins_count(Bins bins) { return bins.columns * bins.rows; }

static inline bool bins_large(uint range_x, uint range_y)
{
  uint across = (range_x >> 16) - (range_x & 0xffffu) + 1, down = (range_y >> 16) - (range_y & 0xffffu) + 1;
  return across * down > RASTER_LARGE_BINS;
}

static inline void bins_clear(global uint *starts, Bins bins)
{
  for (uint i = 0; i < bins_count(bins) + 2; i++) starts[i] = 0;
}

static inline void bins_add(global uint *starts, Bins bins, RasterSpan *span, uint range_x, uint range_y)
{
  uint x0 = range_x & 0xffffu, x1 = range_x >> 16, y0 = range_y & 0xffffu, y1 = range_y >> 16;
  span->first_x = x0 < span->first_x ? x0 : span->first_x;
  span->first_y = y0 < span->first_y ? y0 : span->first_y;
  span->end_x = x1 + 1 > span->end_x ? x1 + 1 : span->end_x;
  span->end_y = y1 + 1 > span->end_y ? y1 + 1 : span->end_y;
  if (bins_large(range_x, range_y)) {
    starts[bins_count(bins) + 1]++;
    return;
  }
  for (uint y = y0 - bins.first_row; y <= y1 - bins.first_row; y++)
    for (uint x = x0; x <= x1; x++) starts[y * bins.columns + x + 1]++;
}

// Appends the lanes of `bits` to the chunk's records and counts the bins that they touch; the words of a record are as
// in bins_fill. `fields` is used up.
static inline __attribute__((always_inline)) void bins_take(UintL *fields, uint words, uint range_word, uint bits,
                                                            global uint *records, RasterSpan *span, global uint *starts,
                                                            Bins bins)
{
  global uint *record = records + span->count * words;
  records_store(fields, words, bits, record);
  for (uint count = popcount(bits); count; count--, record += words, span->count++)
    bins_add(starts, bins, span, record[range_word], record[range_word + 1]);
}

// Records are `words` words each, with the ranges of bins in the words `range_word` and the next.
static inline void bins_fill(global uint *starts, Bins bins, global const uint *records, uint words, uint range_word,
                             uint record_count, global ushort *lists)
{
  uint sum = 0;
  for (uint i = 1; i < bins_count(bins) + 2; i++) {
    uint count = starts[i];
    starts[i] = sum;
    sum += count;
  }
  for (uint i = 0; i < record_count; i++) {
    uint range_x = records[i * words + range_word], range_y = records[i * words + range_word + 1];
    if (bins_large(range_x, range_y)) {
      lists[starts[bins_count(bins) + 1]++] = (ushort)i;
      continue;
    }
    for (uint y = (range_y & 0xffffu) - bins.first_row; y <= (range_y >> 16) - bins.first_row; y++)
      for (uint x = range_x & 0xffffu; x <= range_x >> 16; x++) lists[starts[y * bins.columns + x + 1]++] = (ushort)i;
  }
}

// Range of bins from `low` to `high` pixels, both in the view: first | last << 16.
static inline UintL bins_range(FloatL low, FloatL high, uint first, uint end)
{
  FloatL scale = FLOATL(1.0f / RASTER_BIN_PX), last = FLOATL((float)(end - 1));
  FloatL from = max_lane(low * scale, FLOATL((float)first)),
         to = max_lane(min_lane(high * scale, last), FLOATL((float)first));
  from = min_lane(from, last);
  return LANE_AS_UINT(LANE_CONVERT_INT(from)) | LANE_AS_UINT(LANE_CONVERT_INT(to)) << UINTL(16);
}
