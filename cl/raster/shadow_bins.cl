// Conservative raster of a light's maps, one work-item a bin of a view: what each texel knows of the triangles that may
// stand in the way of a ray from a point that is seen through it.
//
//   in    records, spans, starts, lists   triangles by bin (shadow_setup.cl)
//         tiles  [view][tile_columns][tile_columns], which are to be known (shadow_mark.cl); before the first pass
//                `near` and `covered` are -INFINITY
//   out   tiles, blocks, rows   shared/shadow.h
//
//   For each texel of those tiles: how close to the light one is everywhere in it that covers all of it; the closest
//   SHADOW_NUMBERS triangles before that, with how close each comes; and how close any other comes. What comes no
//   closer than the tile's least close receiver is left out, and tiles in which nothing then is are not written.
//   Cost  14 ns a texel that something is drawn in on a core in a room, 21 in a colonnade, several times that where all
//   lists are full; 20 to 76 bytes a texel.
//   Tiles are added to: a scene may have several passes.
//
//   From  Lloyd, Wendt, Govindaraju, Manocha, "CC Shadow Volumes", 2004 (what is lit or dark for sure); Bavoil,
//         Callahan, Lefohn, Comba, Silva, "Multi-Fragment Effects on the GPU using the k-Buffer", 2007 (the lists).

#include "lib/bins.cl"
#include "lib/sure_texels.cl"
#include "lib/sure_tiles.cl"

// Adds a triangle to the lists of a block's texels. A row that it needs is begun by all parts of the block.
static inline __attribute__((always_inline)) void block_enter(global ShadowBlock *block, uint part,
                                                              global ShadowRow *rows, uint block_count, IntL touched,
                                                              FloatL most, uint number)
{
  FloatL rest = LANE_LOAD(block->rest, part), none = FLOATL(-INFINITY);
  touched = touched & (most >= rest);
  most = touched ? most : none;
  UintL name = touched ? UINTL(number) : UINTL(UINT_MAX);
  global ShadowRow *row = &block->first;
  uint row_count = block->row_count;
  for (uint k = 0;; k++) {
    if (!any_lane(most > none)) return;
    if (k == row_count) break;
    FloatL near = LANE_LOAD(row->near, part);
    UintL named = LANE_LOAD(row->number, part);
    if (any_lane(list_enter(&near, &named, &most, &name))) {
      LANE_STORE(near, row->near, part);
      LANE_STORE(named, row->number, part);
    }
    row = rows + k * block_count;
  }
  if (row_count == SHADOW_NUMBERS) {
    LANE_STORE(max_lane(most, rest), block->rest, part);
    return;
  }
#if LANES < 16
  for (uint i = 0; i < 16; i += LANES) {
    LANE_STORE(none, row->near, i);
    LANE_STORE(UINTL(UINT_MAX), row->number, i);
  }
#endif
  LANE_STORE(most, row->near, part);
  LANE_STORE(name, row->number, part);
  block->row_count = row_count + 1;
}

#define BIN_COLUMNS (RASTER_BIN_PX / SHADOW_TILE_PX)

// The tiles of a bin.
typedef struct BinTiles {
  uint first_block[BIN_COLUMNS * BIN_COLUMNS];
  float least[BIN_COLUMNS * BIN_COLUMNS];
  uint begun;  // bit i: the blocks of tile i are there
} BinTiles;

// False where none of them is to be known.
static inline bool bin_tiles_load(BinTiles *of, global const ShadowTile *tiles, uint tile_columns, uint2 first)
{
  bool some = false;
  of->begun = 0;
  for (uint i = 0; i < BIN_COLUMNS * BIN_COLUMNS; i++) {
    uint x = first.x + i % BIN_COLUMNS, y = first.y + i / BIN_COLUMNS;
    of->first_block[i] = SHADOW_TILE_UNKNOWN;
    if (x >= tile_columns || y >= tile_columns) continue;
    global const ShadowTile *tile = &tiles[y * tile_columns + x];
    of->first_block[i] = tile->first_block;
    of->least[i] = tile->least;
    if (tile->near > -INFINITY) of->begun |= 1u << i;
    some |= tile->first_block != SHADOW_TILE_UNKNOWN;
  }
  return some;
}

static inline void tile_begin(global ShadowBlock *blocks, float least)
{
  for (uint i = 0; i < SHADOW_TILE_BLOCKS; i++) {
    for (uint part = 0; part < 16; part += LANES) {
      LANE_STORE(FLOATL(-INFINITY), blocks[i].covered, part);
      LANE_STORE(FLOATL(least), blocks[i].rest, part);
      LANE_STORE(FLOATL(-INFINITY), blocks[i].first.near, part);
    }
    blocks[i].row_count = 0;
  }
}

// Adds a triangle to the blocks of the bin at `px`.
static inline __attribute__((always_inline)) void list_draw(const ListRecord *t, BinTiles *tiles,
                                                            global ShadowBlock *blocks, global ShadowRow *rows,
                                                            uint block_count, int2 px, int2 end)
{
  int x0 = max(t->first_x, px.x) / 4, x1 = min(t->last_x, end.x - 1) / 4;
  int y0 = max(t->first_y, px.y) / 4, y1 = min(t->last_y, end.y - 1) / 4;
  for (uint part = 0; part < 16; part += LANES) {
    IntL lane = INTL((int)part) + LANE_INDEX;
    IntL lane_x = lane & INTL(3), lane_y = lane >> INTL(2);
    ListLanes lanes = list_lanes(t, LANE_CONVERT_FLOAT(lane_x), LANE_CONVERT_FLOAT(lane_y));
    for (int y = y0; y <= y1; y++) {
      for (int x = x0; x <= x1; x++) {
        uint tile = (uint)y / 4 % BIN_COLUMNS * BIN_COLUMNS + (uint)x / 4 % BIN_COLUMNS;
        if (tiles->first_block[tile] == SHADOW_TILE_UNKNOWN || t->near_most < tiles->least[tile]) continue;
        ListLanes at = list_lanes_at(&lanes, t, (float)(4 * x), (float)(4 * y));
        IntL touched = list_touches(&at, t, lane_x, lane_y, (int2)(4 * x, 4 * y));
        if (!any_lane(touched)) continue;
        FloatL most = min_lane(at.near, FLOATL(t->near_most));
        uint index = tiles->first_block[tile] + tile_block((uint)x, (uint)y);
        global ShadowBlock *block = &blocks[index];
        if (!(tiles->begun >> tile & 1)) {
          if (!any_lane(touched & (most >= FLOATL(tiles->least[tile])))) continue;
          tile_begin(&blocks[tiles->first_block[tile]], tiles->least[tile]);
          tiles->begun |= 1u << tile;
        }
        FloatL covered = LANE_LOAD(block->covered, part);
        touched = touched & (most >= covered);
        if (!any_lane(touched)) continue;
        if (t->hides) LANE_STORE(list_cover(&at, t, touched, most, covered), block->covered, part);
        block_enter(block, part, rows + index, block_count, touched, most, t->number);
      }
    }
  }
}

kernel void shadow_bins(uint size, uint view_count, uint columns, uint chunk_count, global const uint *records,
                        global const uint *spans, global const uint *starts, global const ushort *lists,
                        global ShadowTile *tiles, uint first_tile, uint tile_columns, global ShadowBlock *blocks,
                        global ShadowRow *rows, uint block_count)
{
  uint item = get_global_id(0), list = item % (columns * columns), view = item / (columns * columns);
  if (view >= view_count) return;
  uint2 bin = (uint2)(list % columns, list / columns), corner = bin * BIN_COLUMNS;
  int2 px = convert_int2(bin) * RASTER_BIN_PX, end = min(px + RASTER_BIN_PX, (int2)((int)size));
  BinTiles of;
  tiles += first_tile + view * tile_columns * tile_columns;
  if (!bin_tiles_load(&of, tiles, tile_columns, corner)) return;
  ulong keys[SORT_CHUNKS];
  uint all = view_count * chunk_count, last = (view + 1) * chunk_count;
  for (uint first = view * chunk_count; first < last; first += SORT_CHUNKS) {
    uint count = bin_chunks(keys, spans, all, first, min(first + SORT_CHUNKS, last), bin.x, bin.y);
    for (uint i = 0; i < count; i++) {
      uint chunk = (uint)keys[i];
      global const uint *from = records + chunk * (RASTER_CHUNK + 1) * SURE_WORDS;
      global const ushort *numbers = lists + chunk * (RASTER_CHUNK * RASTER_LARGE_BINS);
      BinLists in = bin_lists(spans, all, chunk, starts + chunk * (columns * columns + 2), bin.x, bin.y);
      for (uint large = 0; large < 2; large++) {
        for (uint k = in.begin[large]; k < in.end[large]; k++) {
          ListRecord record = list_record(from + numbers[k] * SURE_WORDS);
          list_draw(&record, &of, blocks, rows, block_count, px, end);
        }
      }
    }
  }
  for (uint bits = of.begun; bits; bits &= bits - 1) {
    uint i = lowest_bit(bits);
    uint2 at = corner + (uint2)(i % BIN_COLUMNS, i / BIN_COLUMNS);
    tile_sum_up(&tiles[at.y * tile_columns + at.x], blocks, at, size);
  }
}
