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
  DeviceBuffer views;                // RasterView [view_capacity]
  RasterOptions options;
  RasterItems items;
  RasterBins binned;  // of one pass
  RasterBoxes boxes;  // of one pass
  DeviceBuffer maps;  // of raster_depth: float [view_capacity][size * size] (shared/depth_map.h)
  uint32_t size_px, view_capacity;
} RasterDepth;

// For maps of size_px (a multiple of 4, at most 8192) texels a side, `view_capacity` at a time, and a scene,
// or others alike. Errors: STATUS_USAGE for other sizes, those of program_build and buffer_create.
Status raster_depth_make(RasterDepth *out, Device *device, const DeviceScene *scene, uint32_t size_px,
                         uint32_t view_capacity, const RasterOptions *options, Log *log);
void raster_depth_free(RasterDepth *raster);

// Draws the scene into maps [0, view_count) of raster->maps, which the first call makes, or into those from
// `first_texel` on (a multiple of 16) of a buffer of the caller's. Returns when the launches are queued. Errors: those
// of buffer_create.
Status raster_depth_into(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                         const RasterView *views, uint32_t view_count, const DeviceBuffer *maps, uint32_t first_texel,
                         Log *log);
Status raster_depth(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                    const RasterView *views, uint32_t view_count, Log *log);

// Finds what bounds each block of maps that are drawn, on a device of more than one lane: `texel_count` of them from
// `first_texel` on; the planes (DEPTH_PLANE_*) go to the same buffer, from `first_plane` on. Errors: those of
// program_build.
Status raster_depth_planes(Device *device, const DeviceScene *scene, const DeviceBuffer *maps, uint32_t first_texel,
                           uint32_t texel_count, uint32_t first_plane, Log *log);
