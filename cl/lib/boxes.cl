// Size classes of the direct way to raster: a work-item draws a triangle whose box of pixels is small, and lists it
// otherwise. LANES is 1.

#include "lib/alpha.cl"
#include "shared/raster.h"

// AttributeSources, as kernel parameters.
#define ATTRIBUTE_PARAMETERS                                                                                       \
  global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors, uint vertex_count, \
      global const MaterialInfo *materials, global const TextureInfo *textures, global const uchar4 *texels,       \
      constant float *linear_from_byte

// The lists, as kernel parameters of who fills them.
#define BOX_PARAMETERS global RasterBox *medium, global RasterBox *large, global uint *counts

// Could `bits` (of a depth) be below, or equal to, what is at `depth` now? A look that saves most atomics. It races
// with them, harmlessly: depths only fall, and one that has fallen since costs an atomic. Checkers for races may do
// without (-D WITHOUT_PEEKS).
static inline bool depth_may_fall(volatile global const uint *depth, uint bits)
{
#ifdef WITHOUT_PEEKS
  return true;
#else
  return bits <= *depth;
#endif
}

// Lists the triangle unless it is small; returns whether it has. `whole`: only a work-group may draw it.
static inline bool box_list(uint number, uint view, int x0, int y0, int x1, int y1, bool whole, BOX_PARAMETERS)
{
  int width = x1 - x0 + 1, height = y1 - y0 + 1;
  bool small = width <= RASTER_SMALL_PX && height <= RASTER_SMALL_PX && width * height <= RASTER_SMALL_PX;
  if (small && !whole) return false;
  bool fits = width <= RASTER_MEDIUM_PX && height <= RASTER_MEDIUM_PX && !whole;
  RasterBox box = {number, view, (uint)x0 | (uint)x1 << 16, (uint)y0 | (uint)y1 << 16};
  uint at = atomic_inc(&counts[fits ? RASTER_MEDIUM_COUNT : RASTER_LARGE_COUNT]);
  if (fits)
    medium[at] = box;
  else
    large[at] = box;
  return true;
}

// Triangles that wait for a work-group to draw them in its tile.
#define QUEUE_SIZE (2 * GROUP_SIZE)

// Adds those of GROUP_SIZE large triangles, from `first` on, whose boxes meet the tile at pixel (x, y) of a view;
// returns how many there are then. Every work-item of the group calls it. The caller empties the queue before it holds
// more than GROUP_SIZE.
static inline uint boxes_gather(local uint *queue, local uint *queued, global const RasterBox *large, uint first,
                                uint count, uint view, uint x, uint y)
{
  uint at = first + get_local_id(0);
  if (at < count) {
    RasterBox box = large[at];
    bool meets = box.view == view && (box.x & 0xffffu) < x + RASTER_TILE_PX && (box.x >> 16) >= x &&
                 (box.y & 0xffffu) < y + RASTER_TILE_PX && (box.y >> 16) >= y;
    if (meets) queue[atomic_inc(queued)] = box.number;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  return *queued;
}

// Empties it, for every work-item of the group to call before the first triangle and when all have been drawn.
static inline void queue_clear(local uint *queued)
{
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0) *queued = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
}
