// Slot of a wave -> pixel. Order as shared/stream.h says.

#include "shared/stream.h"

static inline uint2 tile_pixel(uint tile, uint within, uint tiles_per_row)
{
  uint block = within >> 4, inside = within & 15;
  uint2 pixel = (uint2)((block & 1) * 4 + (inside & 3), (block >> 1) * 4 + (inside >> 2));
  return pixel + (uint2)(tile % tiles_per_row, tile / tiles_per_row) * (uint)TILE_SIZE;
}

// The inverse: slot of a pixel within its tile.
static inline uint tile_slot(uint x, uint y) { return (y / 4 & 1) * 32 + (x / 4 & 1) * 16 + (y & 3) * 4 + (x & 3); }
