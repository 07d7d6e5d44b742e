#include "device_scene/environment_levels.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "device_scene/ggx_sample.h"
#include "shared/scene.h"

enum { SOURCE_WIDTH = 512, SOURCE_HEIGHT = 256, SOURCES = 8 };

// Samples of a pixel of a level: many where pixels are few.
static int level_samples(int level) { return level < 3 ? 1024 : 4096 >> level; }

// One equirectangular picture of the chain, [height][width][3].
typedef struct Source {
  float *pixels;
  int width, height;
} Source;

typedef struct LevelsWork {
  const Environment *environment;
  Source sources[SOURCES];  // each half as wide as the one before
  float *pixels;
} LevelsWork;

static void gradient_radiance(const Environment *environment, double y, float out[3])
{
  const float *pole = y >= 0 ? environment->zenith : environment->ground;
  for (int c = 0; c < 3; c++)
    out[c] = (float)(environment->horizon[c] + fabs(y) * (pole[c] - environment->horizon[c])) * environment->intensity;
}

// First pixel and the one after the last that a pixel of the first source stands for.
static void pixel_range(uint32_t range[2], int at, int count, uint32_t of)
{
  range[0] = (uint32_t)((uint64_t)at * of / (unsigned)count);
  range[1] = (uint32_t)((uint64_t)(at + 1) * of / (unsigned)count);
  if (range[1] == range[0]) range[1]++;
}

static void source_row_make(void *context, size_t index)
{
  LevelsWork *work = context;
  const Environment *environment = work->environment;
  const Image *image = &environment->image;
  int row = (int)index;
  float *out = work->sources[0].pixels + index * SOURCE_WIDTH * 3;
  if (environment->kind == ENVIRONMENT_GRADIENT) {
    gradient_radiance(environment, cos(M_PI * (row + 0.5) / SOURCE_HEIGHT), out);
    for (int column = 1; column < SOURCE_WIDTH; column++) memcpy(out + 3 * column, out, 3 * sizeof *out);
    return;
  }
  for (int column = 0; column < SOURCE_WIDTH; column++, out += 3) {
    uint32_t rows[2], columns[2];
    pixel_range(rows, row, SOURCE_HEIGHT, image->height);
    pixel_range(columns, column, SOURCE_WIDTH, image->width);
    double sum[3] = {0}, weights = 0;
    for (uint32_t y = rows[0]; y < rows[1]; y++) {
      double weight = sin(M_PI * (y + 0.5) / image->height);
      for (uint32_t x = columns[0]; x < columns[1]; x++) {
        const float *pixel = image->pixels + 4 * ((size_t)y * image->width + x);
        for (int c = 0; c < 3; c++) sum[c] += weight * pixel[c];
        weights += weight;
      }
    }
    for (int c = 0; c < 3; c++) out[c] = (float)(sum[c] / weights);
  }
}

static void source_halve(Source *out, const Source *from)
{
  for (int row = 0; row < out->height; row++) {
    float upper = (float)sin(M_PI * (2 * row + 0.5) / from->height),
          lower = (float)sin(M_PI * (2 * row + 1.5) / from->height);
    float share = upper / (upper + lower);
    const float *a = from->pixels + (size_t)(2 * row) * (unsigned)from->width * 3, *b = a + from->width * 3;
    float *to = out->pixels + (size_t)row * (unsigned)out->width * 3;
    for (int i = 0; i < out->width; i++)
      for (int c = 0; c < 3; c++)
        to[3 * i + c] =
            0.5f * (share * (a[6 * i + c] + a[6 * i + 3 + c]) + (1 - share) * (b[6 * i + c] + b[6 * i + 3 + c]));
  }
}

// A sample of a row of a level: where it looks, relative to the pixel it is for.
typedef struct RowSample {
  const Source *source;
  float turn, v;  // shares of the picture's width and height
  float weight;   // 0: below the horizon
} RowSample;

// In the frame of a pixel at the polar angle theta.
static RowSample row_sample(const LevelsWork *work, int i, int count, double alpha, double theta)
{
  const GgxSample ggx = ggx_sample(i, count, alpha);
  RowSample sample = {.weight = (float)fmax(ggx.up, 0)};
  if (ggx.up <= 0) return sample;
  double horizontal = ggx.up * sin(theta) + ggx.along * cos(theta), y = ggx.up * cos(theta) - ggx.along * sin(theta);
  sample.turn = (float)(atan2(ggx.across, horizontal) / (2 * M_PI));
  sample.v = (float)(acos(fmax(-1, fmin(1, y))) / M_PI);

  // Solid angle of the sample over that of a pixel of the first source.
  double pixel = 2 * M_PI * M_PI / (SOURCE_WIDTH * SOURCE_HEIGHT) * fmax(sin(M_PI * sample.v), 0.5 / SOURCE_HEIGHT);
  int level = (int)lrint(0.5 * log2(1 / (count * ggx.density) / pixel) + 0.5);
  sample.source = &work->sources[level < 0 ? 0 : level < SOURCES ? level : SOURCES - 1];
  return sample;
}

// Adds a sample to the first `count` pixels of a row that is `width` wide.
static void sample_add(float *row, int width, int count, const RowSample *sample)
{
  const Source *source = sample->source;
  float y = sample->v * (float)source->height - 0.5f, top = floorf(y), down = y - top;
  int first = top < 0 ? 0 : (int)top, second = (int)top + 1 < source->height ? (int)top + 1 : source->height - 1;
  const float *a = source->pixels + (size_t)first * (unsigned)source->width * 3;
  const float *b = source->pixels + (size_t)second * (unsigned)source->width * 3;
  float step = (float)source->width / (float)width, upper = sample->weight * (1 - down), lower = sample->weight * down;
  float x = (0.5f / (float)width + sample->turn + 1) * (float)source->width - 0.5f;
  for (int i = 0; i < count; i++, x += step) {
    int left = (int)x;
    float across = x - (float)left;
    left &= source->width - 1;
    int right = (left + 1) & (source->width - 1);
    float ul = upper * (1 - across), ur = upper * across, ll = lower * (1 - across), lr = lower * across;
    for (int c = 0; c < 3; c++)
      row[4 * i + c] += ul * a[3 * left + c] + ur * a[3 * right + c] + ll * b[3 * left + c] + lr * b[3 * right + c];
  }
}

// Rows of all levels, one after the other.
static void level_row_make(void *context, size_t index)
{
  LevelsWork *work = context;
  int level = 0, row = (int)index;
  float *pixels = work->pixels;
  while (row >= ENVIRONMENT_LEVEL_WIDTH(level) / 2) {
    row -= ENVIRONMENT_LEVEL_WIDTH(level) / 2;
    pixels += 2 * ENVIRONMENT_LEVEL_WIDTH(level) * ENVIRONMENT_LEVEL_WIDTH(level);
    level++;
  }
  int width = ENVIRONMENT_LEVEL_WIDTH(level), height = width / 2;
  float *out = pixels + 4 * (size_t)row * (unsigned)width, sum = 0;
  double alpha = exp2(-level), theta = M_PI * (row + 0.5) / height;
  int count = work->environment->kind == ENVIRONMENT_GRADIENT ? 1 : width;  // of different pixels
  for (int i = 0; i < 4 * count; i++) out[i] = 0;
  int samples = level_samples(level);
  for (int i = 0; i < samples; i++) {
    RowSample sample = row_sample(work, i, samples, alpha, theta);
    if (sample.weight > 0) sample_add(out, width, count, &sample);
    sum += sample.weight;
  }
  for (int i = 0; i < 4 * count; i++) out[i] /= sum;
  for (int i = count; i < width; i++) memcpy(out + 4 * i, out, 4 * sizeof *out);
}

// A surface reads the levels on both sides of its roughness; rounding may move it a little.
static int levels_needed(float least_roughness)
{
  double level = least_roughness > 0 ? -2 * log2(least_roughness) + 0.01 : ENVIRONMENT_LEVELS;
  if (level < 0) level = 0;
  return level < ENVIRONMENT_LEVELS - 2 ? (int)level + 2 : ENVIRONMENT_LEVELS;
}

Status environment_levels_make(EnvironmentLevels *out, const Environment *environment, float least_roughness, Log *log)
{
  Status status = STATUS_OK;
  int levels = levels_needed(least_roughness);
  size_t floats = 4 * (size_t)ENVIRONMENT_LEVEL_FIRST(levels), rows = 0;
  LevelsWork work = {.environment = environment};
  *out = (EnvironmentLevels){0};
  if (environment->kind == ENVIRONMENT_CONSTANT) return STATUS_OK;
  for (int i = 0; i < SOURCES; i++) {
    Source *source = &work.sources[i];
    *source = (Source){.width = SOURCE_WIDTH >> i, .height = SOURCE_HEIGHT >> i};
    source->pixels = malloc((size_t)source->width * (size_t)source->height * 3 * sizeof *source->pixels);
    if (!source->pixels) status = STATUS_NO_MEMORY;
  }
  work.pixels = malloc(floats * sizeof *work.pixels);
  if (status || !work.pixels) {
    status = log_no_memory(log, "environment");
    goto done;
  }
  parallel_for(SOURCE_HEIGHT, source_row_make, &work);
  for (int i = 1; i < SOURCES; i++) source_halve(&work.sources[i], &work.sources[i - 1]);
  for (int level = 0; level < levels; level++) rows += ENVIRONMENT_LEVEL_WIDTH(level) / 2;
  parallel_for(rows, level_row_make, &work);
  *out = (EnvironmentLevels){work.pixels, floats};
  work.pixels = NULL;

done:
  for (int i = 0; i < SOURCES; i++) free(work.sources[i].pixels);
  free(work.pixels);
  return status;
}

void environment_levels_free(EnvironmentLevels *levels)
{
  free(levels->pixels);
  *levels = (EnvironmentLevels){0};
}
