// Vertex transform, culling, setup and binning for camera visibility, LANES triangles at a time, for all views of a
// table.
//
//   in    blocks, bounds    the scene's triangles (triangle_pack.cl)
//         items             chunks and views, of which [first_item, first_item + item_count) are set up
//         views, offsets    cameras and sample positions; bins of rows [first_row, first_row + rows) of each view
//         hidden            ranges of triangle ids that are not there, [hidden_count]
//   out   records  [item][RASTER_CHUNK + 1][VISIBLE_WORDS], packed: triangles that may be seen
//         spans    [SPAN_FIELDS][item]
//         starts   [item][bins + 2], lists [item][RASTER_CHUNK * RASTER_LARGE_BINS]: records by bin (lib/bins.cl)
//
//   Cost  one work-item a chunk and view; 44 bytes read a triangle, 64 written for one that survives.
//   Culled: what is outside the picture or the depth range, turns a single-sided back, or lies between all samples.
//   Each chunk has room of its own: no atomics, no scan over all, the same lists whatever the threads.

#include "lib/bins.cl"
#include "lib/visible.cl"

kernel void visibility_setup(global const RasterBlock *blocks, global const RasterBounds *bounds,
                             global const RasterItem *items, uint first_item, uint item_count,
                             constant RasterView *views, global const uint2 *hidden, uint hidden_count,
                             constant Float2 *offsets, uint sample_count, uint columns, uint first_row, uint rows,
                             global uint *records, global uint *spans, global uint *starts, global ushort *lists)
{
  uint item = spread_item(get_global_id(0), item_count);
  if (item >= item_count) return;
  uint chunk = items[first_item + item].chunk, number = items[first_item + item].view;
  if (number == RASTER_UNSEEN) return;
  constant RasterView *view = &views[number];
  uint first_y = first_row * RASTER_BIN_PX, end_y = min((first_row + rows) * RASTER_BIN_PX, view->height);
  BinRanges ranges;
  blocks += chunk * RASTER_CHUNK_BLOCKS;
  records += item * (RASTER_CHUNK + 1) * VISIBLE_WORDS;
  starts += item * (columns * rows + 2);
  lists += item * (RASTER_CHUNK * RASTER_LARGE_BINS);
  ranges_clear(&ranges);
  uint count = bounds_visible(&bounds[chunk], view, (float)first_y, (float)end_y) ? RASTER_CHUNK : 0;
  for (uint first = 0; first < count; first += LANES) {
    global const RasterBlock *block = &blocks[first / RASTER_STEP];
    block_prefetch(block + PREFETCH_BLOCKS);
    uint slot = first % RASTER_STEP;
    UintL id = LANE_LOAD(block->id, slot), flags = LANE_LOAD(block->flags, slot);
    Vec3L corners[3], a[3];
    triangles_load(corners, a, blocks, first, view);
    VisibleTriangle t =
        visible_setup(view, a, flags, (id == UINTL(RASTER_UNUSED)) | triangles_hidden(id, hidden, hidden_count));
    IntL seen = (!t.culled) & visible_samples(&t, view, first_y, end_y, offsets, sample_count);
    uint bits = lane_bits(seen);
    if (!bits) continue;

    UintL fields[VISIBLE_WORDS];
    for (uint i = 0; i < 3; i++) {
      fields[VISIBLE_EDGE + 3 * i] = LANE_AS_UINT(t.edge_x[i]);
      fields[VISIBLE_EDGE + 3 * i + 1] = LANE_AS_UINT(t.edge_y[i]);
      fields[VISIBLE_EDGE + 3 * i + 2] = LANE_AS_UINT(t.edge_0[i]);
    }
    fields[VISIBLE_BOUNDS] = LANE_AS_UINT(t.low_x);
    fields[VISIBLE_BOUNDS + 1] = LANE_AS_UINT(t.low_y);
    fields[VISIBLE_BOUNDS + 2] = LANE_AS_UINT(t.high_x);
    fields[VISIBLE_BOUNDS + 3] = LANE_AS_UINT(t.high_y);
    fields[VISIBLE_NEAR] = LANE_AS_UINT(t.near);
    fields[VISIBLE_NUMBER] = LANE_AS_UINT(INTL((int)(chunk * RASTER_CHUNK + first)) + LANE_INDEX);
    fields[VISIBLE_FLAGS] = flags;
    bins_take(&ranges, seen, bits, bins_range(t.low_x, t.high_x, 0, columns),
              bins_range(t.low_y, t.high_y, first_row, first_row + rows), t.near, t.far, fields, VISIBLE_WORDS,
              records);
  }
  bins_sort(&ranges, spans, item, item_count, starts, lists);
}
