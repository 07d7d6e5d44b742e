// FLIP of one tile of two pictures: the part of flip.c that takes the time.
#pragma once

#include "image/image.h"
#include "report/filter.h"

enum { FLIP_TILE_WIDTH = FILTER_WIDTH, FLIP_TILE_HEIGHT = 64 };

typedef struct FlipFilters {
  Filter achromatic, red_green, blue_yellow[2];  // contrast sensitivity
  Filter gauss, edge, point;                     // features; edge is antisymmetric
  int halo;                                      // pixels around a tile that its values depend on
} FlipFilters;

// 2^(start + i step) for i < count times the pictures, tone-mapped; count 0: the pictures as they are, clamped.
typedef struct FlipExposures {
  int count;
  double start, step;
} FlipExposures;

// ACES' curve, (a x^2 + b x) / (c x^2 + d x + e), of 0.6 x. From: Narkowicz, "ACES Filmic Tone Mapping Curve", 2015.
static const double flip_aces[5] = {0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14};

// Scratch of one thread, for one set of filters, which outlives it. NULL: no memory.
typedef struct FlipTile FlipTile;
FlipTile *flip_tile_make(const FlipFilters *filters);
void flip_tile_free(FlipTile *tile);

// FLIP of the pixels of the tile with this corner, [FLIP_TILE_HEIGHT][FLIP_TILE_WIDTH], valid until the next call;
// those outside the pictures are not defined. The pictures' border pixels go on outside.
const float *flip_tile_compare(FlipTile *tile, const Image *const images[2], uint32_t left, uint32_t top,
                               const FlipExposures *exposures);
