// The stages of a raster frame, as benchmarks run them.
#pragma once

#include "bench/raster_views.h"
#include "bench/scene.h"
#include "passes/raster_depth.h"
#include "passes/raster_visibility.h"
#include "render/frame.h"

enum { WIDTH = 1920, HEIGHT = 1080, PIXELS = WIDTH * HEIGHT, MAPS = 2, CUBE_PX = 256, CAPTURES = 2 };
extern const uint32_t map_px[MAPS], capture_px[CAPTURES];

// The last draws more than the peer.
typedef enum Stage {
  MAP_1024,
  MAP_2048,
  CUBE,
  VISIBILITY,
  SHADED,
  FRAME,
  CAPTURE_256,
  CAPTURE_512,
  PEER_STAGES,
  FRAME_AND_CUBE = PEER_STAGES,
  STAGES
} Stage;
extern const char *const stage_names[STAGES];

// A scene, every triangle of it opaque and double-sided, and the passes that draw it.
typedef struct RasterStages {
  BenchScene base;
  RasterScene triangles;
  RasterDepth maps[MAPS], cube;
  DeviceBuffer frame_maps;  // the frame's depth map, the planes of its blocks where shading asks for them, and a cube
  RasterVisibility visibility;
  CameraRays camera;
  HitStream hits;
  DeviceScene lit_scene;     // with the light of `views` alone
  Frame frame;               // of it
  Frame captures[CAPTURES];  // the same for a camera of six views, wave by wave
  RasterViews views;
  uint32_t tiles;
} RasterStages;

// The device is that of device_open. Errors: those of bench_scene_open and of the passes; STATUS_USAGE for an
// orthographic camera. raster_stages_close frees either way.
Status raster_stages_open(RasterStages *out, const char *path, const char *device, uint32_t threads);
void raster_stages_close(RasterStages *stages);

// Runs one and waits for it. A depth map from a light that sees the whole scene; the six faces of a cube, depth alone,
// by one view table; what the file's camera sees at 1080p as the hit stream that shading reads; the same shaded by one
// light with 3 x 3 compares of its depth map of 2048, all that a render does from the wave of camera rays to the sums
// of the picture; the whole frame: that depth map, with what lookups take of it besides, and the shaded camera; cubes
// as reflections capture them, radiance and depth, by the same light; the frame with the depth cube of a point light.
Status raster_stage_run(RasterStages *stages, Stage stage);

// Mean time of each kernel since span `first`, over `rounds`.
void raster_kernels_print(const Timeline *timeline, size_t first, int rounds);
