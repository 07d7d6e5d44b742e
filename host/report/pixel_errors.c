#include "report/pixel_errors.h"

#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "report/loop_math.h"

enum { BLOCK = 64 };

// A few pixels of both pictures, channel by channel, and what follows from them without looking at the mask.
typedef struct Block {
  float linear[2][4][BLOCK];
  float displayed[2][4][BLOCK];
  float difference[BLOCK], difference_displayed[BLOCK];  // of the worst channel
  float lumas[2][BLOCK];
} Block;

static void block_load(Block *block, const Image *const images[2], size_t at, uint32_t count)
{
  for (int i = 0; i < 2; i++) {
    const float *pixels = images[i]->pixels + 4 * at;
    for (uint32_t x = 0; x < BLOCK; x++)
      for (int c = 0; c < 4; c++) block->linear[i][c][x] = x < count ? pixels[4 * x + (uint32_t)c] : 0;
  }
}

LOOP_CLONES static void block_compute(Block *block)
{
  for (int i = 0; i < 2; i++) {
    float(*restrict displayed)[BLOCK] = block->displayed[i];
    for (int c = 0; c < 3; c++)
      for (int x = 0; x < BLOCK; x++) displayed[c][x] = loop_srgb_encode(block->linear[i][c][x]);
    for (int x = 0; x < BLOCK; x++) displayed[3][x] = loop_min(loop_max(block->linear[i][3][x], 0), 1);
    for (int x = 0; x < BLOCK; x++)
      block->lumas[i][x] = 0.299f * displayed[0][x] + 0.587f * displayed[1][x] + 0.114f * displayed[2][x];
  }
  for (int x = 0; x < BLOCK; x++) block->difference[x] = block->difference_displayed[x] = 0;
  for (int c = 0; c < 4; c++) {
    for (int x = 0; x < BLOCK; x++)
      block->difference[x] = loop_max(block->difference[x], loop_abs(block->linear[1][c][x] - block->linear[0][c][x]));
    for (int x = 0; x < BLOCK; x++)
      block->difference_displayed[x] =
          loop_max(block->difference_displayed[x], loop_abs(block->displayed[1][c][x] - block->displayed[0][c][x]));
  }
}

static bool pixel_is_finite(RowErrors *row, const Block *block, uint32_t i, uint32_t x)
{
  bool finite = true;
  for (int p = 0; p < 2; p++) {
    bool good = true;
    for (int c = 0; c < 4; c++) good = good && isfinite(block->linear[p][c][i]);
    if (!good && !row->not_finite[p]++) row->not_finite_x[p] = x;
    finite = finite && good;
  }
  return finite;
}

// In double: a radiance of 1e20 has a square.
static void pixel_add(RowErrors *row, const Block *block, uint32_t i, uint32_t x, double threshold)
{
  const double epsilon = 0.01;
  for (int c = 0; c < 3; c++) {
    double a = block->linear[0][c][i], difference = block->linear[1][c][i] - a;
    double displayed = block->displayed[1][c][i] - block->displayed[0][c][i];
    row->square += difference * difference;
    row->relative += difference * difference / (a * a + epsilon);
    row->square_displayed += displayed * displayed;
  }
  float displayed = block->difference_displayed[i];
  row->pixels++;
  row->over += displayed > threshold + IMAGE_ROUNDING;
  row->max = fmaxf(row->max, block->difference[i]);
  if (displayed > row->max_displayed || row->pixels == 1) {
    row->max_displayed = displayed;
    row->worst_x = x;
  }
}

static void row_compute(void *context, size_t y)
{
  const PixelErrors *job = context;
  uint32_t width = job->images[0]->width;
  RowErrors row = {0};
  for (uint32_t left = 0; left < width; left += BLOCK) {
    Block block;
    size_t at = y * width + left;
    uint32_t count = width - left < BLOCK ? width - left : BLOCK;
    block_load(&block, job->images, at, count);
    block_compute(&block);
    for (uint32_t i = 0; i < count; i++) {
      bool counts = pixel_is_finite(&row, &block, i, left + i) && (!job->mask || job->mask[at + i]);
      if (counts) pixel_add(&row, &block, i, left + i, job->threshold);
      job->linear[at + i] = counts ? block.difference[i] : -1;
      job->displayed[at + i] = counts ? block.difference_displayed[i] : -1;
      for (int p = 0; p < 2; p++)
        if (job->lumas[p]) job->lumas[p][at + i] = block.lumas[p][i];
    }
  }
  job->rows[y] = row;
}

ImageCompareOptions image_compare_options(const ImageCompareOptions *options)
{
  ImageCompareOptions complete = options ? *options : (ImageCompareOptions){0};
  if (!(complete.threshold > 0)) complete.threshold = IMAGE_THRESHOLD;
  if (!complete.names[0]) complete.names[0] = "first picture";
  if (!complete.names[1]) complete.names[1] = "second picture";
  return complete;
}

static Status finite_check(const PixelErrors *errors, const char *const names[2], Log *log)
{
  for (int p = 0; p < 2; p++) {
    uint64_t count = 0;
    uint32_t first = 0;
    for (uint32_t y = errors->images[0]->height; y-- > 0;) {
      count += errors->rows[y].not_finite[p];
      if (errors->rows[y].not_finite[p]) first = y;
    }
    if (count)
      return log_fail(log, STATUS_BAD_IMAGE,
                      "%s: %llu pixels are not finite, the first at %u,%u: find out why before comparing it", names[p],
                      (unsigned long long)count, errors->rows[first].not_finite_x[p], first);
  }
  return STATUS_OK;
}

Status pixel_errors_make(PixelErrors *out, const Image *a, const Image *b, const ImageCompareOptions *options, Log *log)
{
  Status status = STATUS_OK;
  size_t count = (size_t)a->width * a->height;
  *out = (PixelErrors){.images = {a, b}, .mask = options->mask, .threshold = options->threshold};
  if (a->width != b->width || a->height != b->height) {
    status = log_fail(log, STATUS_BAD_IMAGE, "%s: %u x %u pixels, and %s has %u x %u: compare pictures of one size",
                      options->names[1], b->width, b->height, options->names[0], a->width, a->height);
    goto done;
  }
  out->rows = calloc(a->height, sizeof *out->rows);
  out->linear = malloc((options->ssim ? 4 : 2) * count * sizeof *out->linear);
  if (!out->rows || !out->linear) {
    status = log_no_memory(log, options->names[1]);
    goto done;
  }
  out->displayed = out->linear + count;
  for (size_t p = 0; p < 2 && options->ssim; p++) out->lumas[p] = out->linear + (2 + p) * count;
  parallel_for(a->height, row_compute, out);
  TRY(finite_check(out, options->names, log));

done:
  if (status) pixel_errors_free(out);
  return status;
}

void pixel_errors_free(PixelErrors *errors)
{
  free(errors->rows);
  free(errors->linear);
  *errors = (PixelErrors){0};
}
