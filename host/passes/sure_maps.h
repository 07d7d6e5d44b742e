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
  uint32_t tile_columns;             // of a view
  DeviceBuffer marks;                // uint [view_count][tile_columns * tile_columns], until the maps are drawn
  DeviceBuffer tiles;                // ShadowTile, as many
  uint32_t tile_count, block_count;  // tiles that are known, and their blocks
  DeviceBuffer blocks;               // ShadowBlock [block_count]
  DeviceBuffer rows;                 // ShadowRow [SHADOW_NUMBERS - 1][block_count]
} SureMaps;

// Bytes of a light's tiles, blocks and rows where all of its tiles are known.
uint64_t sure_maps_bytes(const ShadowInfo *info);

// Where the maps look. Marked, only tiles that are then marked (cl/rays/shadow_mark.cl) will be drawn; else all. On
// failure *out is to be freed too. Errors: those of buffer_create.
Status sure_maps_aim(SureMaps *out, Device *device, const ShadowFit *fit, bool marked, Log *log);

// What draws them, light after light.
typedef struct SureRaster {
  RasterWay way;
  Kernel setup, bins;                         // RASTER_WAY_BINS
  Kernel take, place, fill, squares, sum_up;  // RASTER_WAY_DIRECT
  RasterBins binned;                          // of one pass
  // The direct way's, of one pass: SURE_DIRECT_WORDS a record; SURE_COUNTS and the lists'; where these start and end.
  DeviceBuffer records, lists, counts, starts, ends;
  uint32_t pass_chunks;  // chunks times views that the buffers hold
} SureRaster;

// For a scene's triangles. Direct is best on a GPU where LANES is 1. Errors: those of program_build and buffer_create.
Status sure_raster_make(SureRaster *out, Device *device, const RasterScene *triangles, const RasterOptions *options,
                        Log *log);
void sure_raster_free(SureRaster *raster);

// Draws maps that are aimed. `solid` has a bit a triangle (device_scene/solid.h); with skip_facing what is of a closed
// surface and faces the light is left out. Waits for marks; returns when the launches are queued. Errors: those of
// buffer_create.
Status sure_maps_draw(SureMaps *maps, SureRaster *raster, Device *device, const RasterScene *triangles,
                      const DeviceBuffer *solid, bool skip_facing, Log *log);
void sure_maps_free(SureMaps *maps);
