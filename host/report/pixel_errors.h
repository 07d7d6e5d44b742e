// Differences of two pictures, pixel by pixel: what every number but FLIP starts from.
#pragma once

#include "report/image_compare.h"

// Sums of one row, over the mask.
typedef struct RowErrors {
  uint64_t pixels, over;
  double square, relative, square_displayed;  // over R, G and B
  float max, max_displayed;
  uint32_t worst_x;  // first pixel with max_displayed
  uint64_t not_finite[2];
  uint32_t not_finite_x[2];  // the first
} RowErrors;

// Arrays are [height][width].
typedef struct PixelErrors {
  const Image *images[2];
  const uint8_t *mask;
  double threshold;
  RowErrors *rows;   // [height]
  float *linear;     // difference of the worst channel; -1 outside the mask
  float *displayed;  // the same, displayed
  float *lumas[2];   // displayed, of ITU-R BT.601; NULL without options->ssim
} PixelErrors;

// Options with the defaults put in; `options` may be NULL.
ImageCompareOptions image_compare_options(const ImageCompareOptions *options);

// `options` are complete. On failure *out is {0}. Errors: STATUS_BAD_IMAGE (other sizes, values that are not finite),
// STATUS_NO_MEMORY.
Status pixel_errors_make(PixelErrors *out, const Image *a, const Image *b, const ImageCompareOptions *options,
                         Log *log);
void pixel_errors_free(PixelErrors *errors);
