// Four-float vectors and axis-aligned boxes of the BVH builder. Lanes x, y, z; w is free for the holder.
//
// GCC's vector types lower to SSE, NEON or plain floats; minimum and maximum alone need naming on x86.
#pragma once

#include <math.h>
#include <stdint.h>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

typedef float F4 __attribute__((vector_size(16)));
typedef int32_t I4 __attribute__((vector_size(16)));

typedef struct Box {
  F4 low, high;
} Box;

static inline F4 f4(float all) { return (F4){all, all, all, all}; }

// `a < b ? a : b` and `a > b ? a : b` in each lane: the second argument where either is NaN.
static inline F4 f4_min(F4 a, F4 b)
{
#ifdef __SSE__
  return _mm_min_ps(a, b);
#else
  I4 less = a < b;
  return (F4)((less & (I4)a) | (~less & (I4)b));
#endif
}

static inline F4 f4_max(F4 a, F4 b)
{
#ifdef __SSE__
  return _mm_max_ps(a, b);
#else
  I4 greater = a > b;
  return (F4)((greater & (I4)a) | (~greater & (I4)b));
#endif
}

static inline Box box_empty(void) { return (Box){f4(INFINITY), f4(-INFINITY)}; }
static inline Box box_union(Box a, Box b) { return (Box){f4_min(a.low, b.low), f4_max(a.high, b.high)}; }
static inline Box box_with_point(Box a, F4 point) { return (Box){f4_min(point, a.low), f4_max(point, a.high)}; }

// Half the surface area of each of three boxes, by their extents.
static inline F4 half_areas(F4 a, F4 b, F4 c)
{
  F4 x = {a[0], b[0], c[0], 0}, y = {a[1], b[1], c[1], 0}, z = {a[2], b[2], c[2], 0};
  return x * (y + z) + y * z;
}

static inline float half_area(F4 extent) { return extent[0] * (extent[1] + extent[2]) + extent[1] * extent[2]; }
