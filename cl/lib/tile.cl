// Slot of a wave -> pixel. Order as shared/stream.h says. `grid`: tiles across and down the picture.

#include "shared/camera.h"
#include "shared/stream.h"

// Tiles across and down the picture.
static inline uint2 camera_tiles(constant CameraInfo *camera)
{
  return (uint2)(camera->tiles_per_row, (camera->height + TILE_SIZE - 1) / TILE_SIZE);
}

// Column and row of a tile.
static inline uint2 tile_at(uint tile, uint2 grid)
{
  uint row_tiles = grid.x * BIN_TILES, row = tile / row_tiles, in_row = tile - row * row_tiles;
  uint height = min((uint)BIN_TILES, grid.y - row * BIN_TILES);
  uint column = in_row / (BIN_TILES * BIN_TILES);
  if (height < BIN_TILES) column = in_row / (BIN_TILES * height);
  uint in_bin = in_row - column * BIN_TILES * height, width = min((uint)BIN_TILES, grid.x - column * BIN_TILES);
  uint2 within = (uint2)(in_bin % BIN_TILES, in_bin / BIN_TILES);
  if (width < BIN_TILES) within = (uint2)(in_bin % width, in_bin / width);
  return (uint2)(column, row) * (uint)BIN_TILES + within;
}

// The inverse, for tiles of the picture.
static inline uint tile_number(uint2 at, uint2 grid)
{
  uint2 bin = at / (uint)BIN_TILES, within = at % (uint)BIN_TILES;
  uint height = min((uint)BIN_TILES, grid.y - bin.y * BIN_TILES);
  uint width = min((uint)BIN_TILES, grid.x - bin.x * BIN_TILES);
  return (bin.y * grid.x + bin.x * height) * BIN_TILES + within.y * width + within.x;
}

// Pixel of a slot within its tile.
static inline uint2 within_tile(uint slot)
{
  uint block = slot >> 4, inside = slot & 15;
  return (uint2)((block & 1) * 4 + (inside & 3), (block >> 1) * 4 + (inside >> 2));
}

static inline uint2 tile_pixel(uint tile, uint within, uint2 grid)
{
  return within_tile(within) + tile_at(tile, grid) * (uint)TILE_SIZE;
}

// The inverse of within_tile.
static inline uint tile_slot(uint x, uint y) { return (y / 4 & 1) * 32 + (x / 4 & 1) * 16 + (y & 3) * 4 + (x & 3); }
