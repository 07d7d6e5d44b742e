// Pairs of pictures, made by formulas, for the tests of comparisons.
#pragma once

#include <stdbool.h>

#include "image/image.h"

typedef struct PicturePair {
  const char *name;
  bool hdr;    // values above 1, for the HDR variant of FLIP
  Image a, b;  // linear radiance, alpha 1
} PicturePair;

enum { PICTURE_PAIR_COUNT = 9 };

// Pair `index`, the same on every machine to a few 1e-7 of each value. The caller frees it.
PicturePair picture_pair_make(int index);
void picture_pair_free(PicturePair *pair);

// An empty picture: RGB 0, alpha 1.
Image picture_make(uint32_t width, uint32_t height);

// Sets R, G and B of a pixel.
void picture_set(Image *image, uint32_t x, uint32_t y, double r, double g, double b);
