// Depth maps by raster: cl/raster/depth_*.cl. Several square maps at once, one a view: a shadow map, the six faces of a
// cube.
#pragma once

#include "passes/raster_bins.h"
#include "passes/raster_items.h"
#include "passes/raster_scene.h"
#include "passes/raster_view.h"

typedef struct RasterDepth {
  RasterWay way;
  Kernel setup, bins;                // RASTER_WAY_BINS
  Kernel clear, small, split, draw;  // RASTER_WAY_DIRECT
  DeviceBuffer views;                // RasterView, of those at hand
  RasterOptions options;
  RasterItems items;  // RASTER_WAY_BINS
  RasterBins binned;  // of one pass
  RasterBoxes boxes;  // of one pass
  DeviceBuffer maps;  // of raster_depth (shared/depth_map.h)
} RasterDepth;

// For a scene, or others alike. Errors: those of program_build and buffer_create.
Status raster_depth_make(RasterDepth *out, Device *device, const DeviceScene *scene, const RasterOptions *options,
                         Log *log);
void raster_depth_free(RasterDepth *raster);

// Draws the scene into the maps of all views, each from its first_texel on, in a buffer of the caller's; or one behind
// the other in raster->maps. Views are square, of any sizes that are multiples of 4 and at most 8192. Returns when the
// launches are queued. Errors: STATUS_USAGE for other sizes, those of buffer_create.
Status raster_depth_into(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                         const RasterView *views, uint32_t view_count, const DeviceBuffer *maps, Log *log);
Status raster_depth(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                    const RasterView *views, uint32_t view_count, Log *log);

// Finds what bounds each block, and each square of blocks, of maps that are drawn and lie behind each other from
// `first_texel` on, on a device of more than one lane. The planes (DEPTH_PLANE_*) go behind them: depth_plane_floats of
// each map, then depth_wide_floats. Errors: those of program_build.
Status raster_depth_planes(Device *device, const DeviceScene *scene, const DeviceBuffer *maps, uint32_t first_texel,
                           uint32_t size_px, uint32_t view_count, Log *log);
