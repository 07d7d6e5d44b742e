// Directions about a normal as a surface of roughness alpha reflects them, the eye at the normal.
#pragma once

typedef struct GgxSample {
  double up, along, across;  // unit vector, up along the normal; up <= 0: nothing comes from there
  double density;            // 1 / sr
} GgxSample;

// Of `count` points of Hammersley's set the i-th, as a half vector of the GGX distribution, mirrored.
GgxSample ggx_sample(int i, int count, double alpha);
