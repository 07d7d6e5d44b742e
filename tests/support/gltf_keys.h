// Animations of one node by keys.
#pragma once

#include "support/gltf_build.h"

typedef struct Keys {
  const char *path, *interpolation, *type;  // the accessor's type of values
  int count, value_count;
  const float *times, *values;
} Keys;

// A triangle with morph targets whose node moves by keys. Failures fail the test.
GltfMotion *gltf_keys_open(Scene *scene, const Keys *keys);
