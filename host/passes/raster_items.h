// What raster stages set up: the chunks of triangles that each view of a table may see. Most of a large scene is in one
// or two of a cube's six faces.
#pragma once

#include "passes/raster_scene.h"

typedef struct RasterItems {
  Kernel seen, list;               // cl/raster/chunks_seen.cl; list: for bins
  DeviceBuffer flags;              // by view and chunk, where there are many
  DeviceBuffer items;              // RasterItem [count], view by view
  DeviceBuffer starts;             // the first item of each view, [view_count + 1]
  uint32_t count;                  // or, where the device has listed them, no more than that
  uint32_t all_chunks, all_views;  // of a list of everything, which is kept while it is the same; 0: it is another
  uint32_t pass;                   // as many of them as a pass may have
} RasterItems;

// Which planes a view sees by (cl/lib/view.cl).
typedef enum RasterSight { RASTER_SIGHT_CAMERA, RASTER_SIGHT_MAP } RasterSight;

// Takes the kernel from a program that has it.
Status raster_items_make(RasterItems *items, Program *program, RasterWay way, RasterSight sight, Log *log);

// Lists all chunks for all views. Where a pass cannot have all of them, or several views have many, only what the views
// may see: 2 ns a chunk and view. Waits for the device where a pass cannot have all, and on a GPU, whose setup would
// take longer for what is not seen. Errors: those of buffer_create.
Status raster_items_find(RasterItems *items, Device *device, const RasterScene *triangles, const DeviceBuffer *views,
                         uint32_t view_count, uint32_t pass_most, Log *log);
void raster_items_free(RasterItems *items);

// In the order in which the kernels declare them: items of the pass [first, first + count).
#define ITEM_ARGS(list, first, count) ARG_BUFFER((list)->items), ARG(first), ARG(count)
