// How the BVH builder divides a range of primitives in two: binned surface-area heuristic, median where that fails.
//
// All of it is stable: the two halves keep the order of the whole. Primitives start in the order of ids, so that every
// range is in that order, whatever splits led to it.
#pragma once

#include "accel/box.h"

// A triangle's box. The fourth lane of `low` holds its id, raised so that the lane is an ordinary float (a denormal one
// slows arithmetic on some processors, and a NaN would poison minima).
typedef Box Prim;

#define PRIM_ID_BASE 0x40000000u

static inline F4 prim_centroid(Prim prim) { return prim.low + prim.high; }  // doubled
static inline uint32_t prim_id(Prim prim) { return (uint32_t)((I4)prim.low)[3] - PRIM_ID_BASE; }

static inline Prim prim_with_id(Box box, uint32_t id)
{
  I4 low = (I4)box.low;
  low[3] = (int32_t)(PRIM_ID_BASE + id);
  return (Prim){(F4)low, box.high};
}

// The primitives [begin, end), the box of them and the box of their (doubled) centroids.
typedef struct Range {
  uint32_t begin, end;
  Box bounds, centroids;
} Range;

static inline uint32_t range_count(const Range *range) { return range->end - range->begin; }

#define MAX_BINS 16

typedef struct Bins {
  Box box[MAX_BINS][3];  // of the primitives by bin and axis
  I4 count[MAX_BINS];    // lane = axis
} Bins;

// Maps a doubled centroid to a bin on each axis.
typedef struct BinMap {
  F4 low, scale;
  uint32_t bins;
} BinMap;

typedef struct Split {
  float cost;  // sum of half area x count of both sides, area in units of the square of the range's longest side
  uint32_t axis, bin;  // primitives in bins under `bin` go left
  uint32_t left_count;
  Box left, right;
} Split;

static inline I4 bin_index(const BinMap *map, F4 centroid)
{
  return __builtin_convertvector((centroid - map->low) * map->scale, I4);
}

// False where no axis can be binned: centroids alike, or too near or too far for floats.
static inline int bin_map_make(BinMap *out, const Range *range)
{
  uint32_t count = range_count(range);
  uint32_t bins = count < 8 * MAX_BINS ? 4 + count / 8 : MAX_BINS;
  F4 extent = range->centroids.high - range->centroids.low;
  if (bins > MAX_BINS) bins = MAX_BINS;
  *out = (BinMap){.low = range->centroids.low, .bins = bins};
  int usable = 0;
  for (int axis = 0; axis < 3; axis++) {
    float scale = 0.9999f * (float)bins / extent[axis];  // the last centroid stays under `bins`
    if (!(extent[axis] < INFINITY)) return 0;
    if (!(scale < INFINITY)) continue;
    out->scale[axis] = scale;
    usable = 1;
  }
  return usable;
}

void bins_clear(Bins *bins, const BinMap *map);
void bins_add(Bins *bins, const BinMap *map, const Prim *prims, uint32_t begin, uint32_t end);
void bins_merge(Bins *bins, const Bins *other, const BinMap *map);

// Cheapest border between two bins; returns 0 where none has a cost above zero and under infinity.
int bins_split(Split *out, const Bins *bins, const BinMap *map, F4 scale);

// Scale that gives a box's longest side the length 1.
F4 area_scale(Box bounds);

// Moves [begin, end) of `from` to `to`: the left ones to left_at onwards, the others to right_at onwards. Grows the
// centroid boxes by what it moves.
void prims_partition(Prim *to, const Prim *from, uint32_t begin, uint32_t end, const BinMap *map, const Split *split,
                     uint32_t left_at, uint32_t right_at, Box *left_centroids, Box *right_centroids);

// Cheapest of all divisions of 2 to MAX_FEW primitives: sets the primitives that go left (bit i: prims[i]) and returns
// the cost as in Split.
#define MAX_FEW 4
float few_split(uint32_t *left_mask, const Prim *prims, uint32_t count, F4 scale);
void few_partition(Range *left, Range *right, Prim *to, const Prim *from, const Range *range, uint32_t left_mask);

// Halves the range by centroid along its widest axis, equal ones by order.
void range_split_median(Range *left, Range *right, Prim *to, const Prim *from, const Range *range);
