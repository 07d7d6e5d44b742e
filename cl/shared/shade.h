// What a shading launch is told besides the scene. Written by host/render, read by cl/shade.
#ifndef SHARED_SHADE_H
#define SHARED_SHADE_H

#include "shared/types.h"

#define LIGHTS_PER_LAUNCH 4  // shadow streams written by one launch

#define LIGHTING_MODEL_PBR 0u
#define LIGHTING_MODEL_PHONG 1u

typedef struct ShadeInfo {
  uint model;               // LIGHTING_MODEL_*
  uint first_light;         // of this launch's batch
  uint light_count;         // in the batch, 0..LIGHTS_PER_LAUNCH
  uint first_batch;         // 1: this launch adds emission, ambient and environment, and spawns reflected rays
  uint cast_shadows;        // 0: light arrives unblocked, without shadow rays
  uint reflect;             // 1: mirrors spawn rays; 0: they stay dark
  uint environment_lights;  // the environment lights surfaces (pbr) and is not black
  float ambient;            // phong
  float min_weight;         // reflected rays below it in every channel are cut
  float min_transmitted;    // the same for what BLEND lets through
  uint primary;             // 1: camera rays, or what BLEND let through of them: they count as coverage
  uint flat_background;     // 1: camera rays that miss see `background` in place of the environment
  Float3 background;
} ShadeInfo;
SHARED_SIZE(ShadeInfo, 60);

// Counters of the streams that a launch appends to: shadow rays by light of the batch, reflected rays, and
// what BLEND lets through.
#define STREAM_COUNT_REFLECTED LIGHTS_PER_LAUNCH
#define STREAM_COUNT_TRANSMITTED (LIGHTS_PER_LAUNCH + 1)
#define STREAM_COUNTS (LIGHTS_PER_LAUNCH + 2)

#endif
