// Fork-join loops over the machine's cores.
#pragma once

#include <stddef.h>

typedef void (*ParallelBody)(void *context, size_t index);

// Number of threads a loop may use: `parallel_set_threads` if called with a number above 0, else the cores this
// process may run on.
unsigned parallel_threads(void);
void parallel_set_threads(unsigned count);

// Calls body(context, i) once for each i in [0, count), on up to parallel_threads() threads, and returns when all are
// done. Calls may run in any order; what they write must not depend on it. About 50 us to start; runs on the calling
// thread alone where no thread can be made.
void parallel_for(size_t count, ParallelBody body, void *context);
