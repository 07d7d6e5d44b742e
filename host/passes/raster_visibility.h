// Camera visibility by raster: cl/raster/visibility_*.cl. It gives the hit stream that tracing the wave's camera rays
// would give, bit for bit, for all views of the camera at once.
#pragma once

#include "passes/camera_rays.h"
#include "passes/raster_bins.h"
#include "passes/raster_items.h"
#include "passes/raster_scene.h"

typedef struct RasterVisibility {
  RasterWay way;
  Kernel setup, bins;                  // RASTER_WAY_BINS
  Kernel small, split, draw, resolve;  // RASTER_WAY_DIRECT
  DeviceBuffer views;                  // RasterView [view_count]
  DeviceBuffer hidden;                 // ranges of triangle ids, [hidden_count][2]
  uint32_t view_count, hidden_count;
  RasterOptions options;
  RasterItems items;
  RasterBins binned;            // of one pass
  DeviceBuffer keys;            // by slot, 64 bits
  RasterBoxes boxes;            // of one pass
  DeviceBuffer costs;           // RASTER_COSTS
  uint32_t samples;             // of the camera
  uint32_t columns, pass_rows;  // bins across a view; rows of bins of a pass, of each view
  bool ready;                   // the bins hold the whole scene for the whole picture
} RasterVisibility;

// For a scene, or others alike. Errors: those of program_build, buffer_create.
Status raster_visibility_make(RasterVisibility *out, Device *device, const DeviceScene *scene,
                              const RasterOptions *options, Log *log);
void raster_visibility_free(RasterVisibility *raster);

// Takes a camera, for waves of up to `capacity` slots: before the first wave of each picture. Errors: those of
// buffer_create.
Status raster_visibility_aim(RasterVisibility *raster, Device *device, const RasterScene *triangles,
                             const CameraRays *camera, uint32_t samples, uint32_t capacity, Log *log);

// From now on triangles whose ids are in [ranges[i][0], ranges[i][1]) are not there. Before raster_visibility_aim.
// Cost: a comparison a range and triangle. Errors: those of buffer_create.
Status raster_visibility_hide(RasterVisibility *raster, Device *device, const uint32_t (*ranges)[2], uint32_t count,
                              Log *log);

// Writes the hits of all slots of the wave, into a stream of `capacity`; without `hits` (RASTER_WAY_DIRECT alone) they
// stay keys, which shading must take before the next wave (ShadeInfo.from_keys). With bins the first wave of a picture
// pays for setup and binning, unless they take several passes: then every wave does.
Status raster_visibility(RasterVisibility *raster, Device *device, const DeviceScene *scene,
                         const RasterScene *triangles, const CameraRays *camera, const Wave *wave,
                         const HitStream *hits, uint32_t capacity, Log *log);

// What it took so far: how often a triangle was tried on a block of 4 x 4 samples, and how many samples it then covered
// as the nearest so far. Counted with bins alone. Waits for the device.
typedef struct RasterCost {
  uint64_t block_tests, samples_covered;
} RasterCost;
Status raster_visibility_cost(RasterCost *out, const RasterVisibility *raster, Device *device, Log *log);
