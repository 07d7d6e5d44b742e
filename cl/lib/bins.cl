// Sorting a chunk's records into bins of RASTER_BIN_PX pixels: count, scan, fill, by the one work-item that made them;
// and the chunks that touch a bin, the nearer ones first.
//
// A chunk has lists for the bins of its span alone: list (y - first_y) * (end_x - first_x) + x - first_x, and behind
// them that of large triangles. `starts` belongs to the chunk. Counts go one place up, so that after the fill list b is
// [starts[b], starts[b + 1]) (counting sort's usual shift).

#include "lib/transpose.cl"
#include "shared/raster.h"

// Ranges of bins of a chunk's records, first | last << 16, and what all of them span.
typedef struct BinRanges {
  uint x[RASTER_CHUNK], y[RASTER_CHUNK];
  uint count;
  UintL low_x, low_y, high_x, high_y;  // by lane
  FloatL near, far;
} BinRanges;

static inline void ranges_clear(BinRanges *ranges)
{
  ranges->count = 0;
  ranges->low_x = ranges->low_y = UINTL(0xffffu);
  ranges->high_x = ranges->high_y = UINTL(0);
  ranges->near = FLOATL(INFINITY);
  ranges->far = FLOATL(0);
}

// Appends the lanes of `seen` (which `bits` are, and which are some) to the chunk's records, `words` words each. `x`
// and `y` are their ranges of bins; nothing of them is nearer than `near`, little farther than `far`. `fields` is used
// up.
static inline __attribute__((always_inline)) void bins_take(BinRanges *ranges, IntL seen, uint bits, UintL x, UintL y,
                                                            FloatL near, FloatL far, UintL *fields, uint words,
                                                            global uint *records)
{
  records_store(fields, words, bits, records + ranges->count * words);
  for (; bits; bits &= bits - 1, ranges->count++) {
    uint lane = lowest_bit(bits);
    ranges->x[ranges->count] = LANE_UINT(x, lane);
    ranges->y[ranges->count] = LANE_UINT(y, lane);
  }
  ranges->low_x = seen ? min_uint(ranges->low_x, x & UINTL(0xffffu)) : ranges->low_x;
  ranges->low_y = seen ? min_uint(ranges->low_y, y & UINTL(0xffffu)) : ranges->low_y;
  ranges->high_x = seen ? max_uint(ranges->high_x, x >> UINTL(16)) : ranges->high_x;
  ranges->high_y = seen ? max_uint(ranges->high_y, y >> UINTL(16)) : ranges->high_y;
  ranges->near = seen ? min_lane(ranges->near, near) : ranges->near;
  ranges->far = seen ? max_lane(ranges->far, far) : ranges->far;
}

static inline bool bins_large(uint range_x, uint range_y)
{
  uint across = (range_x >> 16) - (range_x & 0xffffu) + 1, down = (range_y >> 16) - (range_y & 0xffffu) + 1;
  return across * down > RASTER_LARGE_BINS;
}

// Writes the span of a chunk (number `item` of `item_count`, which is the stride of the fields) and its lists.
static inline void bins_sort(BinRanges *ranges, global uint *spans, uint item, uint item_count, global uint *starts,
                             global ushort *lists)
{
  uint first_x = 0xffffu, first_y = 0xffffu, last_x = 0, last_y = 0, count = ranges->count;
  float near = INFINITY;
  for (uint lane = 0; lane < LANES; lane++) {
    first_x = min(first_x, LANE_UINT(ranges->low_x, lane));
    first_y = min(first_y, LANE_UINT(ranges->low_y, lane));
    last_x = max(last_x, LANE_UINT(ranges->high_x, lane));
    last_y = max(last_y, LANE_UINT(ranges->high_y, lane));
    near = LANE_FLOAT(ranges->near, lane) < near ? LANE_FLOAT(ranges->near, lane) : near;
  }
  spans[SPAN_COUNT * item_count + item] = count;
  spans[SPAN_FIRST_X * item_count + item] = first_x;
  spans[SPAN_FIRST_Y * item_count + item] = first_y;
  spans[SPAN_END_X * item_count + item] = count ? last_x + 1 : 0;
  spans[SPAN_END_Y * item_count + item] = count ? last_y + 1 : 0;
  spans[SPAN_NEAR * item_count + item] = as_uint(near > 0 ? near : 0.0f);
  spans[SPAN_ORDER * item_count + item] = as_uint(max(near, 0.0f) + greatest_lane(ranges->far));
  if (!count) return;
  uint columns = last_x - first_x + 1, bins = columns * (last_y - first_y + 1);
  for (uint i = 0; i < bins + 2; i++) starts[i] = 0;
  for (uint i = 0; i < count; i++) {
    uint x = ranges->x[i], y = ranges->y[i];
    if (bins_large(x, y)) {
      starts[bins + 1]++;
      continue;
    }
    uint row = ((y & 0xffffu) - first_y) * columns;
    for (uint k = y & 0xffffu; k <= y >> 16; k++, row += columns)
      for (uint j = (x & 0xffffu) - first_x; j <= (x >> 16) - first_x; j++) starts[row + j + 1]++;
  }
  uint sum = 0;
  for (uint i = 1; i < bins + 2; i++) {
    uint here = starts[i];
    starts[i] = sum;
    sum += here;
  }
  for (uint i = 0; i < count; i++) {
    uint x = ranges->x[i], y = ranges->y[i];
    if (bins_large(x, y)) {
      lists[starts[bins + 1]++] = (ushort)i;
      continue;
    }
    uint row = ((y & 0xffffu) - first_y) * columns;
    for (uint k = y & 0xffffu; k <= y >> 16; k++, row += columns)
      for (uint j = (x & 0xffffu) - first_x; j <= (x >> 16) - first_x; j++) lists[starts[row + j + 1]++] = (ushort)i;
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

#define SORT_CHUNKS 1024  // at a time

// The item of a work-item, no less than item_count for one of no use. A runtime gives a thread neighbours: not all of
// these are unseen.
static inline uint spread_item(uint number, uint item_count)
{
  uint share = (item_count + RASTER_SPREAD - 1) / RASTER_SPREAD;
  return number < share * RASTER_SPREAD ? number % RASTER_SPREAD * share + number / RASTER_SPREAD : item_count;
}

// Items of a view among those [first_item, first_item + item_count) of a pass, counted from there: begin and end.
static inline uint2 view_items(global const uint *item_starts, uint view, uint first_item, uint item_count)
{
  uint2 range = (uint2)(item_starts[view], item_starts[view + 1]);
  return clamp(range, (uint2)(first_item), (uint2)(first_item + item_count)) - (uint2)(first_item);
}

// Chunks of [first, end), at most SORT_CHUNKS, whose spans hold bin (x, y), in the order of SPAN_ORDER: keys gets their
// numbers in the lower half. Returns how many.
//
// For camera visibility middles give it, not nearest points: a floor that begins at the eye would come before all that
// stands on it. That takes a fifth off the time in a scene of columns; maps, whose texels cost less, gain nothing.
static inline uint bin_chunks(ulong *keys, global const uint *spans, uint item_count, uint first, uint end, uint x,
                              uint y)
{
  uint count = 0;
  for (uint chunk = first; chunk < end; chunk += LANES) {
    global const uint *span = spans + chunk;
    IntL holds = (LANE_LOAD(span, SPAN_FIRST_X * item_count) <= UINTL(x)) &
                 (LANE_LOAD(span, SPAN_END_X * item_count) > UINTL(x)) &
                 (LANE_LOAD(span, SPAN_FIRST_Y * item_count) <= UINTL(y)) &
                 (LANE_LOAD(span, SPAN_END_Y * item_count) > UINTL(y));
    uint bits = lane_bits(holds);
    if (end - chunk < LANES) bits &= (1u << (end - chunk)) - 1;
    for (; bits; bits &= bits - 1) {
      uint number = chunk + lowest_bit(bits);
      keys[count++] = (ulong)spans[SPAN_ORDER * item_count + number] << 32 | number;
    }
  }
  for (uint gap = count > 64 ? 64 : 1; gap; gap = gap > 1 ? gap / 8 : 0) {  // Shell's sort
    for (uint i = gap; i < count; i++) {
      ulong key = keys[i];
      uint to = i;
      for (; to >= gap && keys[to - gap] > key; to -= gap) keys[to] = keys[to - gap];
      keys[to] = key;
    }
  }
  return count;
}

// A record that will be drawn soon: this many after the one at hand, in the list or behind it, which has room for them.
#define PREFETCH_RECORDS 6

// The lists of a bin in a chunk.
typedef struct BinLists {
  uint begin[2], end[2];
} BinLists;

static inline BinLists bin_lists(global const uint *spans, uint item_count, uint chunk, global const uint *starts,
                                 uint x, uint y)
{
  uint first_x = spans[SPAN_FIRST_X * item_count + chunk], first_y = spans[SPAN_FIRST_Y * item_count + chunk];
  uint columns = spans[SPAN_END_X * item_count + chunk] - first_x,
       bins = columns * (spans[SPAN_END_Y * item_count + chunk] - first_y);
  uint list = (y - first_y) * columns + x - first_x;
  BinLists lists = {{starts[list], starts[bins]}, {starts[list + 1], starts[bins + 1]}};
  return lists;
}
