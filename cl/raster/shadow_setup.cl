// Conservative raster of a light's maps, setup and binning: LANES triangles at a time, for all of the light's maps. As
// depth_setup.cl, but a triangle counts for every texel that it touches.
//
//   in    blocks, bounds    the scene's triangles (triangle_pack.cl)
//         views             [view_count], `columns` bins a side
//         marks             bit i % 32 of word i / 32: triangle i is marked
//         what              SURE_* of shared/shadow.h: what that means
//         tiles             [view_count][tile_columns][tile_columns] from first_tile on, which are to be known: what
//                           can only be in others, and what comes no closer than they ask, is left out
//   out   records  [view][chunk][RASTER_CHUNK + 1][SURE_WORDS] (shared/shadow.h)
//         spans, starts, lists   as depth_setup.cl
//
//   Where SURE_MARKED_SOLID is right: between the light and a point outside a closed, consistently wound mesh lie as
//   many of its triangles that face the light as are averted from it. If any of them stands in the way, so does an
//   averted one.
//   A lit surface is then not in the way of itself, and needs no bias.
//   At silhouettes of such meshes rounding lets a ray meet a front and pass the back beside it: who judges by the back
//   has to look for that (cl/rays/shadow_hybrid.cl).
//
//   Cost  10 to 16 ns a triangle and map on a core; 44 bytes read, 128 written for one that survives.

#include "lib/bins.cl"
#include "lib/sure_triangle.cl"

kernel void shadow_setup(global const RasterBlock *blocks, global const RasterBounds *bounds, uint first_chunk,
                         uint chunk_count, constant ShadowView *views, uint view_count, uint columns,
                         global const uint *marks, uint what, global const ShadowTile *tiles, uint first_tile,
                         uint tile_columns, global uint *records, global uint *spans, global uint *starts,
                         global ushort *lists)
{
  uint item = get_global_id(0), chunk = first_chunk + item % chunk_count;
  if (item >= chunk_count * view_count) return;
  constant ShadowView *view = &views[item / chunk_count];
  tiles += first_tile + item / chunk_count * tile_columns * tile_columns;
  BinRanges ranges;
  blocks += chunk * RASTER_CHUNK_BLOCKS;
  records += item * (RASTER_CHUNK + 1) * SURE_WORDS;
  starts += item * (columns * columns + 2);
  lists += item * (RASTER_CHUNK * RASTER_LARGE_BINS);
  ranges_clear(&ranges);
  bool wanted = bounds_on_map(&bounds[chunk], &view->raster) &&
                tiles_want_bounds(tiles, tile_columns, &bounds[chunk], &view->raster);
  uint count = wanted ? RASTER_CHUNK : 0;
  for (uint first = 0; first < count; first += LANES) {
    global const RasterBlock *block = &blocks[first / RASTER_STEP];
    block_prefetch(block + PREFETCH_BLOCKS);
    ListTriangle t;
    IntL box[4], marked, seen = list_setup(&t, box, &marked, blocks, first, view, marks, what, tiles, tile_columns);
    uint bits = lane_bits(seen);
    if (!bits) continue;

    UintL fields[SURE_WORDS], flags = LANE_LOAD(block->flags, first % RASTER_STEP);
    list_fields(fields, &t, box, LANE_AS_UINT(INTL((int)(chunk * RASTER_CHUNK + first)) + LANE_INDEX), flags, marked);
    for (uint i = SURE_VIEW; i < SURE_WORDS; i++) fields[i] = UINTL(0);
    IntL bin_px = INTL(RASTER_BIN_PX);
    UintL x = packed_range(box[0] / bin_px, box[2] / bin_px), y = packed_range(box[1] / bin_px, box[3] / bin_px);
    FloatL near_w = view->raster.parallel ? FLOATL(0) - t.near_most : FLOATL(1) / t.near_most;
    bins_take(&ranges, seen, bits, x, y, near_w, near_w, fields, SURE_WORDS, records);
  }
  bins_sort(&ranges, spans, item, chunk_count * view_count, starts, lists);
}
