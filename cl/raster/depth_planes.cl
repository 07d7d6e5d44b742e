// The planes that bound the blocks of depth maps, for lookups that ask about whole blocks (lib/shadow_kernel.cl).
//
//   in    maps    depths, from `first_texel` on, of `view_count` maps of `size` (shared/depth_map.h)
//   out   maps    behind them DEPTH_PLANE_* of each block, and of each square of blocks
//
//   Cost  one work-item for DEPTH_PLANES_ROWS rows of blocks, 4 ns a block; 64 bytes read, 17 written. Needs LANES
//   above 1. A plane goes through a block's corners, or a square's corner blocks, where all of them hold something;
//   else it is level.

#include "lib/radiance.cl"
#include "lib/transpose.cl"
#include "shared/depth_map.h"
#include "shared/raster.h"

// The texels of LANES blocks, of which those of `there` are.
static inline void blocks_load(FloatL texels[16], global const float *from, IntL there)
{
#if LANES == 16
  if (lane_bits(there) == 0xffff) {
    UintL rows[16];
#pragma unroll
    for (uint i = 0; i < 16; i++) rows[i] = LANE_AS_UINT(vload16(i, from));
    transpose16(rows);
#pragma unroll
    for (uint i = 0; i < 16; i++) texels[i] = LANE_AS_FLOAT(rows[i]);
    return;
  }
#endif
  IntL at = there ? (INTL(0) + LANE_INDEX) * INTL(16) : INTL(0);
  for (uint i = 0; i < 16; i++) texels[i] = LANE_GATHER(FloatL, from + i, at);
}

// The planes of blocks [begin, end).
static inline void blocks_bound(global float4 *planes, global const float *texels_from, uint begin, uint end)
{
  FloatL one = FLOATL(1), nothing = FLOATL(INFINITY), sixth = FLOATL(1.0f / 6);
  for (uint first = begin; first < end; first += LANES) {
    FloatL texels[16], low = nothing, high = FLOATL(-INFINITY);
    IntL there = LANE_INDEX < INTL((int)(end - first));
    blocks_load(texels, texels_from + first * 16, there);
    IntL whole = (texels[0] < one) & (texels[3] < one) & (texels[12] < one) & (texels[15] < one);
    FloatL by_x = (texels[3] - texels[0] + (texels[15] - texels[12])) * sixth;
    FloatL by_y = (texels[12] - texels[0] + (texels[15] - texels[3])) * sixth;
    by_x = whole ? by_x : FLOATL(0);
    by_y = whole ? by_y : FLOATL(0);
#pragma unroll
    for (uint i = 0; i < 16; i++) {
      FloatL level = texels[i] - (by_x * FLOATL((float)(i & 3)) + by_y * FLOATL((float)(i >> 2)));
      level = texels[i] < one ? level : nothing;
      low = min_lane(level, low);
      high = max_lane(level, high);
    }
    Sum bounds = {vec3l(low, high, by_x), by_y};
    radiance_store(planes + first, UINTL(0) + LANE_AS_UINT(LANE_INDEX), there, bounds);
  }
}

// Those of a row of squares, from four rows of planes.
static inline void squares_bound(global float4 *squares, global const float *planes_from, uint count)
{
  const FloatL zero = FLOATL(0), nothing = FLOATL(INFINITY), share = FLOATL(1.0f / 24), thrice = FLOATL(3);
  for (uint first = 0; first < count; first += LANES) {
    FloatL planes[4][16], low = nothing, high = FLOATL(-INFINITY);
    IntL there = LANE_INDEX < INTL((int)(count - first));
#pragma unroll
    for (uint y = 0; y < 4; y++) blocks_load(planes[y], planes_from + (y * count + first) * 16, there);
    FloatL left = planes[0][DEPTH_PLANE_LOW], right = planes[0][12 + DEPTH_PLANE_LOW];
    FloatL below_left = planes[3][DEPTH_PLANE_LOW], below_right = planes[3][12 + DEPTH_PLANE_LOW];
    IntL whole = (left < nothing) & (right < nothing) & (below_left < nothing) & (below_right < nothing);
    FloatL by_x = whole ? (right - left + (below_right - below_left)) * share : zero;
    FloatL by_y = whole ? (below_left - left + (below_right - right)) * share : zero;
#pragma unroll
    for (uint i = 0; i < 16; i++) {
      const FloatL *of = &planes[i / 4][i % 4 * 4];
      FloatL more_x = (of[DEPTH_PLANE_BY_X] - by_x) * thrice, more_y = (of[DEPTH_PLANE_BY_Y] - by_y) * thrice;
      FloatL level = by_x * FLOATL((float)(i % 4 * 4)) + by_y * FLOATL((float)(i / 4 * 4));
      low = min_lane(of[DEPTH_PLANE_LOW] - level + min_lane(more_x, zero) + min_lane(more_y, zero), low);
      high = max_lane(of[DEPTH_PLANE_HIGH] - level + max_lane(more_x, zero) + max_lane(more_y, zero), high);
    }
    Sum bounds = {vec3l(low, high, by_x), by_y};
    radiance_store(squares + first, UINTL(0) + LANE_AS_UINT(LANE_INDEX), there, bounds);
  }
}

kernel void depth_planes(global float *maps, uint first_texel, uint size, uint view_count)
{
  const uint texels = view_count * size * size, item = get_global_id(0), item_blocks = size / 4 * DEPTH_PLANES_ROWS;
  const uint begin = item * item_blocks, end = min(begin + item_blocks, texels / 16);
  if (begin >= end) return;
  global float *planes = maps + first_texel + texels, *squares = planes + view_count * depth_plane_floats(size);
  blocks_bound((global float4 *)planes, maps + first_texel, begin, end);
  if (!depth_map_is_wide(size)) return;
  const uint count = size / DEPTH_WIDE_PX;
  squares_bound((global float4 *)squares + item * count, planes + begin * 4, count);
}
