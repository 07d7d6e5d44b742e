// Monotonic clocks.
#pragma once

#include <time.h>

// Milliseconds since an arbitrary fixed point.
static inline double clock_ms(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

// Milliseconds that this thread has computed: other work on the machine does not count.
static inline double clock_thread_ms(void)
{
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}
