#include "support/histogram.h"

#include <math.h>

enum { FINE = 24 };  // points of a cell: FINE x FINE

uint32_t histogram_cell(Vec3 direction)
{
  int row = (int)(fabs(direction.y) * HISTOGRAM_ROWS),
      column = (int)((atan2(direction.z, direction.x) / (2 * M_PI) + 0.5) * HISTOGRAM_COLUMNS);
  return (uint32_t)((row < HISTOGRAM_ROWS ? row : HISTOGRAM_ROWS - 1) * HISTOGRAM_COLUMNS +
                    (column < HISTOGRAM_COLUMNS ? column : HISTOGRAM_COLUMNS - 1));
}

// Direction of a point of a cell; `fine` counts FINE x FINE of them.
static Vec3 cell_direction(int cell, int fine, double up)
{
  double y = (cell / HISTOGRAM_COLUMNS + (fine / FINE + 0.5) / FINE) / HISTOGRAM_ROWS;
  double phi = 2 * M_PI * ((cell % HISTOGRAM_COLUMNS + (fine % FINE + 0.5) / FINE) / HISTOGRAM_COLUMNS - 0.5),
         ring = sqrt(1 - y * y);
  return vec3(ring * cos(phi), up * y, ring * sin(phi));
}

void histogram_expect(Histogram *histogram, HistogramDensity density, const void *context, int kind, double up,
                      double samples)
{
  for (int cell = 0; cell < HISTOGRAM_CELLS; cell++) {
    double sum = 0;
    for (int fine = 0; fine < FINE * FINE; fine++) sum += density(context, kind, cell_direction(cell, fine, up));
    histogram->expected[cell] = samples * sum / (FINE * FINE) * 2 * M_PI / HISTOGRAM_CELLS;
  }
}

double histogram_chi_square_z(const Histogram *histogram)
{
  double sum = 0, got_rest = 0, expected_rest = 0;
  int cells = 0;
  for (int cell = 0; cell < HISTOGRAM_CELLS; cell++) {
    double got = histogram->got[cell], expected = histogram->expected[cell];
    if (expected < 10) {
      got_rest += got;
      expected_rest += expected;
      continue;
    }
    sum += (got - expected) * (got - expected) / expected;
    cells++;
  }
  if (expected_rest > 10) {
    sum += (got_rest - expected_rest) * (got_rest - expected_rest) / expected_rest;
    cells++;
  } else if (got_rest > expected_rest + 25) {
    return INFINITY;
  }
  double k = cells;
  return (cbrt(sum / k) - (1 - 2 / (9 * k))) / sqrt(2 / (9 * k));
}
