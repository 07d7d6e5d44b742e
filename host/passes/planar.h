// Flat mirrors by a mirrored camera: cl/capture/planar.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/camera_rays.h"
#include "passes/known_hits.h"
#include "passes/raster_visibility.h"
#include "shared/planar.h"

enum { PLANES_MOST = 8 };

// A mirror's plane and what each of the picture's samples sees in it.
typedef struct PlanarView {
  DeviceBuffer info;   // PlanarInfo
  DeviceBuffer names;  // uint [samples][tiles][TILE_PIXELS]
} PlanarView;

typedef struct Planar {
  Kernel clip, keep, reflect;
  PlanarView views[PLANES_MOST];
  uint32_t count;
  uint32_t left_out;             // flat mirrors that are not among them
  DeviceBuffer plane_of_object;  // uint, [object_count]; PLANE_NONE
  DeviceBuffer counts;
  uint64_t bytes;
  uint64_t looked_up, left;  // rays so far: asked, and left to be traced
} Planar;

Status planar_make(Planar *out, Device *device, const DeviceScene *scene, const uint32_t *plane_of_object, Log *log);
void planar_free(Planar *planar);

// Draws one more plane with `samples` a pixel: the mirrored camera's, whose pixels are those of a picture turned left
// for right. `hits` is of `capacity`. Errors: those of raster_visibility_aim and buffer_create.
Status planar_draw(Planar *planar, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                   RasterVisibility *raster, const PlanarInfo *info, const CameraRays *mirrored, uint32_t samples,
                   const HitStream *hits, uint32_t capacity, Log *log);

// Finds what rays [0, count) of a wave hit that camera rays reflected; those that are left go to `left`, others with
// their hits to `known`.
Status planar_reflect(Planar *planar, Device *device, const DeviceScene *scene, const Wave *wave, const RayStream *rays,
                      uint32_t count, const RayStream *left, const KnownHits *known, LeftRays *out, Log *log);
