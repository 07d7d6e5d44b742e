#include "report/flip.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "report/flip_tile.h"
#include "report/rank.h"

// A filter from one side of it, `weights` of 0 .. radius; the far taps that single precision cannot tell are left out.
static Filter filter_make(const double *weights, int radius)
{
  Filter filter = {0};
  double largest = 0;
  for (int k = 0; k <= radius; k++) largest = fmax(largest, fabs(weights[k]));
  while (radius > 0 && fabs(weights[radius]) < 1e-8 * largest) radius--;
  filter.radius = radius;
  for (int k = 0; k <= radius; k++) filter.weights[k] = (float)weights[k];
  return filter;
}

// Contrast sensitivity as Gaussians in space, a sqrt(pi / b) exp(-pi^2 x^2 / b) with x in degrees: table 1 of the
// paper. That of blue and yellow is a sum of two; each is separable, with the root of its height along either axis.
static int sensitivity_filters(FlipFilters *out, double pixels_per_degree)
{
  static const struct {
    double a, b;
  } rows[] = {{1, 0.0047}, {1, 0.0053}, {34.1, 0.04}, {13.5, 0.025}};
  double weights[4][FILTER_MAX_RADIUS + 1], sums[4], pi2 = M_PI * M_PI;
  int radius = (int)ceil(3 * sqrt(0.04 / (2 * pi2)) * pixels_per_degree);
  for (int r = 0; r < 4; r++) {
    sums[r] = 0;
    for (int k = 0; k <= radius; k++) {
      double x = k / pixels_per_degree;
      weights[r][k] = sqrt(rows[r].a * sqrt(M_PI / rows[r].b)) * exp(-pi2 * x * x / rows[r].b);
      sums[r] += (k ? 2 : 1) * weights[r][k];
    }
  }
  double blue_yellow = sqrt(sums[2] * sums[2] + sums[3] * sums[3]);
  double scales[4] = {sums[0], sums[1], blue_yellow, blue_yellow};
  for (int r = 0; r < 4; r++)
    for (int k = 0; k <= radius; k++) weights[r][k] /= scales[r];
  out->achromatic = filter_make(weights[0], radius);
  out->red_green = filter_make(weights[1], radius);
  out->blue_yellow[0] = filter_make(weights[2], radius);
  out->blue_yellow[1] = filter_make(weights[3], radius);
  return radius;
}

// A Gaussian and its first two derivatives, which find edges and points; the weights of either sign sum to 1.
static int feature_filters(FlipFilters *out, double pixels_per_degree)
{
  const double width_degrees = 0.082;
  double gauss[FILTER_MAX_RADIUS + 1], edge[FILTER_MAX_RADIUS + 1], point[FILTER_MAX_RADIUS + 1];
  double deviation = 0.5 * width_degrees * pixels_per_degree;
  double gauss_sum = 0, edge_sum = 0, above = 0, below = 0;
  int radius = (int)ceil(3 * deviation);
  for (int k = 0; k <= radius; k++) {
    gauss[k] = exp(-k * k / (2 * deviation * deviation));
    edge[k] = k * gauss[k];
    point[k] = (k * k / (deviation * deviation) - 1) * gauss[k];
    gauss_sum += (k ? 2 : 1) * gauss[k];
    edge_sum += edge[k];
    above += (k ? 2 : 1) * fmax(point[k], 0);
    below += (k ? 2 : 1) * fmax(-point[k], 0);
  }
  for (int k = 0; k <= radius; k++) {
    gauss[k] /= gauss_sum;
    edge[k] /= edge_sum;
    point[k] /= point[k] > 0 ? above : below;
  }
  out->gauss = filter_make(gauss, radius);
  out->edge = filter_make(edge, radius);
  out->point = filter_make(point, radius);
  return radius;
}

static void filters_make(FlipFilters *out, double pixels_per_degree)
{
  int a = sensitivity_filters(out, pixels_per_degree), b = feature_filters(out, pixels_per_degree);
  out->halo = (a > b ? a : b) + 1;
}

typedef struct Luminances {
  const Image *image;
  float *values;  // [height][width]
} Luminances;

static void luminances_row(void *context, size_t y)
{
  const Luminances *job = context;
  const float *p = job->image->pixels + 4 * y * job->image->width;
  float *out = job->values + y * job->image->width;
  for (uint32_t x = 0; x < job->image->width; x++, p += 4)
    out[x] = fmaxf(0.2126f * p[0] + 0.7152f * p[1] + 0.0722f * p[2], 0);
}

// The exposures from the one that shows the picture's largest luminance at 0.85 of the tone curve's range, to the one
// that shows its median there, a step of at most one power of two apart (section 4 of the 2021 paper). False: black.
static bool exposures_of(FlipExposures *out, float *luminances, const Image *image)
{
  size_t count = (size_t)image->width * image->height;
  float largest = 0;
  parallel_for(image->height, luminances_row, &(Luminances){image, luminances});
  for (size_t i = 0; i < count; i++) largest = fmaxf(largest, luminances[i]);
  if (!(largest > 0)) return false;
  float median = fminf(fmaxf(value_of_rank(luminances, count, count / 2), FLT_EPSILON), largest);

  // Of the curve (a x^2 + b x) / (c x^2 + d x + e), where it is 0.85.
  const double shown = 0.85;
  double a = flip_aces[0] - shown * flip_aces[2], b = flip_aces[1] - shown * flip_aces[3], c = -shown * flip_aces[4];
  double x = (-b + sqrt(b * b - 4 * a * c)) / (2 * a);
  double start = log2(x / largest), stop = log2(x / median);
  out->count = (int)fmax(2, ceil(stop - start));
  out->start = start;
  out->step = (stop - start) / (out->count - 1);
  return true;
}

typedef struct FlipJob {
  const Image *images[2];
  const FlipOptions *options;
  FlipFilters filters;
  FlipExposures exposures;  // none without hdr
  double *band_sums;        // [bands], over the mask
  atomic_bool no_memory;
} FlipJob;

static size_t band_count(const Image *image) { return (image->height + FLIP_TILE_HEIGHT - 1) / FLIP_TILE_HEIGHT; }

// Sums a tile's values over the mask, and keeps them where a map is asked for.
static double tile_collect(const FlipJob *job, const float *errors, uint32_t left, uint32_t top)
{
  const FlipOptions *options = job->options;
  uint32_t width = job->images[0]->width, height = job->images[0]->height;
  uint32_t columns = width - left < FLIP_TILE_WIDTH ? width - left : FLIP_TILE_WIDTH;
  double sum = 0;
  for (uint32_t y = top; y < height && y < top + FLIP_TILE_HEIGHT; y++, errors += FLIP_TILE_WIDTH) {
    size_t at = (size_t)y * width + left;
    if (options->map) memcpy(options->map + at, errors, columns * sizeof *errors);
    for (uint32_t x = 0; x < columns; x++)
      if (!options->mask || options->mask[at + x]) sum += errors[x];
  }
  return sum;
}

static void band_compare(void *context, size_t band)
{
  FlipJob *job = context;
  FlipTile *tile = flip_tile_make(&job->filters);
  if (!tile) {
    atomic_store(&job->no_memory, true);
    return;
  }
  uint32_t top = (uint32_t)band * FLIP_TILE_HEIGHT;
  job->band_sums[band] = 0;
  for (uint32_t left = 0; left < job->images[0]->width; left += FLIP_TILE_WIDTH) {
    const float *errors = flip_tile_compare(tile, job->images, left, top, &job->exposures);
    job->band_sums[band] += tile_collect(job, errors, left, top);
  }
  flip_tile_free(tile);
}

Status flip_compare(double *mean, const Image *reference, const Image *picture, const FlipOptions *options, Log *log)
{
  const double usual_pixels_per_degree = 0.7 * (3840 / 0.7) * (M_PI / 180);
  Status status = STATUS_OK;
  size_t pixels = (size_t)reference->width * reference->height, bands = band_count(reference), counted = 0;
  float *luminances = options->hdr ? malloc(pixels * sizeof *luminances) : NULL;
  FlipJob job = {.images = {reference, picture}, .options = options, .band_sums = calloc(bands, sizeof(double))};
  if (!job.band_sums || (options->hdr && !luminances)) {
    status = log_no_memory(log, "FLIP");
    goto done;
  }
  filters_make(&job.filters, options->pixels_per_degree > 0 ? options->pixels_per_degree : usual_pixels_per_degree);
  if (options->hdr && !exposures_of(&job.exposures, luminances, reference) &&
      !exposures_of(&job.exposures, luminances, picture))
    job.exposures = (FlipExposures){.count = 1};
  parallel_for(bands, band_compare, &job);
  if (atomic_load(&job.no_memory)) {
    status = log_no_memory(log, "FLIP");
    goto done;
  }
  *mean = 0;
  for (size_t i = 0; i < bands; i++) *mean += job.band_sums[i];
  for (size_t i = 0; i < pixels; i++) counted += !options->mask || options->mask[i];
  *mean /= (double)counted;

done:
  free(luminances);
  free(job.band_sums);
  return status;
}
