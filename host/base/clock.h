// Monotonic wall clock.
#pragma once

#include <time.h>

// Milliseconds since an arbitrary fixed point.
static inline double clock_ms(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}
