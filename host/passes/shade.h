// Shade + spawn pass: cl/shade/shade.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/camera_rays.h"
#include "passes/kept_verdicts.h"
#include "passes/ray_stream.h"
#include "passes/shadow_maps.h"
#include "passes/sure_maps.h"
#include "plan/plan.h"
#include "shared/shade.h"

typedef struct Shader {
  Program *program;
  Kernel kernel;
  DeviceBuffer counts;              // [STREAM_COUNTS]
  DeviceBuffer environment_table;   // shared/scene.h; empty where directions are not chosen by an image
  DeviceBuffer environment_levels;  // shared/scene.h; empty where no surface reads them
  DeviceBuffer nothing;             // stands for what there is none of
  uint32_t environment_segments;    // of shadow rays that the environment needs; if environment_open, the last is of
  bool environment_open;            // rays to which back faces are open
} Shader;

// One bounce's streams: the rays that arrived, what they hit, where what they spawn goes.
typedef struct ShadeStreams {
  const RayStream *rays;
  const HitStream *hits;
  const RayStream *shadow;  // LIGHTS_PER_LAUNCH segments at most, then those of the environment
  const RayStream *reflected, *transmitted;
  const DeviceBuffer *radiance;  // Float4 by slot, or by pixel (ShadeInfo.to_picture)
  const ShadowMaps *maps;        // of the lights; NULL where the plan has none
  const CameraRays *camera;      // may be NULL unless ShadeInfo.from_camera is set
  const SureMaps *sure;          // the same
  const DeviceBuffer *keys;      // NULL unless ShadeInfo.from_keys is set
  const KeptVerdicts *verdicts;  // on shadow rays; NULL where none are kept
} ShadeStreams;

// Builds the kernel with what the plan needs; the scene's host environment is read where it has to be sampled.
Status shader_make(Shader *out, Device *device, const DeviceScene *scene, const Plan *plan, Log *log);
void shader_free(Shader *shader);

// Shades rays [0, count) under `info` (a batch of lights) and returns how many rays were spawned, by stream.
Status shade(const Shader *shader, Device *device, const DeviceScene *scene, const ShadeStreams *streams,
             uint32_t count, const ShadeInfo *info, uint32_t counts[STREAM_COUNTS], const char *sentence, Log *log);
