// How much is done by tests that sample: more with FRUGAL_TEST_FULL=1 (`make test-full`), less with FRUGAL_TEST_QUICK=1
// for builds that are slow themselves (`make sanitize`).
#pragma once

#include <stdbool.h>
#include <stdlib.h>

static inline bool effort_asked(const char *variable)
{
  const char *value = getenv(variable);
  return value && value[0] == '1';
}

static inline bool effort_is_full(void) { return effort_asked("FRUGAL_TEST_FULL"); }
static inline bool effort_is_quick(void) { return effort_asked("FRUGAL_TEST_QUICK"); }
