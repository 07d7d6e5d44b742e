// Tiles of a light's maps (ShadowTile of shared/shadow.h): where hybrid shadows know something, and what a whole tile
// has in common.

#include "lib/lanes.cl"
#include "shared/raster.h"
#include "shared/shadow.h"
#include "shared/view.h"

// Number within its tile of block (x, y) of a map.
static inline uint tile_block(uint x, uint y) { return y % 4 * 4 + x % 4; }

// What all texels of the tile at `at` have in common, of a map of `size`.
static inline void tile_sum_up(global ShadowTile *tile, global const ShadowBlock *blocks, uint2 at, uint size)
{
  FloatL near = FLOATL(-INFINITY), covered = FLOATL(INFINITY);
  uint row_blocks = size / 4;
  for (uint i = 0; i < SHADOW_TILE_BLOCKS; i++) {
    if (at.x * 4 + i % 4 >= row_blocks || at.y * 4 + i / 4 >= row_blocks) continue;
    global const ShadowBlock *block = &blocks[tile->first_block + i];
    for (uint part = 0; part < 16; part += LANES) {
      near = max_lane(LANE_LOAD(block->first.near, part), near);
      covered = min_lane(LANE_LOAD(block->covered, part), covered);
    }
  }
  tile->near = greatest_lane(near);
  tile->covered = -greatest_lane(FLOATL(0) - covered);
}

// Could a caster that is no closer than `closest` matter in tiles [x0, x1] x [y0, y1]? True where they are many.
static inline bool tiles_want(global const ShadowTile *tiles, uint tile_columns, int4 range, float closest)
{
  for (int y = range.y; y <= range.w; y++)
    for (int x = range.x; x <= range.z; x++) {
      global const ShadowTile *tile = &tiles[(uint)y * tile_columns + (uint)x];
      if (tile->first_block != SHADOW_TILE_UNKNOWN && closest >= tile->least) return true;
    }
  return false;
}

// The same for all that is within bounds.
static inline bool tiles_want_bounds(global const ShadowTile *tiles, uint tile_columns,
                                     global const RasterBounds *bounds, constant RasterView *view)
{
  float2 low = (float2)(INFINITY, INFINITY), high = -low;
  float closest = -INFINITY;
  for (uint i = 0; i < 8; i++) {
    float x = (i & 1 ? bounds->high : bounds->low)[0] - view->origin.x,
          y = (i & 2 ? bounds->high : bounds->low)[1] - view->origin.y,
          z = (i & 4 ? bounds->high : bounds->low)[2] - view->origin.z;
    float w = view->parallel ? 1 : view->w.x * x + view->w.y * y + view->w.z * z + view->w.w;
    if (!(w > 2 * view->least_w)) return true;
    float depth = view->depth.x * x + view->depth.y * y + view->depth.z * z + view->depth.w;
    float2 at = (float2)(view->x.x * x + view->x.y * y + view->x.z * z + view->x.w,
                         view->y.x * x + view->y.y * y + view->y.z * z + view->y.w);
    low = min(low, at / w);
    high = max(high, at / w);
    closest = max(closest, view->parallel ? -depth : 1 / w);
  }
  // What rounding and padding may add.
  float last = (float)view->width - 1, pad = 1 + 1e-5f * (float)view->width;
  closest += 1e-4f * fabs(closest) + (view->parallel ? 1e-5f : 0);
  low = max(low - pad, (float2)(0, 0));
  high = min(high + pad, (float2)(last, last));
  if (!(low.x <= high.x && low.y <= high.y)) return false;
  int4 texels = convert_int4((float4)(low.x, low.y, high.x, high.y));
  return tiles_want(tiles, tile_columns, texels / SHADOW_TILE_PX, closest);
}
