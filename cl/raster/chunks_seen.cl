// Which views of a table may see which chunks of triangles? A work-item a chunk and view.
//
//   in    bounds [chunk_count], views; item_count = chunks times views
//   out   seen   [view][chunk]: 1, or 0 for a chunk that is outside the picture or the map

#include "lib/view.cl"

kernel void chunks_visible(global const RasterBounds *bounds, uint chunk_count, constant RasterView *views,
                           uint item_count, global uchar *seen)
{
  uint item = get_global_id(0);
  if (item >= item_count) return;
  constant RasterView *view = &views[item / chunk_count];
  seen[item] = bounds_visible(&bounds[item % chunk_count], view, 0, (float)view->height);
}

kernel void chunks_on_map(global const RasterBounds *bounds, uint chunk_count, constant RasterView *views,
                          uint item_count, global uchar *seen)
{
  uint item = get_global_id(0);
  if (item < item_count) seen[item] = bounds_on_map(&bounds[item % chunk_count], &views[item / chunk_count]);
}
