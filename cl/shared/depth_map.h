// Depth maps as cl/raster writes them and whoever looks things up in them reads: float depth / w in [0, 1], 1 where
// nothing is. Square, row by row in blocks of 4 x 4 texels: texel (x, y) of a map of `size` is at depth_map_index(x, y,
// size).
#ifndef SHARED_DEPTH_MAP_H
#define SHARED_DEPTH_MAP_H

#include "shared/types.h"

static inline uint depth_map_index(uint x, uint y, uint size)
{
  return ((y / 4) * (size / 4) + x / 4) * 16 + y % 4 * 4 + x % 4;
}

// What bounds the texels of a block, 4 floats for its 16: LOW + BY_X x + BY_Y y is no more than texel (x, y) of it
// where something is there, HIGH + BY_X x + BY_Y y no less where all of it is; INFINITY where nothing is, or not all.
// But for rounding.
#define DEPTH_PLANE_LOW 0
#define DEPTH_PLANE_HIGH 1
#define DEPTH_PLANE_BY_X 2
#define DEPTH_PLANE_BY_Y 3
#define DEPTH_PLANES_ROWS 4  // of blocks, which one work-item bounds

// The same of squares of 4 x 4 blocks lies behind the planes of all maps of a light, where maps are of whole ones.
#define DEPTH_WIDE_PX 16

static inline int depth_map_is_wide(uint size) { return size % DEPTH_WIDE_PX == 0; }

// Floats of the planes of a map.
static inline uint depth_plane_floats(uint size) { return size / 4 * (size / 4) * 4; }
static inline uint depth_wide_floats(uint size)
{
  return depth_map_is_wide(size) ? size / DEPTH_WIDE_PX * (size / DEPTH_WIDE_PX) * 4 : 0;
}

#endif
