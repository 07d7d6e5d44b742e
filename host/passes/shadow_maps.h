// Shadow maps of a scene's lights, and how their shadow rays are answered by them: cl/shade/shadow_filter.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/raster_depth.h"
#include "passes/ray_stream.h"
#include "passes/shadow_fit.h"

// A light's maps. A light without any (it sends no light, or the maps' memory was spent before its turn) has a
// view_count of 0: rays are its method.
typedef struct LightMaps {
  ShadowInfo info;  // the host's copy
  DeviceBuffer info_buffer, views;
  DeviceBuffer maps;  // float [view_count][size * size] (shared/depth_map.h)
} LightMaps;

typedef struct ShadowMaps {
  Kernel filter;
  LightMaps *lights;  // [light_count]
  uint32_t light_count, left_out;
  uint64_t bytes;
} ShadowMaps;

// Fits and draws the maps of every light. Lights for whose maps there is no room any more are
// left out, with a warning that says how many. Errors: those of raster_depth and buffer_create.
Status shadow_maps_make(ShadowMaps *out, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                        const Plan *plan, const CameraInfo *camera, Log *log);
void shadow_maps_free(ShadowMaps *maps);

// What the maps of all lights may take.
uint64_t shadow_bytes_most(const ShadowOptions *options, const Device *device);

bool shadow_maps_have(const ShadowMaps *maps, uint32_t light);

// Adds to radiance[slot] what the maps let through of rays [0, count) of segment `segment` to light `light`.
Status shadow_maps_filter(const ShadowMaps *maps, Device *device, const DeviceScene *scene, uint32_t light,
                          const RayStream *rays, uint32_t segment, uint32_t count, const DeviceBuffer *radiance,
                          Log *log);
