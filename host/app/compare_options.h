// Command line of `frugal compare`.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "report/image_metric.h"

enum { COMPARE_MAX_LIMITS = 32, COMPARE_MAX_MASKS = 8, COMPARE_ALL_METRICS = (1 << IMAGE_METRIC_COUNT) - 1 };

typedef struct CompareLimit {
  int metric;
  double value;
} CompareLimit;

typedef struct CompareLimits {
  CompareLimit items[COMPARE_MAX_LIMITS];
  size_t count;
} CompareLimits;

typedef struct CompareMasks {
  const char *items[COMPARE_MAX_MASKS];
  size_t count;
} CompareMasks;

typedef struct CompareOptions {
  const char *paths[2];
  CompareLimits limits;
  CompareMasks masks;
  uint32_t metrics;  // a bit for each that --metrics names; 0: all but hdr-flip
  double threshold;
  float pixels_per_degree;  // 0: FLIP's default
  bool ignore_alpha, json, help;
  const char *difference_path;  // NULL: none
  uint32_t threads;
  uint64_t max_image_pixels;
} CompareOptions;

// Fills *out from argv[1..]; with --help nothing else counts. Errors: STATUS_USAGE, saying what is expected.
Status compare_options_parse(CompareOptions *out, int argc, char **argv, Log *log);

// Prints what --help prints.
void compare_help(FILE *out);
