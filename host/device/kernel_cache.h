// Where the OpenCL runtime keeps compiled kernels from run to run.
#pragma once

#include <limits.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct KernelCache {
  char folder[PATH_MAX];
  bool is_temporary;  // in place of a folder that cannot be written or is full; goes when the program ends
  uint64_t bytes;
  uint32_t files;
} KernelCache;

// Gives PoCL a folder that it can write: where its own is read-only or full it would fail to build any kernel, or
// not start at all. Called before anything else of OpenCL; does its work once. A temporary folder is removed at exit.
void kernel_cache_prepare(void);

// Why a temporary folder had to take the place of PoCL's own; NULL where it did not.
const char *kernel_cache_unusable(void);

// Whether PoCL leaves in its cache what it has compiled, for other processes.
bool kernel_cache_is_kept(void);

// What is in PoCL's cache now, or with `nvidia` in the NVIDIA driver's; false where there is none. Reads the folders.
bool kernel_cache_read(KernelCache *out, bool nvidia);

// Removes a temporary cache. For a signal handler that is about to end the program: async-signal-safe.
void kernel_cache_remove_temporary(void);
