// FLIP: how much of a difference a viewer sees who flips between two pictures, from 0 (none) to 1.
//
// From: Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild, "FLIP: A Difference Evaluator for
// Alternating Images", 2020; Andersson, Nilsson, Shirley, Akenine-Moller, "Visualizing Errors in Rendered High Dynamic
// Range Images", 2021. Held to the authors' flip-evaluator 1.7.
#pragma once

#include <stdbool.h>

#include "image/image.h"

typedef struct FlipOptions {
  bool hdr;                  // the largest FLIP over the exposures that the reference spans, tone-mapped by ACES
  double pixels_per_degree;  // 0: 67.02, a 0.7 m wide screen of 3840 pixels seen from 0.7 m
  const uint8_t *mask;  // [height][width], 0 leaves a pixel out of the mean, though not out of its neighbours' values
  float *map;           // [height][width], filled unless NULL
} FlipOptions;

enum { FLIP_MIN_PIXELS_PER_DEGREE = 1, FLIP_MAX_PIXELS_PER_DEGREE = 400 };

// Mean of the FLIP map of two pictures of one size, in linear radiance over black; values below 0 count as 0, and
// without hdr those above 1 as 1. Alpha is not looked at. The mask leaves something.
//
// Where the reference is black the exposures are those of the other picture; where both are the result is 0.
//
// Errors: STATUS_NO_MEMORY. Cost: 25 to 45 ns a pixel and exposure on one core (AVX-512, AVX2).
Status flip_compare(double *mean, const Image *reference, const Image *picture, const FlipOptions *options, Log *log);
