// Which device the tests run on: the CPU's, at several widths; with FRUGAL_DEVICE=gpu a GPU, whose lanes are work-items.
#pragma once

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static inline bool test_on_gpu(void)
{
  const char *device = getenv("FRUGAL_DEVICE");
  return device && strcmp(device, "gpu") == 0;
}

// For device_open.
static inline const char *test_device(void) { return test_on_gpu() ? "gpu" : "cpu"; }
