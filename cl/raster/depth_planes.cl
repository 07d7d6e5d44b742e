// The planes that bound the blocks of depth maps, for lookups that ask about whole blocks (lib/shadow_kernel.cl).
//
//   in    maps    depths, from `first_texel` on, of `block_count` blocks (shared/depth_map.h)
//   out   maps    DEPTH_PLANE_* of each, from `first_plane` on
//
//   Cost  one work-item for DEPTH_PLANES_ITEM blocks, 3 ns a block; 64 bytes read, 16 written. Needs LANES above 1.
//   A block's plane goes through its corners where all of them hold something; else it is level.

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

kernel void depth_planes(global float *maps, uint first_texel, uint first_plane, uint block_count)
{
  uint begin = get_global_id(0) * DEPTH_PLANES_ITEM, end = min(begin + DEPTH_PLANES_ITEM, block_count);
  global const float *from = maps + first_texel;
  global float4 *to = (global float4 *)(maps + first_plane);
  FloatL one = FLOATL(1), nothing = FLOATL(INFINITY), sixth = FLOATL(1.0f / 6);
  for (uint first = begin; first < end; first += LANES) {
    FloatL texels[16], low = nothing, high = FLOATL(-INFINITY);
    blocks_load(texels, from + first * 16, LANE_INDEX < INTL((int)(end - first)));
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
    Sum planes = {vec3l(low, high, by_x), by_y};
    radiance_store(to + first, UINTL(0) + LANE_AS_UINT(LANE_INDEX), LANE_INDEX < INTL((int)(end - first)), planes);
  }
}
