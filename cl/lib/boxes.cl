// The direct way to raster: a work-item draws a triangle whose box of pixels is small, and lists it otherwise, to be
// drawn tile by tile by teams of RASTER_TEAM work-items. LANES is 1.
//
// One 64-bit counter, the number of boxes << BOX_SHIFT | the number of their tiles, gives a box its place in the list
// and the number of its first tile at once. So these numbers rise along the list, and whoever is to draw a tile finds
// its box by binary search.
//
//   Needs cl_khr_int64_base_atomics.

#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

#include "lib/alpha.cl"
#include "shared/raster.h"

// AttributeSources, as kernel parameters.
#define ATTRIBUTE_PARAMETERS                                                                                       \
  global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors, uint vertex_count, \
      global const MaterialInfo *materials, global const TextureInfo *textures, global const uchar4 *texels,       \
      constant float *linear_from_byte

// The list, as kernel parameters.
#define BOX_PARAMETERS global RasterBox *boxes, global ulong *box_starts, global ulong *box_counter

#define BOX_SHIFT 40
#define BOX_TILES(counter) ((counter) & (((ulong)1 << BOX_SHIFT) - 1))

// The same within a work-group, in 32 bits: a box has no more than 2^19 tiles.
#define GROUP_BOX_SHIFT 25
#define GROUP_BOX_TILES(counter) ((counter) & ((1u << GROUP_BOX_SHIFT) - 1))
#if GROUP_SIZE > 64
#error "a work-group's boxes do not fit into its counter"
#endif

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

static inline RasterBox box_of(uint number, uint view, int4 bounds)
{
  RasterBox box = {number, view, (uint)bounds.x | (uint)bounds.z << 16, (uint)bounds.y | (uint)bounds.w << 16};
  return box;
}

// First and last pixel.
static inline int4 box_bounds(RasterBox box)
{
  return (int4)((int)(box.x & 0xffffu), (int)(box.y & 0xffffu), (int)(box.x >> 16), (int)(box.y >> 16));
}

static inline bool box_is_small(int x0, int y0, int x1, int y1)
{
  int width = x1 - x0 + 1, height = y1 - y0 + 1;
  return width <= RASTER_SMALL_PX && height <= RASTER_SMALL_PX && width * height <= RASTER_SMALL_PX;
}

// Pieces of 8 x 4 pixels are what a team draws at once: both slots of a wave and texels of a depth map keep a piece in
// one place, in the order of the team's members. Tiles start at a piece.
static inline int2 piece_start(int x, int y) { return (int2)(x & ~7, y & ~3); }
static inline int2 piece_pixel(uint member)
{
  return (int2)((int)(member / 16 * 4 + member % 4), (int)(member / 4 % 4));
}

static inline uint box_columns(int4 bounds) { return (uint)(bounds.z - (bounds.x & ~7)) / RASTER_TILE_PX + 1; }

static inline uint box_tiles(RasterBox box)
{
  int4 bounds = box_bounds(box);
  return box_columns(bounds) * ((uint)(bounds.w - (bounds.y & ~3)) / RASTER_TILE_PX + 1);
}

// Lists the boxes of a work-group, of those members that are `wanted`; every member calls it. `queued` and `first` are
// the group's own.
static inline void box_list(bool wanted, RasterBox box, local uint *queued, local ulong *first, BOX_PARAMETERS)
{
  if (get_local_id(0) == 0) *queued = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  uint before = wanted ? atomic_add(queued, 1u << GROUP_BOX_SHIFT | box_tiles(box)) : 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0 && *queued)
    *first = atom_add(box_counter, (ulong)(*queued >> GROUP_BOX_SHIFT) << BOX_SHIFT | GROUP_BOX_TILES(*queued));
  barrier(CLK_LOCAL_MEM_FENCE);
  if (!wanted) return;
  uint at = (uint)(*first >> BOX_SHIFT) + (before >> GROUP_BOX_SHIFT);
  boxes[at] = box;
  box_starts[at] = BOX_TILES(*first) + GROUP_BOX_TILES(before);
}

// The turn of a team: tiles [tile, end) of the list, box by box.
typedef struct BoxTurn {
  ulong tile, end;
  uint at;        // of the next box
  RasterBox box;  // the one to draw now, its tiles [from, to)
  uint from, to;
} BoxTurn;

// Turn `index` of all: false where there is none. `teams` are as many as take turns.
static inline bool box_turn(BoxTurn *turn, ulong index, ulong teams, global const ulong *box_starts, ulong counter)
{
  ulong all = BOX_TILES(counter), share = clamp(all / teams, (ulong)1, (ulong)RASTER_TURN_TILES);
  turn->tile = index * share;
  turn->end = min(turn->tile + share, all);
  if (turn->tile >= all) return false;
  uint low = 0, high = (uint)(counter >> BOX_SHIFT);  // the last box that starts at the tile or before it
  while (high - low > 1) {
    uint middle = (low + high) / 2;
    if (box_starts[middle] <= turn->tile)
      low = middle;
    else
      high = middle;
  }
  turn->at = low;
  return true;
}

// The next box of the turn: false where the turn has ended.
static inline bool box_next(BoxTurn *turn, global const RasterBox *boxes, global const ulong *box_starts)
{
  if (turn->tile >= turn->end) return false;
  ulong start = box_starts[turn->at];
  turn->box = boxes[turn->at++];
  turn->from = (uint)(turn->tile - start);
  turn->to = (uint)min((ulong)box_tiles(turn->box), turn->end - start);
  turn->tile = start + turn->to;
  return true;
}

// Tile `tile` of a box: its first pixel, and the box's last pixel in it.
static inline int4 box_tile(RasterBox box, uint tile)
{
  int4 bounds = box_bounds(box);
  int2 start = piece_start(bounds.x, bounds.y);
  uint columns = box_columns(bounds);
  start += (int2)((int)(tile % columns), (int)(tile / columns)) * RASTER_TILE_PX;
  return (int4)(start, min(bounds.zw, start + (RASTER_TILE_PX - 1)));
}
