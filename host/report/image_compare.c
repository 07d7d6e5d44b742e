#include "report/image_compare.h"

#include <math.h>

#include "base/parallel.h"
#include "report/flip.h"
#include "report/pixel_errors.h"
#include "report/rank.h"
#include "report/ssim.h"

// The sums of all rows, in their order, as means.
static void rows_sum(ImageError *out, const RowErrors *rows, uint32_t height)
{
  double square = 0, relative = 0, square_displayed = 0;
  for (uint32_t y = 0; y < height; y++) {
    const RowErrors *row = &rows[y];
    if (!row->pixels) continue;
    square += row->square;
    relative += row->relative;
    square_displayed += row->square_displayed;
    out->max = fmax(out->max, row->max);
    if (row->max_displayed > out->max_displayed || !out->pixels) {
      out->max_displayed = row->max_displayed;
      out->worst_x = row->worst_x;
      out->worst_y = y;
    }
    out->pixels += row->pixels;
    out->over += row->over;
  }
  double values = 3 * (double)out->pixels;
  out->over_share = (double)out->over / (double)out->pixels;
  out->rmse = sqrt(square / values);
  out->relative_mse = relative / values;
  out->psnr = square_displayed > 0 ? -10 * log10(square_displayed / values) : INFINITY;
}

typedef struct Percentile {
  double *out;
  const float *values;
  size_t count;
  uint64_t rank;
} Percentile;

static void percentile_find(void *context, size_t i)
{
  const Percentile *percentile = (Percentile *)context + i;
  *percentile->out = value_of_rank(percentile->values, percentile->count, percentile->rank);
}

// The nearest rank: the least value that 99 % of the pixels do not exceed.
static void percentiles_find(ImageError *out, const PixelErrors *job)
{
  size_t count = (size_t)job->images[0]->width * job->images[0]->height;
  uint64_t rank = (99 * out->pixels + 99) / 100 - 1;
  Percentile percentiles[] = {{&out->p99, job->linear, count, rank},
                              {&out->p99_displayed, job->displayed, count, rank}};
  parallel_for(2, percentile_find, percentiles);
}

Status image_compare(ImageError *out, const Image *a, const Image *b, const ImageCompareOptions *given, Log *log)
{
  Status status = STATUS_OK;
  ImageError error = {.ssim = NAN, .flip = NAN, .hdr_flip = NAN};
  ImageCompareOptions options = image_compare_options(given);
  PixelErrors pixels;

  TRY(pixel_errors_make(&pixels, a, b, &options, log));
  rows_sum(&error, pixels.rows, a->height);
  if (!error.pixels) {
    status = log_fail(log, STATUS_BAD_IMAGE, "%s: the mask leaves no pixel: nothing to compare", options.names[0]);
    goto done;
  }
  percentiles_find(&error, &pixels);
  if (options.ssim)
    TRY(ssim_compare(&error.ssim, pixels.lumas[0], pixels.lumas[1], a->width, a->height, options.mask, log));
  FlipOptions flip = {.pixels_per_degree = options.pixels_per_degree, .mask = options.mask};
  if (options.flip) TRY(flip_compare(&error.flip, a, b, &flip, log));
  flip.hdr = true;
  if (options.hdr_flip) TRY(flip_compare(&error.hdr_flip, a, b, &flip, log));
  *out = error;

done:
  pixel_errors_free(&pixels);
  return status;
}
