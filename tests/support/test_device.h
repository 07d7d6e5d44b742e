// Which device the tests run on: the CPU's, at several widths; with FRUGAL_DEVICE=gpu a GPU, whose lanes are
// work-items.
#pragma once

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static inline bool test_on_gpu(void)
{
  const char *device = getenv("FRUGAL_DEVICE");
  return device && strcmp(device, "gpu") == 0;
}

// For what is PoCL's alone: says that it is left out, on a GPU.
static inline bool test_skips_on_gpu(const char *what)
{
  if (test_on_gpu()) fprintf(stderr, "SKIPPED: %s: on a GPU\n", what);
  return test_on_gpu();
}

// For device_open: what FRUGAL_DEVICE says, else the CPU.
static inline const char *test_device(void) { return getenv("FRUGAL_DEVICE") ? NULL : "cpu"; }
