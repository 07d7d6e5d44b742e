#include "accel/bvh_split.h"

#include <string.h>

void bins_clear(Bins *bins, const BinMap *map)
{
  Box empty = box_empty();
  for (uint32_t i = 0; i < map->bins; i++)
    for (int axis = 0; axis < 3; axis++) bins->box[i][axis] = empty;
  memset(bins->count, 0, map->bins * sizeof bins->count[0]);
}

void bins_add(Bins *bins, const BinMap *map, const Prim *prims, uint32_t begin, uint32_t end)
{
  const BinMap local = *map;
  for (uint32_t i = begin; i < end; i++) {
    Prim prim = prims[i];
    I4 index = bin_index(&local, prim_centroid(prim));
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; axis++) {
      int32_t bin = index[axis];
      bins->box[bin][axis] = box_union(prim, bins->box[bin][axis]);
      bins->count[bin][axis]++;
    }
  }
}

void bins_merge(Bins *bins, const Bins *other, const BinMap *map)
{
  for (uint32_t i = 0; i < map->bins; i++) {
    for (int axis = 0; axis < 3; axis++) {
      bins->box[i][axis] = box_union(bins->box[i][axis], other->box[i][axis]);
      bins->count[i][axis] += other->count[i][axis];
    }
  }
}

F4 area_scale(Box bounds)
{
  F4 extent = bounds.high - bounds.low;
  float longest = extent[0] > extent[1] ? extent[0] : extent[1];
  if (extent[2] > longest) longest = extent[2];
  float scale = 1 / longest;
  return f4(scale < INFINITY ? scale : 0);
}

int bins_split(Split *out, const Bins *bins, const BinMap *map, F4 scale)
{
  F4 right_cost[MAX_BINS];
  Box box[3] = {box_empty(), box_empty(), box_empty()};
  I4 count = {0};
  for (uint32_t i = map->bins - 1; i > 0; i--) {
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; axis++) box[axis] = box_union(bins->box[i][axis], box[axis]);
    count += bins->count[i];
    right_cost[i] = half_areas((box[0].high - box[0].low) * scale, (box[1].high - box[1].low) * scale,
                               (box[2].high - box[2].low) * scale) *
                    __builtin_convertvector(count, F4);
  }

  // A side without primitives has infinite area: its cost is 0 x inf = NaN, which is less than nothing.
  F4 best_cost = f4(INFINITY);
  I4 best_bin = {0};
  for (int axis = 0; axis < 3; axis++) box[axis] = box_empty();
  count = (I4){0};
  for (uint32_t i = 1; i < map->bins; i++) {
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; axis++) box[axis] = box_union(bins->box[i - 1][axis], box[axis]);
    count += bins->count[i - 1];
    F4 cost = right_cost[i] + half_areas((box[0].high - box[0].low) * scale, (box[1].high - box[1].low) * scale,
                                         (box[2].high - box[2].low) * scale) *
                                  __builtin_convertvector(count, F4);
    I4 less = cost < best_cost;
    best_cost = f4_min(cost, best_cost);
    best_bin = (less & (I4){i, i, i, i}) | (~less & best_bin);
  }

  uint32_t axis = 0;
  for (uint32_t other = 1; other < 3; other++)
    if (best_cost[other] < best_cost[axis]) axis = other;
  if (!(best_cost[axis] > 0 && best_cost[axis] < INFINITY)) return 0;

  Split split = {.cost = best_cost[axis], .axis = axis, .bin = (uint32_t)best_bin[axis]};
  split.left = split.right = box_empty();
  for (uint32_t i = 0; i < split.bin; i++) {
    split.left = box_union(bins->box[i][axis], split.left);
    split.left_count += (uint32_t)bins->count[i][axis];
  }
  for (uint32_t i = split.bin; i < map->bins; i++) split.right = box_union(bins->box[i][axis], split.right);
  *out = split;
  return 1;
}

void prims_partition(Prim *to, const Prim *from, uint32_t begin, uint32_t end, const BinMap *map, const Split *split,
                     uint32_t left_at, uint32_t right_at, Box *left_centroids, Box *right_centroids)
{
  const uint32_t axis = split->axis;
  const float low = map->low[axis], scale = map->scale[axis];
  const int32_t border = (int32_t)split->bin;
  Box left = *left_centroids, right = *right_centroids;
  for (uint32_t i = begin; i < end; i++) {
    Prim prim = from[i];
    int32_t goes_right = (int32_t)((from[i].low[axis] + from[i].high[axis] - low) * scale) >= border;
    uint32_t at = goes_right ? right_at : left_at;
    to[at] = prim;
    right_at += (uint32_t)goes_right;
    left_at += (uint32_t)!goes_right;
    I4 right_mask = {-goes_right, -goes_right, -goes_right, -goes_right};
    I4 centroid = (I4)prim_centroid(prim);
    left = box_with_point(left, (F4)(centroid | right_mask));  // all bits set is a NaN, which changes nothing
    right = box_with_point(right, (F4)(centroid | ~right_mask));
  }
  *left_centroids = left;
  *right_centroids = right;
}

float few_split(uint32_t *left_mask, const Prim *prims, uint32_t count, F4 scale)
{
  static const float members[1 << MAX_FEW] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
  Box box[1 << MAX_FEW];  // of each subset
  float cost[(1 << MAX_FEW) + 1] = {0};
  uint32_t all = (1u << count) - 1;
  for (uint32_t bit = 0; bit < count; bit++) {
    uint32_t set = 1u << bit;
    box[set] = prims[bit];
    for (uint32_t rest = 1; rest < set; rest++) box[set | rest] = box_union(box[rest], prims[bit]);
  }
  for (uint32_t set = 1; set < all; set += 3) {
    F4 areas = half_areas((box[set].high - box[set].low) * scale, (box[set + 1].high - box[set + 1].low) * scale,
                          (box[set + 2].high - box[set + 2].low) * scale);
    for (uint32_t i = 0; i < 3; i++) cost[set + i] = members[set + i] * areas[i];
  }
  uint32_t best = 1;
  for (uint32_t set = 3; set < all; set += 2)
    if (cost[set] + cost[all ^ set] < cost[best] + cost[all ^ best]) best = set;

  // The side with the smaller coordinates, along the axis on which they differ most, goes left.
  F4 apart = (box[best].low + box[best].high) - (box[all ^ best].low + box[all ^ best].high);
  float widest = 0;
  for (int axis = 0; axis < 3; axis++)
    if (fabsf(apart[axis]) > fabsf(widest)) widest = apart[axis];
  *left_mask = widest > 0 ? all ^ best : best;
  return cost[best] + cost[all ^ best];
}

static Range range_empty(uint32_t begin) { return (Range){begin, begin, box_empty(), box_empty()}; }

static void range_append(Range *range, Prim *to, Prim prim)
{
  range->bounds = box_union(prim, range->bounds);
  range->centroids = box_with_point(range->centroids, prim_centroid(prim));
  to[range->end++] = prim;
}

void few_partition(Range *left, Range *right, Prim *to, const Prim *from, const Range *range, uint32_t left_mask)
{
  uint32_t left_count = 0;
  for (uint32_t rest = left_mask; rest; rest &= rest - 1) left_count++;
  *left = range_empty(range->begin);
  *right = range_empty(range->begin + left_count);
  for (uint32_t i = 0; i < range_count(range); i++)
    range_append(left_mask >> i & 1 ? left : right, to, from[range->begin + i]);
}

// The element that would be at [nth] if the keys were sorted.
static uint64_t select_nth(uint64_t *keys, uint32_t count, uint32_t nth)
{
  uint32_t begin = 0, end = count;
  while (end - begin > 1) {
    uint64_t pivot = keys[begin + (end - begin - 1) / 2];
    uint32_t i = begin, j = end - 1;
    for (;;) {
      while (keys[i] < pivot) i++;
      while (keys[j] > pivot) j--;
      if (i >= j) break;
      uint64_t swapped = keys[i];
      keys[i++] = keys[j];
      keys[j--] = swapped;
    }
    if (nth <= j)
      end = j + 1;
    else
      begin = j + 1;
  }
  return keys[begin];
}

// Orders like (centroid, place): the bits of a float with the sign folded in compare as integers.
static uint64_t median_key(Prim prim, uint32_t axis, uint32_t place)
{
  uint32_t bits = (uint32_t)((I4)prim_centroid(prim))[axis];
  bits ^= bits >> 31 ? 0xffffffffu : 0x80000000u;
  return (uint64_t)bits << 32 | place;
}

void range_split_median(Range *left, Range *right, Prim *to, const Prim *from, const Range *range)
{
  F4 extent = range->centroids.high - range->centroids.low;
  uint32_t widest = 0;
  for (uint32_t other = 1; other < 3; other++)
    if (extent[other] > extent[widest]) widest = other;

  uint32_t count = range_count(range), half = count / 2;
  uint64_t *keys = (uint64_t *)(to + range->begin);
  for (uint32_t i = 0; i < count; i++) keys[i] = median_key(from[range->begin + i], widest, i);
  uint64_t border = select_nth(keys, count, half);

  *left = range_empty(range->begin);
  *right = range_empty(range->begin + half);
  for (uint32_t i = 0; i < count; i++) {
    Prim prim = from[range->begin + i];
    range_append(median_key(prim, widest, i) < border ? left : right, to, prim);
  }
}
