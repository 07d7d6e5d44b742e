// The environment as surfaces of rising roughness reflect it, without visibility (shared/scene.h): the first factor of
// the split sum.
#pragma once

#include "base/log.h"
#include "scene/scene.h"

typedef struct EnvironmentLevels {
  float *pixels;  // [pixels of the levels][4]; NULL where all directions have the same radiance
  size_t count;   // floats
} EnvironmentLevels;

// Level k holds the radiance about each direction n, averaged over reflections at GGX normals about n of roughness
// 2^(-k / 2), weighted by n.l, the eye at n. Each sample reads an image as coarse as its neighbours are far. Only
// levels that surfaces of at least `least_roughness` read are made. About 40 ms on two cores for all of them, half of
// it for the last, and 5 ns a pixel of the image.
//
// Errors: STATUS_NO_MEMORY.
// Source: Karis, "Real Shading in Unreal Engine 4", 2013; Colbert, Krivanek, "GPU-Based Importance Sampling", GPU Gems
// 3, 2007 (the coarser images).
Status environment_levels_make(EnvironmentLevels *out, const Environment *environment, float least_roughness, Log *log);
void environment_levels_free(EnvironmentLevels *levels);
