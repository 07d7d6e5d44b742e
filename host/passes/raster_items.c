#include "passes/raster_items.h"

#include <stdlib.h>

#include "shared/raster.h"

enum { FEW_ITEMS = 256 };  // setup is no dearer for those that it need not look at

Status raster_items_make(RasterItems *items, Program *program, RasterWay way, RasterSight sight, Log *log)
{
  Status status = STATUS_OK;
  const bool is_camera = sight == RASTER_SIGHT_CAMERA;
  TRY(program_kernel(&items->seen, program, is_camera ? "chunks_visible" : "chunks_on_map", log));
  if (way == RASTER_WAY_BINS)
    TRY(program_kernel(&items->list, program, is_camera ? "items_visible" : "items_on_map", log));

done:
  return status;
}

// Nobody waits for how many there are: all that might be are set up, of which what is not is the last.
static Status items_list_there(RasterItems *items, Device *device, const RasterScene *triangles,
                               const DeviceBuffer *views, uint32_t view_count, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t all = triangles->chunk_count * view_count;
  items->all_chunks = items->all_views = 0;
  items->count = items->pass = all;
  TRY(buffer_reserve(&items->items, device, all * sizeof(RasterItem), "raster triangles", log));
  TRY(buffer_reserve(&items->starts, device, (view_count + 1) * sizeof(uint32_t), "raster triangles", log));
  TRY(device_launch(device, &items->list, view_count, all, "find which views see a chunk of triangles",
                    ARGS(ARG_BUFFER(triangles->bounds), ARG(triangles->chunk_count), ARG_BUFFER(*views),
                         ARG(view_count), ARG_BUFFER(items->items), ARG_BUFFER(items->starts)),
                    log));

done:
  return status;
}

static Status flags_find(uint8_t *flags, RasterItems *items, Device *device, const RasterScene *triangles,
                         const DeviceBuffer *views, uint32_t all, Log *log)
{
  Status status = STATUS_OK;
  TRY(buffer_reserve(&items->flags, device, all, "raster triangles", log));
  TRY(device_launch(device, &items->seen, all, all, "find which views see a chunk of triangles",
                    ARGS(ARG_BUFFER(triangles->bounds), ARG(triangles->chunk_count), ARG_BUFFER(*views), ARG(all),
                         ARG_BUFFER(items->flags)),
                    log));
  TRY(buffer_read(device, &items->flags, flags, all, log));

done:
  return status;
}

// Lists those of `flags`, all where it is NULL. Returns how many.
static uint32_t items_list_here(RasterItem *list, uint32_t *starts, const uint8_t *flags, uint32_t chunk_count,
                                uint32_t view_count)
{
  uint32_t count = 0;
  for (uint32_t view = 0; view < view_count; view++) {
    starts[view] = count;
    for (uint32_t chunk = 0; chunk < chunk_count; chunk++)
      if (!flags || flags[view * chunk_count + chunk]) list[count++] = (RasterItem){chunk, view};
  }
  starts[view_count] = count;
  return count;
}

Status raster_items_find(RasterItems *items, Device *device, const RasterScene *triangles, const DeviceBuffer *views,
                         uint32_t view_count, uint32_t pass_most, Log *log)
{
  Status status = STATUS_OK;
  uint32_t all = triangles->chunk_count * view_count;
  bool choose = all > pass_most || (view_count > 1 && all > FEW_ITEMS);
  if (choose && all <= pass_most && items->list.kernel)
    return items_list_there(items, device, triangles, views, view_count, log);
  if (!choose && items->all_chunks == triangles->chunk_count && items->all_views == view_count) return STATUS_OK;
  RasterItem *list = malloc(all * sizeof *list + 1);
  uint32_t *starts = malloc((view_count + 1) * sizeof *starts);
  uint8_t *flags = choose ? malloc(all) : NULL;
  if (!list || !starts || (choose && !flags)) {
    status = log_no_memory(log, "raster triangles");
    goto done;
  }
  if (choose) TRY(flags_find(flags, items, device, triangles, views, all, log));
  items->count = items_list_here(list, starts, flags, triangles->chunk_count, view_count);
  items->pass = items->count < pass_most ? items->count : pass_most;
  TRY(buffer_put(&items->items, device, items->count * sizeof *list, list, "raster triangles", log));
  TRY(buffer_put(&items->starts, device, (view_count + 1) * sizeof *starts, starts, "raster triangles", log));
  items->all_chunks = choose ? 0 : triangles->chunk_count;
  items->all_views = choose ? 0 : view_count;

done:
  free(list);
  free(starts);
  free(flags);
  return status;
}

void raster_items_free(RasterItems *items)
{
  kernel_free(&items->seen);
  kernel_free(&items->list);
  buffer_free(&items->flags);
  buffer_free(&items->items);
  buffer_free(&items->starts);
  *items = (RasterItems){0};
}
