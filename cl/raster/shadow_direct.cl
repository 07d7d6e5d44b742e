// Conservative raster of a light's maps on a GPU: what shadow_bins.cl makes, by work-groups.
//
//   in    blocks, bounds, views, marks, what, tiles          as shadow_setup.cl
//   out   tiles, blocks, rows                                as shadow_bins.cl, whose lists these are; here all known
//                                                            tiles have blocks
//
//   shadow_take    a work-item a triangle and view: its record, and how many each bin has
//   shadow_place   a work-item a bin: where its list begins
//   shadow_fill    work-items that go through the records: the lists
//   shadow_squares a work-group a square of GROUP_SIZE texels of a known tile: each has a work-item, which keeps what
//                  the texel knows in registers. GROUP_SIZE triangles of the bin's list at a time are tried on the
//                  square, one a work-item, and then those of each block draw what is on it.
//   shadow_sum_up  a work-item a tile: what its texels have in common
//
//   Cost  on an H100, for all of the maps of a picture's lights (all tiles known), 0.6 ms (12 k triangles), 2.9 (120 k)
//   and 6 to 8.5 (740 and 970 k); 100 bytes written for a triangle and view that survive, 8 read for each square of a
//   bin that it is in; 20 to 76 bytes written a texel.
//   Lists come in any order, texels do not depend on it (lib/sure_texels.cl). LANES is 1. Records and lists have room
//   for every triangle and view of a pass: nothing overflows.

#include "lib/sure_texels.cl"
#include "lib/sure_tiles.cl"
#include "lib/sure_triangle.cl"

#if GROUP_SIZE % 32 || GROUP_SIZE > 128
#error "a square is not of whole rows of blocks of one tile"
#endif

#define SQUARE_BLOCKS (GROUP_SIZE / 16)  // in rows of two
#define SQUARE_ROWS (SQUARE_BLOCKS / 2)

// Bins of a record: first and last.
static inline int4 record_bins(global const uint *record)
{
  uint x = record[SURE_TEXELS], y = record[SURE_TEXELS + 1];
  return convert_int4((uint4)(x & 0xffffu, y & 0xffffu, x >> 16, y >> 16)) / SURE_BIN_PX;
}

static inline bool record_is_large(int4 bins)
{
  return (bins.z - bins.x + 1) * (bins.w - bins.y + 1) > RASTER_LARGE_BINS;
}

// A view's lists are its bins', and that of large triangles, which every bin looks at.
static inline uint list_of_view(uint view, uint columns) { return view * (columns * columns + 1); }

kernel void shadow_take(global const RasterBlock *blocks, global const RasterBounds *bounds, uint first_triangle,
                        uint triangle_count, constant ShadowView *views, uint view_count, uint columns,
                        global const uint *marks, uint what, global const ShadowTile *tiles, uint first_tile,
                        uint tile_columns, global uint *records, global uint *counts)
{
  local uint queued, first;
  uint item = get_global_id(0), number = first_triangle + item % triangle_count, view = item / triangle_count;
  if (view >= view_count) return;  // whole work-groups, here and below: a chunk is of whole ones
  tiles += first_tile + view * tile_columns * tile_columns;
  global const RasterBounds *chunk = &bounds[number / RASTER_CHUNK];
  if (!bounds_on_map(chunk, &views[view].raster)) return;
  if (!tiles_want_bounds(tiles, tile_columns, chunk, &views[view].raster)) return;
  ListTriangle t;
  int box[4], marked,
      seen = list_setup(&t, box, &marked, blocks, number, &views[view], marks, what, tiles, tile_columns);
  if (get_local_id(0) == 0) queued = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  uint before = seen ? atomic_inc(&queued) : 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (get_local_id(0) == 0) first = atomic_add(&counts[SURE_RECORD_COUNT], queued);
  barrier(CLK_LOCAL_MEM_FENCE);
  if (!seen) return;
  uint fields[SURE_VIEW];
  list_fields(fields, &t, box, number, blocks[number / RASTER_STEP].flags[number % RASTER_STEP], marked);
  global uint *record = records + (first + before) * SURE_DIRECT_WORDS;
  for (uint i = 0; i < SURE_VIEW; i++) record[i] = fields[i];
  record[SURE_VIEW] = view;
  int4 bins = (int4)(box[0], box[1], box[2], box[3]) / SURE_BIN_PX;
  global uint *count = counts + SURE_COUNTS + list_of_view(view, columns);
  if (record_is_large(bins)) {
    atomic_inc(&count[columns * columns]);
    return;
  }
  for (int y = bins.y; y <= bins.w; y++)
    for (int x = bins.x; x <= bins.z; x++) atomic_inc(&count[(uint)y * columns + (uint)x]);
}

kernel void shadow_place(uint list_count, global uint *counts, global uint *starts, global uint *ends)
{
  uint list = get_global_id(0);
  if (list < list_count) starts[list] = ends[list] = atomic_add(&counts[SURE_LIST_COUNT], counts[SURE_COUNTS + list]);
}

kernel void shadow_fill(uint columns, global const uint *records, global const uint *counts, global uint *ends,
                        global uint *lists)
{
  uint all = counts[SURE_RECORD_COUNT];
  for (uint i = get_global_id(0); i < all; i += get_global_size(0)) {
    global const uint *record = records + i * SURE_DIRECT_WORDS;
    int4 bins = record_bins(record);
    global uint *end = ends + list_of_view(record[SURE_VIEW], columns);
    if (record_is_large(bins)) {
      lists[atomic_inc(&end[columns * columns])] = i;
      continue;
    }
    for (int y = bins.y; y <= bins.w; y++)
      for (int x = bins.x; x <= bins.z; x++) lists[atomic_inc(&end[(uint)y * columns + (uint)x])] = i;
  }
}

// What a work-item's texel knows.
typedef struct Texel {
  float covered, rest, near[SHADOW_NUMBERS];
  uint number[SHADOW_NUMBERS];
} Texel;

static inline Texel texel_load(global const ShadowBlock *block, global const ShadowRow *rows, uint block_count,
                               uint entry, bool begin, float least)
{
  Texel texel;
  uint row_count = begin ? 0 : block->row_count;
  texel.covered = begin ? -INFINITY : block->covered[entry];
  texel.rest = begin ? least : block->rest[entry];
#pragma unroll
  for (uint k = 0; k < SHADOW_NUMBERS; k++) {
    global const ShadowRow *row = k ? &rows[(k - 1) * block_count] : &block->first;
    texel.near[k] = k < row_count ? row->near[entry] : -INFINITY;
    texel.number[k] = k < row_count ? row->number[entry] : UINT_MAX;
  }
  return texel;
}

// Stores a texel; rows from `row_count` on, which no texel of the block needs, but for the first are left alone. (With
// `#pragma unroll` here PoCL 5 loses numbers; compilers for GPUs unroll it all the same.)
static inline void texel_store(const Texel *texel, global ShadowBlock *block, global ShadowRow *rows, uint block_count,
                               uint entry, uint row_count)
{
  block->covered[entry] = texel->covered;
  block->rest[entry] = texel->rest;
  if (entry == 0) block->row_count = row_count;
  for (uint k = 0; k < SHADOW_NUMBERS; k++) {
    if (k && k >= row_count) continue;
    global ShadowRow *row = k ? &rows[(k - 1) * block_count] : &block->first;
    row->near[entry] = texel->near[k];
    row->number[entry] = texel->number[k];
  }
}

// Draws a triangle into texel `at_px` of the block whose first texel is at `first`.
static inline void texel_draw(Texel *texel, const ListRecord *t, int2 at_px, int2 first)
{
  ListLanes lanes = list_lanes(t, (float)at_px.x, (float)at_px.y),
            at = list_lanes_at(&lanes, t, (float)first.x, (float)first.y);
  if (!list_touches(&at, t, at_px.x, at_px.y, first)) return;
  float most = min_lane(at.near, t->near_most);
  if (!(most >= texel->covered)) return;
  if (t->hides) texel->covered = list_cover(&at, t, 1, most, texel->covered);
  if (!(most >= texel->rest)) return;
  uint number = t->number;
#pragma unroll
  for (uint k = 0; k < SHADOW_NUMBERS; k++) list_enter(&texel->near[k], &texel->number[k], &most, &number);
  texel->rest = max_lane(most, texel->rest);
}

// Blocks of the square at `low` that a record's texels are in: bit i for block i.
static inline uint record_blocks(global const uint *record, uint2 low)
{
  uint x = record[SURE_TEXELS], y = record[SURE_TEXELS + 1], meets = 0;
  for (uint i = 0; i < SQUARE_BLOCKS; i++) {
    uint2 at = low + (uint2)(i % 2, i / 2) * 4;
    bool met = (x & 0xffffu) < at.x + 4 && x >> 16 >= at.x && (y & 0xffffu) < at.y + 4 && y >> 16 >= at.y;
    meets |= (uint)met << i;
  }
  return meets;
}

kernel void shadow_squares(uint size, uint view_count, uint columns, global const uint *records,
                           global const uint *starts, global const uint *ends, global const uint *lists,
                           global const ShadowTile *tiles, uint first_tile, uint tile_columns,
                           global ShadowBlock *blocks, global ShadowRow *rows, uint block_count)
{
  local uint found[SQUARE_BLOCKS][GROUP_SIZE], counts[SQUARE_BLOCKS];
  uint square_columns = tile_columns * 2, squares = square_columns * tile_columns * (4 / SQUARE_ROWS);
  uint view = get_group_id(0) / squares, square = get_group_id(0) % squares, member = get_local_id(0);
  if (view >= view_count) return;
  uint2 first_block = (uint2)(square % square_columns * 2, square / square_columns * SQUARE_ROWS);
  global const ShadowTile *tile =
      &tiles[first_tile + (view * tile_columns + first_block.y / 4) * tile_columns + first_block.x / 4];
  if (tile->first_block == SHADOW_TILE_UNKNOWN) return;  // all of the work-group
  uint2 at = first_block + (uint2)(member / 16 % 2, member / 32);
  uint entry = member % 16, index = tile->first_block + tile_block(at.x, at.y);
  bool begin = !(tile->near > -INFINITY);
  Texel texel = texel_load(&blocks[index], &rows[index], block_count, entry, begin, tile->least);
  int2 at_px = (int2)((int)(entry % 4), (int)(entry / 4)), first_px = convert_int2(at) * 4;

  uint2 low = first_block * 4;
  uint list = list_of_view(view, columns) + low.y / SURE_BIN_PX * columns + low.x / SURE_BIN_PX;
  uint large = list_of_view(view, columns) + columns * columns;
  uint binned = ends[list] - starts[list], all = binned + ends[large] - starts[large];
  for (uint first = 0; first < all; first += GROUP_SIZE) {
    uint place = first + member, meets = 0, number = 0;
    if (place < all) {
      number = lists[place < binned ? starts[list] + place : starts[large] + place - binned];
      meets = record_blocks(records + number * SURE_DIRECT_WORDS, low);
    }
    if (member < SQUARE_BLOCKS) counts[member] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (; meets; meets &= meets - 1) {
      uint block = lowest_bit(meets);
      found[block][atomic_inc(&counts[block])] = number;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = 0; i < counts[member / 16]; i++) {
      ListRecord record = list_record(records + found[member / 16][i] * SURE_DIRECT_WORDS);
      texel_draw(&texel, &record, at_px, first_px);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }

  uint used = 0;
#pragma unroll
  for (uint k = 0; k < SHADOW_NUMBERS; k++) used += texel.near[k] > -INFINITY;
  if (entry == 0) counts[member / 16] = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  atomic_max(&counts[member / 16], used);
  barrier(CLK_LOCAL_MEM_FENCE);
  uint row_count = counts[member / 16];
  texel_store(&texel, &blocks[index], &rows[index], block_count, entry, row_count);
  barrier(CLK_LOCAL_MEM_FENCE);  // without it PoCL 3.1 loses some of what is stored
}

kernel void shadow_sum_up(uint size, uint view_count, global ShadowTile *tiles, uint first_tile, uint tile_columns,
                          global const ShadowBlock *blocks)
{
  uint item = get_global_id(0), place = item % (tile_columns * tile_columns);
  tiles += first_tile;
  if (item >= view_count * tile_columns * tile_columns || tiles[item].first_block == SHADOW_TILE_UNKNOWN) return;
  tile_sum_up(&tiles[item], blocks, (uint2)(place % tile_columns, place / tile_columns), size);
}
