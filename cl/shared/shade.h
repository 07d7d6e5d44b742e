// What a shading launch is told besides the scene. Written by host/render, read by cl/shade.
#ifndef SHARED_SHADE_H
#define SHARED_SHADE_H

#include "shared/types.h"

#define LIGHTS_PER_LAUNCH 4  // shadow streams written by one launch

#define LIGHTING_MODEL_PBR 0u
#define LIGHTING_MODEL_PHONG 1u

typedef struct ShadeInfo {
  uint model;         // LIGHTING_MODEL_*
  uint first_light;   // of this launch's batch
  uint light_count;   // in the batch, 0..LIGHTS_PER_LAUNCH
  uint first_batch;   // 1: this launch adds emission, ambient and environment, and spawns reflected rays
  uint cast_shadows;  // 0: light arrives unblocked, without shadow rays
  uint reflect;       // 1: mirrors spawn rays; 0: they stay dark
  uint environment_lights;  // the environment lights surfaces (pbr) and is not black
  float ambient;            // phong
  float min_weight;         // reflected rays below it in every channel are cut
} ShadeInfo;
SHARED_SIZE(ShadeInfo, 36);

// Counters of the streams that a launch appends to: shadow rays by light of the batch, then reflected rays.
#define STREAM_COUNT_REFLECTED LIGHTS_PER_LAUNCH
#define STREAM_COUNTS (LIGHTS_PER_LAUNCH + 1)

#endif
