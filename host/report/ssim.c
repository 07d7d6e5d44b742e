#include "report/ssim.h"

#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "report/filter.h"

enum {
  WIDTH = FILTER_WIDTH,
  HEIGHT = 64,
  RADIUS = SSIM_WINDOW / 2,
  HALO = RADIUS + 1,  // filter_row reads one further
  ROWS = HEIGHT + 2 * HALO,
  STRIDE = (WIDTH + 2 * HALO + 15) / 16 * 16,
};

enum Moment { MEAN_A, MEAN_B, SQUARE_A, SQUARE_B, PRODUCT, MOMENT_COUNT };

// A tile of window centres and what surrounds it.
typedef struct SsimTile {
  float moments[MOMENT_COUNT][ROWS * STRIDE];  // of single pixels
  float across[MOMENT_COUNT][ROWS * WIDTH];
  float values[HEIGHT * WIDTH];
} SsimTile;

typedef struct SsimJob {
  const float *luma_a, *luma_b;
  uint32_t width, height;
  const uint8_t *mask;
  Filter window;
  double *band_sums;  // [bands]
  uint64_t *band_counts;
  atomic_bool no_memory;
} SsimJob;

// Lumas less 1/2: variances stay, and lose less to rounding. True: both are the same.
static bool tile_load(SsimTile *tile, const SsimJob *job, uint32_t left, uint32_t top)
{
  for (int row = 0; row < ROWS; row++) {
    size_t line = filter_clamp((int64_t)top + row - HALO, job->height) * job->width;
    for (int x = 0; x < STRIDE; x++) {
      size_t from = line + filter_clamp((int64_t)left + x - HALO, job->width);
      tile->moments[MEAN_A][row * STRIDE + x] = job->luma_a[from] - 0.5f;
      tile->moments[MEAN_B][row * STRIDE + x] = job->luma_b[from] - 0.5f;
    }
  }
  return memcmp(tile->moments[MEAN_A], tile->moments[MEAN_B], sizeof tile->moments[0]) == 0;
}

// Equation 13, with the constants of section III-C for a range of 1.
LOOP_INLINE void ssim_row(float *restrict out, float (*restrict m)[WIDTH])
{
  const float c1 = 0.01f * 0.01f, c2 = 0.03f * 0.03f;
  for (int x = 0; x < WIDTH; x++) {
    float variance_a = m[SQUARE_A][x] - m[MEAN_A][x] * m[MEAN_A][x];
    float variance_b = m[SQUARE_B][x] - m[MEAN_B][x] * m[MEAN_B][x];
    float covariance = m[PRODUCT][x] - m[MEAN_A][x] * m[MEAN_B][x];
    float mean_a = m[MEAN_A][x] + 0.5f, mean_b = m[MEAN_B][x] + 0.5f;
    float above = (2 * mean_a * mean_b + c1) * (2 * covariance + c2);
    out[x] = above / ((mean_a * mean_a + mean_b * mean_b + c1) * (variance_a + variance_b + c2));
  }
}

LOOP_CLONES static void tile_compute(SsimTile *tile, const Filter *window)
{
  for (int at = 0; at < ROWS * STRIDE; at++) {
    float a = tile->moments[MEAN_A][at], b = tile->moments[MEAN_B][at];
    tile->moments[SQUARE_A][at] = a * a;
    tile->moments[SQUARE_B][at] = b * b;
    tile->moments[PRODUCT][at] = a * b;
  }
  for (int i = 0; i < MOMENT_COUNT; i++)
    for (int row = 0; row < ROWS; row++)
      filter_row(tile->across[i] + row * WIDTH, tile->moments[i] + row * STRIDE + HALO, 1, window, 1);
  for (int row = 0; row < HEIGHT; row++) {
    float moments[MOMENT_COUNT][WIDTH];
    for (int i = 0; i < MOMENT_COUNT; i++)
      filter_row(moments[i], tile->across[i] + (row + HALO) * WIDTH, WIDTH, window, 1);
    ssim_row(tile->values + row * WIDTH, moments);
  }
}

static void band_compare(void *context, size_t band)
{
  SsimJob *job = context;
  SsimTile *tile = malloc(sizeof *tile);
  if (!tile) {
    atomic_store(&job->no_memory, true);
    return;
  }
  uint32_t top = (uint32_t)band * HEIGHT + RADIUS, bottom = job->height - RADIUS, right = job->width - RADIUS;
  double sum = 0;
  uint64_t count = 0;
  for (uint32_t left = RADIUS; left < right; left += WIDTH) {
    bool equal = tile_load(tile, job, left, top);
    if (!equal) tile_compute(tile, &job->window);
    for (uint32_t y = top; y < bottom && y < top + HEIGHT; y++)
      for (uint32_t x = left; x < right && x < left + WIDTH; x++) {
        if (job->mask && !job->mask[(size_t)y * job->width + x]) continue;
        sum += equal ? 1 : tile->values[(y - top) * WIDTH + x - left];
        count++;
      }
  }
  job->band_sums[band] = sum;
  job->band_counts[band] = count;
  free(tile);
}

static Filter window_make(void)
{
  const double deviation = 1.5;
  Filter window = {.radius = RADIUS};
  double weights[RADIUS + 1], sum = 0;
  for (int k = 0; k <= RADIUS; k++) {
    weights[k] = exp(-k * k / (2 * deviation * deviation));
    sum += (k ? 2 : 1) * weights[k];
  }
  for (int k = 0; k <= RADIUS; k++) window.weights[k] = (float)(weights[k] / sum);
  return window;
}

Status ssim_compare(double *out, const float *luma_a, const float *luma_b, uint32_t width, uint32_t height,
                    const uint8_t *mask, Log *log)
{
  Status status = STATUS_OK;
  *out = NAN;
  if (width < SSIM_WINDOW || height < SSIM_WINDOW) return STATUS_OK;
  size_t bands = (height - 2 * RADIUS + HEIGHT - 1) / HEIGHT;
  SsimJob job = {luma_a, luma_b, width, height, mask, window_make(), NULL, NULL, false};
  job.band_sums = calloc(bands, sizeof *job.band_sums);
  job.band_counts = calloc(bands, sizeof *job.band_counts);
  if (job.band_sums && job.band_counts)
    parallel_for(bands, band_compare, &job);
  else
    job.no_memory = true;
  if (job.no_memory) {
    status = log_no_memory(log, "SSIM");
    goto done;
  }
  double sum = 0;
  uint64_t count = 0;
  for (size_t i = 0; i < bands; i++) {
    sum += job.band_sums[i];
    count += job.band_counts[i];
  }
  if (count) *out = sum / (double)count;

done:
  free(job.band_sums);
  free(job.band_counts);
  return status;
}
