// The direct way to raster: a work-item draws a triangle whose box of pixels is small. What is larger is drawn tile by
// tile, by teams of RASTER_TEAM work-items: its box is listed to be split. LANES is 1.
//
// One 64-bit counter, the number of boxes << BOX_SHIFT | the number of their tiles, gives a box its place in the list
// and the number of its first tile at once. So these numbers rise along the list, and the work-item that looks at a
// tile of all finds its box by binary search. Tiles that the triangle does not meet, most of those of slivers and of
// triangles about the eye, go no further.
//
//   Needs cl_khr_int64_base_atomics and a GROUP_SIZE of one or two teams.

#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

#include "lib/alpha.cl"
#include "shared/raster.h"

// AttributeSources, as kernel parameters.
#define ATTRIBUTE_PARAMETERS                                                                                       \
  global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors, uint vertex_count, \
      global const MaterialInfo *materials, global const TextureInfo *textures, global const uchar4 *texels,       \
      constant float *linear_from_byte

// The lists, as kernel parameters: boxes to split, the number of the first tile of each, tiles, and how many there are.
// The first `room` tiles have a place, whoever finds others draws them alone. There are two sets of counts, for passes
// in turns: `set` is this pass's.
#define BOX_PARAMETERS \
  global RasterBox *boxes, global ulong *box_starts, global uint4 *tiles, global ulong *box_counts, uint room, uint set

// The pass's counts.
#define BOX_COUNTS (box_counts + set * RASTER_BOX_COUNTS)

#define BOX_SHIFT 40
#define BOX_TILES(counter) ((counter) & (((ulong)1 << BOX_SHIFT) - 1))

// The same within a work-group, in 32 bits: a box has no more than 2^19 tiles.
#define GROUP_BOX_SHIFT 25
#define GROUP_BOX_TILES(counter) ((counter) & ((1u << GROUP_BOX_SHIFT) - 1))
#if GROUP_SIZE > 64 || GROUP_SIZE % RASTER_TEAM
#error "a work-group's boxes do not fit into its counter, or it is not of whole teams"
#endif

// The bits of a depth that is at `depth` now: what is not below or equal to it is hidden. A look that saves most
// atomics. It races with them, harmlessly: depths only fall, and one that has fallen since costs an atomic. Checkers
// for races may do without (-D WITHOUT_PEEKS).
static inline uint depth_now(global const uint *depth)
{
#ifdef WITHOUT_PEEKS
  return UINT_MAX;
#else
  return *depth;
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
// one place, in the order of the team's members. Tiles start at a piece. A member first marks those of its pixels that
// are within the edges, bit 4 row + column for a piece of the tile, and then draws these: a team's members do together
// what takes long.
#define TILE_COLUMNS (RASTER_TILE_PX / 8)
#define TILE_ROWS (RASTER_TILE_PX / 4)
#if TILE_COLUMNS > 4 || TILE_ROWS > 8 || TILE_ROWS % 4
#error "a tile's pieces are more than a word has bits, or cannot be shared"
#endif

static inline int2 piece_start(int2 pixel) { return (int2)(pixel.x & ~7, pixel.y & ~3); }
static inline int2 piece_pixel(void)
{
  uint member = get_global_id(0) % RASTER_TEAM;
  return (int2)((int)(member / 16 * 4 + member % 4), (int)(member / 4 % 4));
}
static inline int2 piece_offset(uint bit) { return (int2)((int)(bit % 4 * 8), (int)(bit / 4 * 4)); }

// The bits of a member's pixels, of which the first is at `first`, that are not beyond `last`.
static inline uint pieces_within(int2 first, int2 last)
{
  int2 count = (last - first + (int2)(8, 4)) / (int2)(8, 4);
  uint row = (1u << clamp(count.x, 0, 4)) - 1;
  return count.y >= 8 ? row * 0x11111111u : row * 0x11111111u & ((1u << 4 * max(count.y, 0)) - 1);
}

// Where tiles are so few that teams would stand idle, two or four teams draw one: each some rows of its pieces.
typedef struct TileShare {
  int first_row, end_row;
} TileShare;

static inline uint tile_teams(uint tiles)
{
  uint teams = get_global_size(0) / RASTER_TEAM;
  return tiles <= teams / 4 ? 4 : tiles <= teams / 2 ? 2 : 1;
}

static inline TileShare tile_share(uint team, uint teams)
{
  int rows = TILE_ROWS / (int)teams;
  TileShare share = {(int)team * rows, (int)team * rows + rows};
  return share;
}

static inline uint share_bits(TileShare share)
{
  return 0xffffffffu << 4 * share.first_row & 0xffffffffu >> (32 - 4 * share.end_row);
}

// Takes the lowest four bits; where fewer are left the last stands again. Depths of four pixels are looked at together:
// a member then waits for memory once, not for each.
static inline uint4 bits_take(uint *bits)
{
  uint4 at;
  at.x = lowest_bit(*bits);
  *bits &= *bits - 1;
  at.y = *bits ? lowest_bit(*bits) : at.x;
  *bits &= *bits - 1;
  at.z = *bits ? lowest_bit(*bits) : at.y;
  *bits &= *bits - 1;
  at.w = *bits ? lowest_bit(*bits) : at.z;
  *bits &= *bits - 1;
  return at;
}

// Clears the other set of counts, which nobody uses now: the next pass begins with it.
static inline void counts_turn(global ulong *box_counts, uint set)
{
  if (get_global_id(0) < RASTER_BOX_COUNTS) box_counts[(1 - set) * RASTER_BOX_COUNTS + get_global_id(0)] = 0;
}

static inline uint box_columns(int4 bounds) { return (uint)(bounds.z - (bounds.x & ~7)) / RASTER_TILE_PX + 1; }

static inline uint box_tile_count(RasterBox box)
{
  int4 bounds = box_bounds(box);
  return box_columns(bounds) * ((uint)(bounds.w - (bounds.y & ~3)) / RASTER_TILE_PX + 1);
}

// Gives places in `tiles` to the members of a work-group that are `wanted`; every member calls it. The place may be
// beyond the list's room. `queued` and `first` are the group's own.
static inline uint tile_place(bool wanted, local uint *queued, local ulong *first, global ulong *box_counts)
{
  if (get_local_id(0) == 0) *queued = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  uint before = wanted ? atomic_inc(queued) : 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0 && *queued) *first = atom_add(&box_counts[RASTER_TILE_COUNT], (ulong)*queued);
  barrier(CLK_LOCAL_MEM_FENCE);
  return wanted ? (uint)min(*first + before, (ulong)UINT_MAX) : 0;
}

// Lists the boxes of the members of a work-group that have any `tiles`; every member calls it.
static inline void box_list(uint tiles, RasterBox box, local uint *queued, local ulong *first, global RasterBox *boxes,
                            global ulong *box_starts, global ulong *box_counts)
{
  if (get_local_id(0) == 0) *queued = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  uint before = tiles > 0 ? atomic_add(queued, 1u << GROUP_BOX_SHIFT | tiles) : 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0 && *queued)
    *first = atom_add(&box_counts[RASTER_BOX_COUNT],
                      (ulong)(*queued >> GROUP_BOX_SHIFT) << BOX_SHIFT | GROUP_BOX_TILES(*queued));
  barrier(CLK_LOCAL_MEM_FENCE);
  if (tiles == 0) return;
  uint at = (uint)(*first >> BOX_SHIFT) + (before >> GROUP_BOX_SHIFT);
  boxes[at] = box;
  box_starts[at] = BOX_TILES(*first) + GROUP_BOX_TILES(before);
}

// Tile `tile` of all tiles of boxes to split, as a box.
static inline RasterBox box_tile(ulong tile, global const RasterBox *boxes, global const ulong *box_starts,
                                 uint box_count)
{
  uint low = 0, high = box_count;  // the last box that starts at the tile or before it
  while (high - low > 1) {
    uint middle = (low + high) / 2;
    if (box_starts[middle] <= tile)
      low = middle;
    else
      high = middle;
  }
  RasterBox box = boxes[low];
  int4 bounds = box_bounds(box);
  uint within = (uint)(tile - box_starts[low]), columns = box_columns(bounds);
  int2 start = piece_start(bounds.xy);
  int x = start.x + (int)(within % columns) * RASTER_TILE_PX, y = start.y + (int)(within / columns) * RASTER_TILE_PX;
  return box_of(box.number, box.view,
                (int4)(max(x, bounds.x), max(y, bounds.y), min(x + RASTER_TILE_PX - 1, bounds.z),
                       min(y + RASTER_TILE_PX - 1, bounds.w)));
}

// Takes the next tiles of the list (or shares of tiles), one for each team of a work-group, and returns the first's
// number; every member calls it. Tiles differ much in what they cost: if a team had every so many, all would wait for
// the unluckiest. (A loop that ends by what this returns is compiled right by PoCL 3.1, one that ends by a condition in
// it is not.)
static inline uint tiles_take(local ulong *first, global ulong *box_counts)
{
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0) *first = atom_add(&box_counts[RASTER_TAKEN_COUNT], (ulong)(GROUP_SIZE / RASTER_TEAM));
  barrier(CLK_LOCAL_MEM_FENCE);
  return (uint)*first;
}
