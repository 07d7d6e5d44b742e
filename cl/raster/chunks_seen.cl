// Which views of a table may see which chunks of triangles?
//
//   in    bounds [chunk_count], views
//   out   seen   [view][chunk], by a work-item each (item_count = chunks times views): 1, or 0 for a chunk that is
//                outside the picture or the map
//         items  by kernels of a work-item a view, so that nobody waits for `seen`: what is seen, view by view, and
//                behind it RASTER_UNSEEN up to [item_count]; starts [view_count + 1]: the first item of each view
//
//   Cost  2 ns a chunk and view; of the lists 25 ns, for that of a view takes a look at all views before it.

#include "lib/view.cl"

static inline bool chunk_is_visible(global const RasterBounds *bounds, constant RasterView *view)
{
  return bounds_visible(bounds, view, 0, (float)view->height);
}

kernel void chunks_visible(global const RasterBounds *bounds, uint chunk_count, constant RasterView *views,
                           uint item_count, global uchar *seen)
{
  uint item = get_global_id(0);
  if (item < item_count) seen[item] = chunk_is_visible(&bounds[item % chunk_count], &views[item / chunk_count]);
}

kernel void chunks_on_map(global const RasterBounds *bounds, uint chunk_count, constant RasterView *views,
                          uint item_count, global uchar *seen)
{
  uint item = get_global_id(0);
  if (item < item_count) seen[item] = bounds_on_map(&bounds[item % chunk_count], &views[item / chunk_count]);
}

// The items of a view.
static inline void items_list(global RasterItem *items, global uint *starts, global const RasterBounds *bounds,
                              uint chunk_count, constant RasterView *views, uint view_count, bool is_map)
{
  const uint last = get_global_id(0);
  uint count = 0;
  if (last >= view_count) return;
  for (uint view = 0; view <= last; view++) {
    if (view == last) starts[view] = count;
    for (uint chunk = 0; chunk < chunk_count; chunk++) {
      bool is_seen =
          is_map ? bounds_on_map(&bounds[chunk], &views[view]) : chunk_is_visible(&bounds[chunk], &views[view]);
      if (!is_seen) continue;
      if (view == last) items[count] = (RasterItem){chunk, view};
      count++;
    }
  }
  if (last + 1 < view_count) return;
  starts[view_count] = count;
  for (; count < chunk_count * view_count; count++) items[count] = (RasterItem){0, RASTER_UNSEEN};
}

kernel void items_visible(global const RasterBounds *bounds, uint chunk_count, constant RasterView *views,
                          uint view_count, global RasterItem *items, global uint *starts)
{
  items_list(items, starts, bounds, chunk_count, views, view_count, false);
}

kernel void items_on_map(global const RasterBounds *bounds, uint chunk_count, constant RasterView *views,
                         uint view_count, global RasterItem *items, global uint *starts)
{
  items_list(items, starts, bounds, chunk_count, views, view_count, true);
}
