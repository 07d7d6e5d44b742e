// How bright a picture is: the exposure that suits it, and whether it came out black or blown out.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Linear luminance of the pixels that show a surface (coverage of a half or more).
typedef struct LightMeter {
  uint64_t surface_pixels;
  uint64_t lit_pixels;    // of them, those within 2^-16 of the brightest, the rest being black
  double log2_luminance;  // mean over the lit pixels, exposure 0; Rec. 709 weights
} LightMeter;

typedef enum PictureVerdict {
  PICTURE_FINE,
  PICTURE_EMPTY,  // no surface in view
  PICTURE_BLACK,  // under 1 % of the surfaces' pixels are above 8/255 in any channel
  PICTURE_BLOWN,  // over half of the surfaces' pixels are white, 255/255 in all channels
} PictureVerdict;

// Measures sums of samples, [pixel_count][4]: linear radiance and coverage. Single-threaded, in the pixels' order: the
// same on every run. About 10 ns a pixel.
LightMeter light_meter_read(const float *sums, size_t pixel_count, uint32_t samples);

// The exposure, in EV rounded to 1/100, that brings the log-average luminance to 0.18, within -64..64; 0 where nothing
// is lit. From Reinhard, Stark, Shirley, Ferwerda, "Photographic Tone Reproduction for Digital Images", 2002, equations
// 1 and 2 (the key of 0.18); pixels that are black are left out of the mean rather than raised by a small number.
float light_meter_exposure_ev(const LightMeter *meter);

// Judges a display-encoded picture, [pixel_count][4], straight alpha, beside the sums it was made of.
PictureVerdict picture_judge(const float *picture, const float *sums, size_t pixel_count, uint32_t samples);
