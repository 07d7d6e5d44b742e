#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "report/pixel_errors.h"

typedef struct FalseColor {
  const PixelErrors *errors;
  float (*pixels)[3];  // [height][width], in [0, 1], displayed
} FalseColor;

static void color_mix(float out[3], const float from[3], const float to[3], float t)
{
  for (int c = 0; c < 3; c++) out[c] = from[c] + (to[c] - from[c]) * t;
}

static void color_of(float out[3], float difference, float threshold)
{
  static const float outside[3] = {0.25f, 0.25f, 0.25f}, black[3] = {0}, blue[3] = {0.1f, 0.3f, 1};
  static const float stops[][3] = {{0, 0.7f, 0.2f}, {1, 0.9f, 0}, {0.9f, 0, 0}, {1, 1, 1}};
  const int last = sizeof stops / sizeof *stops - 1;
  if (difference < 0) {
    color_mix(out, outside, outside, 0);
  } else if (difference <= threshold || threshold >= 1) {
    color_mix(out, black, blue, fminf(difference / threshold, 1));
  } else {
    float at = (float)last * fminf(logf(difference / threshold) / logf(1 / threshold), 1);
    int stop = at < (float)last ? (int)at : last - 1;
    color_mix(out, stops[stop], stops[stop + 1], at - (float)stop);
  }
}

static void row_color(void *context, size_t y)
{
  const FalseColor *job = context;
  size_t width = job->errors->images[0]->width;
  for (size_t i = y * width; i < (y + 1) * width; i++)
    color_of(job->pixels[i], job->errors->displayed[i], (float)(job->errors->threshold + IMAGE_ROUNDING));
}

Status image_difference_write(ImageHelper *helper, const char *path, const Image *a, const Image *b,
                              const ImageCompareOptions *given, Log *log)
{
  Status status = STATUS_OK;
  ImageCompareOptions options = image_compare_options(given);
  PixelErrors errors;
  FalseColor job = {.errors = &errors};
  options.ssim = false;
  TRY(pixel_errors_make(&errors, a, b, &options, log));
  job.pixels = malloc((size_t)a->width * a->height * sizeof *job.pixels);
  if (!job.pixels) {
    status = log_no_memory(log, path);
    goto done;
  }
  parallel_for(a->height, row_color, &job);
  ImageChannels group = {{"R", "G", "B"}, 3, 3, job.pixels, 0};
  ImageOutput output = {
      .width = a->width, .height = a->height, .groups = &group, .group_count = 1, .bit_depth = 8, .quality = 95};
  TRY(image_write(helper, path, NULL, &output, log));

done:
  free(job.pixels);
  pixel_errors_free(&errors);
  return status;
}
