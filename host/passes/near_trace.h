// Reflected rays against small trees of their reflectors' cube maps: cl/capture/near_trace.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "device_scene/part_bvh.h"
#include "passes/ray_stream.h"
#include "shared/near.h"

typedef struct NearTrace {
  Kernel kernel;
  DeviceBuffer nears;             // NearInfo, [cube_count]
  DeviceBuffer nodes, triangles;  // of all trees
  HitStream hits;                 // of what they hold
} NearTrace;

// For waves of up to `capacity` rays. trees[cube_count], which may be empty; where each begins is set in nears[cube].
// Errors: those of program_build and buffer_create.
Status near_trace_make(NearTrace *out, Device *device, const DeviceScene *scene, const Bvh2 *trees, NearInfo *nears,
                       uint32_t cube_count, uint32_t capacity, Log *log);
void near_trace_free(NearTrace *trace);

// Nearest hits of rays [0, count), by ray index, with the bits that trace_closest gives; none for rays of objects
// without a cube.
Status near_trace(const NearTrace *trace, Device *device, const DeviceScene *scene, const DeviceBuffer *cube_of_object,
                  const RayStream *rays, uint32_t count, Log *log);
