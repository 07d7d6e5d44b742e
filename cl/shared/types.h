// Basic types that host (C11) and device (OpenCL C) share. Structs here are tightly packed: no member needs more than
// 4-byte alignment, so both compilers lay them out alike; SHARED_SIZE proves it on each side.
#ifndef SHARED_TYPES_H
#define SHARED_TYPES_H

#ifndef __OPENCL_VERSION__
#include <stdint.h>
#include <sys/types.h>
#endif

#define SHARED_SIZE(Type, bytes) typedef char Type##_has_##bytes##_bytes[sizeof(Type) == (bytes) ? 1 : -1]

typedef struct Float3 {
  float x, y, z;
} Float3;
SHARED_SIZE(Float3, 12);

typedef struct Float2 {
  float x, y;
} Float2;
SHARED_SIZE(Float2, 8);

typedef struct Float4 {
  float x, y, z, w;
} Float4;
SHARED_SIZE(Float4, 16);

#endif
