// How far one picture is from another: the numbers of an error report, for `frugal compare` and for tests.
#pragma once

#include <stdbool.h>

#include "image/image.h"

// The share of pixels off by more than this in any displayed channel is the project's currency of error.
#define IMAGE_THRESHOLD (2.0 / 255)

// What rounding may add to a displayed difference: 2/255 between two 8-bit pictures is not over 2/255.
#define IMAGE_ROUNDING 1e-6

typedef struct ImageCompareOptions {
  double threshold;           // displayed difference above which a pixel counts as over; 0: IMAGE_THRESHOLD
  const uint8_t *mask;        // [height][width], 0 leaves a pixel out of every number; NULL: none is left out
  double pixels_per_degree;   // of FLIP; 0: its authors' default
  bool flip, hdr_flip, ssim;  // computed where true, else NAN: they cost most
  const char *names[2];       // for messages; NULL: "first picture", "second picture"
} ImageCompareOptions;

// "Displayed" is sRGB-encoded, clamped to [0, 1], over black. A pixel's difference is that of its worst channel. Alpha
// is such a channel, and takes no part in the means.
typedef struct ImageError {
  uint64_t pixels;                      // compared
  uint64_t over;                        // of these, displayed difference above the threshold
  double over_share;                    // over / pixels
  double rmse, relative_mse;            // of linear R, G and B; relative to the first picture
  double max, p99;                      // pixel differences, linear: the largest, and the 99th percentile
  double max_displayed, p99_displayed;  // the same, displayed
  double psnr;                          // dB, of displayed R, G and B with the peak 1; INFINITY for equal pictures
  double ssim;                // of displayed luma; 1 for equal pictures, NAN without a window in picture and mask
  double flip;                // mean over the displayed pictures; 0 for equal ones, at most 1
  double hdr_flip;            // mean of the largest over the exposures that the first picture spans
  uint32_t worst_x, worst_y;  // the first pixel with the largest displayed difference
} ImageError;

// Compares pictures of linear radiance (Image.pixels, premultiplied alpha); the first is the reference. `options` may
// be NULL. The same input gives the same numbers whatever the threads.
//
// Errors: STATUS_BAD_IMAGE (other sizes, values that are not finite, a mask that leaves nothing), STATUS_NO_MEMORY.
//
// Cost: 0.2 s for two pictures of 3840x2160 on 2 cores; SSIM and FLIP 0.15 s each, HDR-FLIP 0.15 s an exposure more.
//
// From: Rousselle, Knaus, Zwicker, "Adaptive Sampling and Reconstruction using Greedy Error Minimization", 2011
// (relative MSE: (b - a)^2 / (a^2 + 0.01)); ssim.h; flip.h.
Status image_compare(ImageError *out, const Image *a, const Image *b, const ImageCompareOptions *options, Log *log);

// Writes the displayed difference in false colour: black to blue up to the threshold, green where it is just over, then
// by its logarithm yellow, red and, for the largest there can be, white; pixels outside the mask are grey.
//
// Errors: STATUS_BAD_IMAGE (other sizes, values that are not finite), those of image_write.
Status image_difference_write(ImageHelper *helper, const char *path, const Image *a, const Image *b,
                              const ImageCompareOptions *options, Log *log);
