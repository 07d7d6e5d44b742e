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

#endif
