// Shade + spawn pass: cl/shade/shade.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/ray_stream.h"
#include "plan/plan.h"
#include "shared/shade.h"

typedef struct Shader {
  Program *program;
  Kernel kernel;
  DeviceBuffer info;    // ShadeInfo
  DeviceBuffer counts;  // [STREAM_COUNTS]
} Shader;

// One bounce's streams: the rays that arrived, what they hit, where what they spawn goes.
typedef struct ShadeStreams {
  const RayStream *rays;
  const HitStream *hits;
  const RayStream *shadow;  // LIGHTS_PER_LAUNCH segments at most
  const RayStream *reflected, *transmitted;
  const DeviceBuffer *radiance;  // Float4 by slot
} ShadeStreams;

Status shader_make(Shader *out, Device *device, const DeviceScene *scene, Log *log);
void shader_free(Shader *shader);

// Shades rays [0, count) under `info` (a batch of lights) and returns how many rays were spawned, by stream.
Status shade(const Shader *shader, Device *device, const DeviceScene *scene, const ShadeStreams *streams,
             uint32_t count, const ShadeInfo *info, uint32_t counts[STREAM_COUNTS], const char *sentence, Log *log);
