// Structural similarity of two pictures.
//
// From: Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From Error Visibility to Structural Similarity",
// 2004.
#pragma once

#include <stdint.h>

#include "base/log.h"

enum { SSIM_WINDOW = 11 };  // pixels a side, a Gaussian of deviation 1.5

// Mean over the windows that lie inside the picture and whose centre is in the mask ([height][width], NULL:
// everywhere). Lumas are [height][width], in [0, 1]. *out is 1 for equal pictures and NAN where there is no window.
//
// Errors: STATUS_NO_MEMORY. Cost: about 5 ns a pixel on one core.
Status ssim_compare(double *out, const float *luma_a, const float *luma_b, uint32_t width, uint32_t height,
                    const uint8_t *mask, Log *log);
