// What lights' maps know for sure of their shadows: cl/raster/shadow_bins.cl, and the same on a GPU,
// cl/raster/shadow_direct.cl.
#pragma once

#include "passes/raster_bins.h"
#include "passes/raster_scene.h"
#include "passes/shadow_fit.h"

// Blocks of a view, those of its known tiles.
typedef struct SureBlocks {
  uint32_t first, count;
} SureBlocks;

// The maps of all lights.
typedef struct SureMaps {
  uint32_t light_count;
  ShadowInfo *lights;     // [light_count], the host's copy of `infos`; a light without maps has a view_count of 0
  uint32_t *known_tiles;  // [light_count]: to be drawn
  bool (*stayed)[SHADOW_VIEWS_MOST];             // [light_count], view by view: drawn already, in the frame before
  SureBlocks (*view_blocks)[SHADOW_VIEWS_MOST];  // [light_count]
  ShadowView *view_table;
  DeviceBuffer infos, views;  // ShadowInfo [light_count], ShadowView of all lights
  uint32_t tile_count, block_count;
  DeviceBuffer marks;   // uint [tile_count], until they are read
  uint32_t *seen;       // [tile_count], the marks as read; NULL: all tiles are known
  DeviceBuffer tiles;   // ShadowTile [tile_count]: of light after light, view after view, row by row
  DeviceBuffer blocks;  // ShadowBlock [block_count]
  DeviceBuffer rows;    // ShadowRow [SHADOW_NUMBERS - 1][block_count]
} SureMaps;

// Tiles of a light's maps, and bytes that are kept of one that is known.
uint32_t sure_maps_tiles(const ShadowInfo *info);
extern const uint64_t sure_tile_bytes;

// Where the maps look, light by light; a fit of no views is of a light without maps. Marked, only tiles that are then
// marked (cl/rays/shadow_mark.cl) and read will be drawn; else all. On failure *out is to be freed too. Errors: those
// of buffer_create.
Status sure_maps_aim(SureMaps *out, Device *device, const ShadowFit *fits, uint32_t light_count, bool marked, Log *log);

// Reads the marks, to settle by them. Errors: STATUS_NO_MEMORY, STATUS_DEVICE.
Status sure_maps_read_marks(SureMaps *maps, Device *device, Log *log);

// Tiles that are marked of a light's maps, were these smaller by 2^level.
uint32_t sure_maps_marked(const SureMaps *maps, uint32_t light, uint32_t level);

// Aims the maps anew, whose marks are read: at the same, but smaller by 2^levels[light], or without views.
// Errors: those of buffer_create.
Status sure_maps_shrink(SureMaps *maps, Device *device, const ShadowFit *fits, const uint8_t *levels, Log *log);

// Makes room for what the marks ask. `before`, which may be NULL, are maps that were drawn of the same triangles in the
// same order, but for what moved of `scene` since: views that had the same map and marks there, and see nothing that
// moved, get what was drawn; its buffers may be taken. Errors: those of buffer_create.
Status sure_maps_settle(SureMaps *maps, Device *device, const DeviceScene *scene, SureMaps *before, Log *log);

// Says of all views that they stayed.
void sure_maps_stay(SureMaps *maps);

// Views of a light that stayed.
uint32_t sure_maps_kept(const SureMaps *maps, uint32_t light);

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

// Draws what did not stay of a light's maps, which are settled. `marks` has a bit a triangle (device_scene/solid.h),
// and `what` says what that means: SURE_NONE_MARKED and the others of shared/shadow.h. Errors: those of buffer_create.
Status sure_maps_draw(SureMaps *maps, uint32_t light, SureRaster *raster, Device *device, const RasterScene *triangles,
                      const DeviceBuffer *marks, uint32_t what, Log *log);
void sure_maps_free(SureMaps *maps);
