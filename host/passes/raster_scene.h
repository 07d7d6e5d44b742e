// A scene's triangles as the raster stages read them: cl/raster/triangle_pack.cl; and what those stages share.
#pragma once

#include "device_scene/device_scene.h"

typedef struct RasterScene {
  DeviceBuffer blocks;  // RasterBlock [chunk_count][RASTER_CHUNK_BLOCKS], in the order of the BVH's leaves
  DeviceBuffer bounds;  // RasterBounds [chunk_count]
  uint32_t triangle_count, chunk_count;
  bool has_shadowless;
} RasterScene;

// Two ways to the same result. Bins: triangles are sorted into squares of pixels, which are drawn each by one
// work-item. Direct: triangles are drawn by work-items of their own, with atomics. Direct is quicker on a GPU, bins on
// a CPU.
typedef enum RasterWay { RASTER_WAY_BEST, RASTER_WAY_BINS, RASTER_WAY_DIRECT } RasterWay;

// How to draw. Limits keep the device memory of a pass bounded whatever the scene; 0 is the usual.
typedef struct RasterOptions {
  RasterWay way;
  uint32_t pass_chunks;  // of RASTER_CHUNK triangles, times views: set up at a time (raster_pass_chunks)
  uint32_t pass_bins;    // of RASTER_BIN_PX pixels a side, covered at a time (RASTER_PASS_BINS)
  uint32_t pass_tiles;   // that have a place in the list of the direct way, 96 bytes each (raster_pass_tiles)
} RasterOptions;

enum { RASTER_PASS_BINS = 4096, RASTER_PASS_TILES = 1 << 19 };

// The way on this device: direct where LANES is 1 and the device is a GPU with 64-bit atomics.
RasterWay raster_way(const RasterOptions *options, const Device *device);

// Chunks (times views) that a pass has at most.
uint32_t raster_pass_chunks(const RasterOptions *options, const Device *device, RasterWay way);

// Tiles that the direct way's list has room for: RASTER_PASS_TILES, or a 64th of the device's memory if that is less.
uint32_t raster_pass_tiles(const RasterOptions *options, const Device *device);

// Builds a program of cl/raster that makes such `uses` of the scene (SceneUse).
Status raster_program(Program **out, Device *device, const DeviceScene *scene, const char *path, uint32_t uses,
                      Log *log);

// That of camera visibility and of triangle_pack.
const char *raster_visibility_path(RasterWay way);

// Packs the triangles of a scene's BVH, which leaves out those with a vertex that is not finite. 44 bytes of device
// memory a triangle, about 10 ns a triangle. Errors: those of program_build and buffer_create.
Status raster_scene_make(RasterScene *out, Device *device, const DeviceScene *scene, const RasterOptions *options,
                         Log *log);
void raster_scene_free(RasterScene *scene);
