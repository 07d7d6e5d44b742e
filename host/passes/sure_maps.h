// What a light's maps know for sure of its shadows: cl/raster/shadow_bins.cl, and the same on a GPU,
// cl/raster/shadow_direct.cl.
#pragma once

#include "passes/raster_bins.h"
#include "passes/raster_scene.h"
#include "passes/shadow_fit.h"

// A light's maps.
typedef struct SureMaps {
  ShadowInfo info;  // the host's copy
  DeviceBuffer info_buffer, views;
  DeviceBuffer blocks;  // ShadowBlock [view_count][size / 4 * size / 4]
  DeviceBuffer rows;    // ShadowRow [SHADOW_NUMBERS - 1][view_count][size / 4 * size / 4]
} SureMaps;

// Bytes of a light's blocks and rows.
uint64_t sure_maps_bytes(const ShadowInfo *info);

// What draws them, light after light.
typedef struct SureRaster {
  RasterWay way;
  Kernel setup, bins;               // RASTER_WAY_BINS
  Kernel take, place, fill, tiles;  // RASTER_WAY_DIRECT
  RasterBins binned;                // of one pass
  // The direct way's, of one pass: SURE_DIRECT_WORDS a record; SURE_COUNTS and the lists'; where these start and end.
  DeviceBuffer records, lists, counts, starts, ends;
  uint32_t pass_chunks;  // chunks times views that the buffers hold
} SureRaster;

// For a scene's triangles. Direct is best on a GPU where LANES is 1. Errors: those of program_build and buffer_create.
Status sure_raster_make(SureRaster *out, Device *device, const RasterScene *triangles, const RasterOptions *options,
                        Log *log);
void sure_raster_free(SureRaster *raster);

// Draws a light's maps. `solid` has a bit a triangle (device_scene/solid.h); with skip_facing what is of a closed
// surface and faces the light is left out. Returns when the launches are queued. On failure *out is to be freed too.
// Errors: those of buffer_create.
Status sure_maps_draw(SureMaps *out, SureRaster *raster, Device *device, const RasterScene *triangles,
                      const ShadowFit *fit, const DeviceBuffer *solid, bool skip_facing, Log *log);
void sure_maps_free(SureMaps *maps);
