// The table by which kernels choose directions of an environment image (shared/scene.h).
#pragma once

#include "base/log.h"
#include "scene/scene.h"

typedef struct EnvironmentTable {
  float *values;  // layout in shared/scene.h; NULL where the environment is no image, or black
  size_t count;
} EnvironmentTable;

// Sums in double precision; about 10 ns a pixel. Pixels that are negative or not finite count as black.
// Errors: STATUS_NO_MEMORY.
Status environment_table_make(EnvironmentTable *out, const Environment *environment, Log *log);
void environment_table_free(EnvironmentTable *table);
