// The numbers of an ImageError by name, for command lines and reports.
#pragma once

#include <stddef.h>

#include "report/image_compare.h"

typedef struct ImageMetric {
  const char *name;  // with dashes; in JSON with underscores
  size_t field;      // offset of a double in ImageError
  bool larger_is_better;
  const char *help;
} ImageMetric;

enum { IMAGE_METRIC_COUNT = 11 };
extern const ImageMetric image_metrics[IMAGE_METRIC_COUNT];

// Index of a metric by the first `length` letters of `name`; -1: no such metric.
int image_metric_find(const char *name, size_t length);

// The number itself; NAN where there is none.
double image_metric_value(int metric, const ImageError *error);

// May a picture with this error pass, with the limit as the worst that it may have? Never where there is no number.
bool image_metric_within(int metric, const ImageError *error, double limit);
