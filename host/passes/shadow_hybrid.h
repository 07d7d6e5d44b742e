// Hybrid shadows: what a light's maps know for sure (cl/raster/shadow_bins.cl), shadow rays judged by it
// (cl/rays/shadow_hybrid.cl), and the rays that it leaves unsure.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/raster_scene.h"
#include "passes/ray_stream.h"
#include "passes/shadow_fit.h"
#include "passes/trace.h"

// A light's maps; without any its rays are traced.
typedef struct SureMaps {
  ShadowInfo info;  // the host's copy
  DeviceBuffer info_buffer, views;
  DeviceBuffer blocks;  // ShadowBlock [view_count][size / 4 * size / 4]
  DeviceBuffer rows;    // ShadowRow [SHADOW_NUMBERS - 1][view_count][size / 4 * size / 4]
} SureMaps;

typedef struct ShadowHybrid {
  Kernel setup, bins, judge;
  SureMaps *lights;  // [light_count]
  uint32_t light_count, left_out;
  RayStream unsure;
  DeviceBuffer unsure_count;
  uint64_t rays, traced;  // of what was judged so far
} ShadowHybrid;

// Draws the maps of every light. 76 bytes a texel, of which a CPU touches what the lists need; lights for whose maps there is no room any more are
// left out, with a warning that says how many. Errors: those of program_build and buffer_create.
Status shadow_hybrid_make(ShadowHybrid *out, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                          const Plan *plan, const CameraInfo *camera, uint32_t capacity, Log *log);
void shadow_hybrid_free(ShadowHybrid *hybrid);

bool shadow_hybrid_has(const ShadowHybrid *hybrid, uint32_t light);

// Adds the weights of rays [0, count) of segment `segment` that nothing stops on their way to light `light`: what
// trace_any does. Waits for the device to say how many rays are unsure. Errors: STATUS_DEVICE.
Status shadow_hybrid_trace(ShadowHybrid *hybrid, const Tracer *tracer, Device *device, const DeviceScene *scene,
                           uint32_t light, const RayStream *rays, uint32_t segment, uint32_t count,
                           const DeviceBuffer *radiance, Coherence coherence, Log *log);
