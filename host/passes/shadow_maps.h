// Shadow maps of a scene's lights. Shading looks them up: cl/lib/shadow_lookup.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/raster_depth.h"
#include "passes/shadow_fit.h"

typedef struct ShadowMaps {
  // [light_count], the host's copy of `infos`. A light without any maps (its method takes none, it sends no light, or
  // the maps' memory was spent before its turn) has a view_count of 0: if it casts shadows, by rays.
  ShadowInfo *lights;
  uint32_t light_count, left_out;
  ShadowView *view_table;  // [view_count], the host's copy of `views`
  uint32_t view_count;
  uint32_t *kept;  // [light_count]: views that are as they were in the frame before
  uint64_t bytes;
  DeviceBuffer infos;  // ShadowInfo [light_count]
  DeviceBuffer views;  // ShadowView, of all lights
  DeviceBuffer maps;   // float, of all lights (shared/depth_map.h)
} ShadowMaps;

// Fits and draws the maps of every light whose method looks them up. Lights for whose maps there
// is no room any more are left out, with a warning that says how many. Views that look as one of `before` did, and in
// which nothing moved since, are taken from there and not drawn: `before` are the maps of the frame before in a
// sequence, which may lose their texels, or NULL. Errors: those of raster_depth and buffer_create.
Status shadow_maps_make(ShadowMaps *out, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                        const Plan *plan, const CameraInfo *camera, ShadowMaps *before, Log *log);
void shadow_maps_free(ShadowMaps *maps);

// What the maps of all lights may take.
uint64_t shadow_bytes_most(const ShadowOptions *options, const Device *device);

bool shadow_maps_have(const ShadowMaps *maps, uint32_t light);
