#include "report/image_metric.h"

#include <string.h>

#define FIELD(member) offsetof(ImageError, member)

const ImageMetric image_metrics[IMAGE_METRIC_COUNT] = {
    {"over", FIELD(over_share), false, "share of pixels over the threshold"},
    {"rmse", FIELD(rmse), false, "root of the mean squared error, linear"},
    {"relative-mse", FIELD(relative_mse), false, "mean of (b - a)^2 / (a^2 + 0.01), linear"},
    {"max", FIELD(max), false, "largest pixel error, linear"},
    {"p99", FIELD(p99), false, "99th percentile of pixel errors, linear"},
    {"max-displayed", FIELD(max_displayed), false, "largest pixel error, displayed"},
    {"p99-displayed", FIELD(p99_displayed), false, "99th percentile of pixel errors, displayed"},
    {"psnr", FIELD(psnr), true, "peak signal to noise, dB, displayed"},
    {"ssim", FIELD(ssim), true, "structural similarity, displayed luma"},
    {"flip", FIELD(flip), false, "mean FLIP, displayed"},
    {"hdr-flip", FIELD(hdr_flip), false, "mean FLIP, over the exposures of radiance"},
};

int image_metric_find(const char *name, size_t length)
{
  for (int i = 0; i < IMAGE_METRIC_COUNT; i++)
    if (strlen(image_metrics[i].name) == length && strncmp(image_metrics[i].name, name, length) == 0) return i;
  return -1;
}

double image_metric_value(int metric, const ImageError *error)
{
  double value;
  memcpy(&value, (const char *)error + image_metrics[metric].field, sizeof value);
  return value;
}

bool image_metric_within(int metric, const ImageError *error, double limit)
{
  double value = image_metric_value(metric, error);
  return image_metrics[metric].larger_is_better ? value >= limit : value <= limit;
}
