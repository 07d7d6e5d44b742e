// Cube-face capture pass: cl/capture/cube_capture.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/camera_rays.h"
#include "passes/raster_visibility.h"
#include "passes/trace.h"
#include "shared/cube.h"

typedef struct CubeCapture {
  Kernel rays, peel, near, keep, hull, cells;
  DeviceBuffer info;       // CubeInfo of the cube that is captured
  DeviceBuffer left_out;   // uint by object: 1 where it is passed
  DeviceBuffer closeness;  // float by slot
  DeviceBuffer count;      // of what is sent on
  HitStream hits;          // of rays that passed something
  CameraRays views;        // the faces, one under the other
  RasterVisibility raster;
  uint32_t *object_starts;  // [object_count + 1]
  bool by_raster;           // what is seen from the centre is found by raster, not by rays
} CubeCapture;

// The cameras of a cube's faces, of one sample a pixel in its centre. Pixels' centres are the texels' (shared/cube.h):
// the outermost lie on the cube's edges, but for a millionth by which all rays of a face have its axis for their
// longest component; raster is quick where they have, and where near_m is above 3e-5 of what lies farthest.
void cube_cameras(CameraInfo out[CUBE_FACES], uint32_t size, Vec3 center_world, float near_m);

// For waves of up to `capacity` rays.
Status cube_capture_make(CubeCapture *out, Device *device, const DeviceScene *scene, uint32_t capacity, Log *log);
void cube_capture_free(CubeCapture *capture);

enum { CUBE_SAMPLES_MOST = 16, CUBE_RANGES_MOST = 64 };

// What the waves to come are of, by rays; nothing nearer to the centre than near_m is seen from it. `left_out` is 1 for
// each object that is passed, [object_count].
Status cube_capture_aim(CubeCapture *capture, Device *device, const DeviceScene *scene, const CubeInfo *cube,
                        float near_m, const uint32_t *left_out, Log *log);

// From now on raster finds what is seen from the centre, unless what is left out is more than CUBE_RANGES_MOST ranges
// of triangles. Errors: those of raster_visibility_make and raster_visibility_aim.
Status cube_capture_raster(CubeCapture *capture, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                           const uint32_t *left_out, uint32_t capacity, Log *log);

// Rays of a wave of the tall picture of six faces, size / TILE_SIZE tiles a row: from the centre, or with `inward_m`
// above 0 to it, from so far along each face's axis.
Status cube_capture_rays(const CubeCapture *capture, Device *device, const Wave *wave, float inward_m,
                         const RayStream *stream, Log *log);

// Nearest hits of `rays` (slots are the identity) on what is not left out. `spare` holds rays that went past something.
// At most CUBE_LAYERS_MOST surfaces are passed; behind them is nothing.
enum { CUBE_LAYERS_MOST = 64 };
Status cube_capture_trace(const CubeCapture *capture, const Tracer *tracer, Device *device, const DeviceScene *scene,
                          bool inward, const RayStream *rays, uint32_t count, const HitStream *hits,
                          const RayStream spare[2], Log *log);

// The same by raster, of all rays of the wave, where `by_raster` is set.
Status cube_capture_see(CubeCapture *capture, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                        const Wave *wave, const HitStream *hits, uint32_t capacity, Log *log);

// Adds the wave's radiance, times `share`, to the cube's texels, and sets their closeness.
Status cube_capture_keep(const CubeCapture *capture, Device *device, const Wave *wave, float share,
                         const DeviceBuffer *radiance, const DeviceBuffer *texels, Log *log);

// Sets the hull of the wave's texels by the closeness of its inward rays; one sample.
Status cube_capture_keep_hull(const CubeCapture *capture, Device *device, const Wave *wave, const DeviceBuffer *hull,
                              Log *log);

// Fills the cells of the cube once all its texels are there.
Status cube_capture_cells(const CubeCapture *capture, Device *device, uint32_t size, const DeviceBuffer *texels,
                          const DeviceBuffer *cells, Log *log);
