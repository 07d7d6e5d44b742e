// Vertex transform, culling, setup and binning for depth maps, LANES triangles at a time, for all views of a table.
//
//   in    blocks, bounds    the scene's triangles (triangle_pack.cl)
//         items             chunks and views, of which [first_item, first_item + item_count) are set up
//         views             square maps of the same size, `columns` bins a side
//   out   records  [item][RASTER_CHUNK + 1][DEPTH_WORDS], packed: triangles that may cover a texel's centre
//         spans    [SPAN_FIELDS][item]
//         starts   [item][bins + 2], lists [item][RASTER_CHUNK * RASTER_LARGE_BINS] (lib/bins.cl)
//
//   Cost  one work-item a chunk and view; 44 bytes read a triangle, 64 written for one that survives.
//   Either side of a triangle is drawn. What is behind the eye, beyond the far plane, off the map, without area or
//   between the centres of texels is dropped here.

#include "lib/bins.cl"
#include "lib/map_triangle.cl"

kernel void depth_setup(global const RasterBlock *blocks, global const RasterBounds *bounds,
                        global const RasterItem *items, uint first_item, uint item_count, constant RasterView *views,
                        uint columns, global uint *records, global uint *spans, global uint *starts,
                        global ushort *lists)
{
  uint item = spread_item(get_global_id(0), item_count);
  if (item >= item_count) return;
  uint chunk = items[first_item + item].chunk, number = items[first_item + item].view;
  if (number == RASTER_UNSEEN) return;
  constant RasterView *view = &views[number];
  BinRanges ranges;
  blocks += chunk * RASTER_CHUNK_BLOCKS;
  records += item * (RASTER_CHUNK + 1) * DEPTH_WORDS;
  starts += item * (columns * columns + 2);
  lists += item * (RASTER_CHUNK * RASTER_LARGE_BINS);
  ranges_clear(&ranges);
  uint count = bounds_on_map(&bounds[chunk], view) ? RASTER_CHUNK : 0;
  for (uint first = 0; first < count; first += LANES) {
    global const RasterBlock *block = &blocks[first / RASTER_STEP];
    block_prefetch(block + PREFETCH_BLOCKS);
    UintL flags = LANE_LOAD(block->flags, first % RASTER_STEP), id = LANE_LOAD(block->id, first % RASTER_STEP);
    Vec3L corners[3], a[3];
    triangles_load(corners, a, blocks, first, view);
    MapTriangle t = map_triangle_setup(view, a, (id == UINTL(RASTER_UNUSED)) | lanes_shadowless(flags));
    uint bits = lane_bits(!t.culled);
    if (!bits) continue;

    UintL fields[DEPTH_WORDS];
    const FloatL plane[6] = {t.depth[0],
                             t.depth_x,
                             t.depth_y,
                             min3_lane(t.depth[0], t.depth[1], t.depth[2]),
                             max3_lane(t.depth[0], t.depth[1], t.depth[2]),
                             FLOATL(0)};
    for (uint i = 0; i < 3; i++) {
      fields[2 * i] = t.clipped ? LANE_AS_UINT(t.clip[i][0]) : LANE_AS_UINT(t.x[i]);
      fields[2 * i + 1] = t.clipped ? LANE_AS_UINT(t.clip[i][1]) : LANE_AS_UINT(t.y[i]);
      fields[DEPTH_PLANE + 2 * i] = LANE_AS_UINT(t.clipped ? t.clip[i][2] : plane[2 * i]);
      fields[DEPTH_PLANE + 2 * i + 1] = LANE_AS_UINT(t.clipped ? t.clip[i][3] : plane[2 * i + 1]);
    }
    fields[DEPTH_NUMBER] = LANE_AS_UINT(INTL((int)(chunk * RASTER_CHUNK + first)) + LANE_INDEX);
    fields[DEPTH_UNUSED] = fields[DEPTH_UNUSED + 1] = UINTL(0);
    fields[DEPTH_FLAGS] = t.clipped ? flags | UINTL(DEPTH_CLIPPED) : flags;
    IntL bin_px = INTL(RASTER_BIN_PX);
    UintL x = LANE_AS_UINT((t.first_x / bin_px) | (t.last_x / bin_px) << INTL(16)),
          y = LANE_AS_UINT((t.first_y / bin_px) | (t.last_y / bin_px) << INTL(16));
    FloatL near = t.clipped ? FLOATL(0) : plane[3];
    bins_take(&ranges, !t.culled, bits, x, y, near, near, fields, DEPTH_WORDS, records);
  }
  bins_sort(&ranges, spans, item, item_count, starts, lists);
}
