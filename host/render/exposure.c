#include "render/exposure.h"

#include <math.h>

static const double middle_grey = 0.18, black_ratio = 0x1p-16;

static bool shows_surface(const float *sum, uint32_t samples) { return 2 * sum[3] >= (float)samples; }

static double luminance(const float *rgb) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }

LightMeter light_meter_read(const float *sums, size_t pixel_count, uint32_t samples)
{
  LightMeter meter = {0};
  double brightest = 0, sum = 0;
  for (size_t i = 0; i < pixel_count; i++) {
    const float *pixel = sums + 4 * i;
    if (!shows_surface(pixel, samples)) continue;
    meter.surface_pixels++;
    double value = luminance(pixel);
    if (value > brightest && value < INFINITY) brightest = value;
  }
  for (size_t i = 0; i < pixel_count && brightest > 0; i++) {
    const float *pixel = sums + 4 * i;
    double value = luminance(pixel);
    if (!shows_surface(pixel, samples) || !(value >= brightest * black_ratio && value < INFINITY)) continue;
    meter.lit_pixels++;
    sum += log2(value / samples);
  }
  if (meter.lit_pixels) meter.log2_luminance = sum / (double)meter.lit_pixels;
  return meter;
}

float light_meter_exposure_ev(const LightMeter *meter)
{
  if (!meter->lit_pixels) return 0;
  double ev = round(100 * (log2(middle_grey) - meter->log2_luminance)) / 100;
  return (float)fmin(fmax(ev, -64), 64);
}

PictureVerdict picture_judge(const float *picture, const float *sums, size_t pixel_count, uint32_t samples)
{
  static const float dim = 8.5f / 255, white = 254.5f / 255;
  uint64_t surfaces = 0, visible = 0, blown = 0;
  for (size_t i = 0; i < pixel_count; i++) {
    const float *pixel = picture + 4 * i;
    if (!shows_surface(sums + 4 * i, samples)) continue;
    surfaces++;
    visible += pixel[0] > dim || pixel[1] > dim || pixel[2] > dim;
    blown += pixel[0] >= white && pixel[1] >= white && pixel[2] >= white;
  }
  if (surfaces == 0) return PICTURE_EMPTY;
  if (100 * visible < surfaces) return PICTURE_BLACK;
  return 2 * blown > surfaces ? PICTURE_BLOWN : PICTURE_FINE;
}
