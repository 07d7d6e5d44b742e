// Directions counted by cell of a hemisphere, and held to a density.
#pragma once

#include <stdint.h>

#include "base/math3d.h"

// Cells of the hemisphere about a surface's normal, all of the same solid angle.
enum { HISTOGRAM_ROWS = 12, HISTOGRAM_COLUMNS = 24, HISTOGRAM_CELLS = HISTOGRAM_ROWS * HISTOGRAM_COLUMNS };

typedef struct Histogram {
  double got[HISTOGRAM_CELLS], expected[HISTOGRAM_CELLS];
} Histogram;

uint32_t histogram_cell(Vec3 direction);

// Per solid angle, of what `kind` says.
typedef double (*HistogramDensity)(const void *context, int kind, Vec3 direction);

// What of so many samples each cell expects; `up` is 1 or -1, the y of the hemisphere's axis.
void histogram_expect(Histogram *histogram, HistogramDensity density, const void *context, int kind, double up,
                      double samples);

// Pearson's chi-square statistic as a standard normal variable (Wilson, Hilferty, "The Distribution of Chi-square",
// 1931): beyond 4.5 either way is a chance of 1 in 100 000. Cells that expect fewer than 10 are taken together.
double histogram_chi_square_z(const Histogram *histogram);
