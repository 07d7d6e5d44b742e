// Rays that are likely to find a tracer's mistakes.
#pragma once

#include "support/trace_fixture.h"

typedef enum RayKind {
  RAY_ANYWHERE,  // through the bounds, from in or about them
  RAY_AT_FACE,   // at a point of a triangle, from outside
  RAY_AT_EDGE,   // at a point of an edge
  RAY_AT_VERTEX,
  RAY_AXIS_PARALLEL,  // through a vertex or a point of a face; the other components are 0 or -0
  RAY_IN_PLANE,       // one component 0 or -0, at a vertex, from its height
  RAY_FROM_SURFACE,   // from a point of a face, rounded
  RAY_FROM_VERTEX,
  RAY_GRAZING,    // to a point of a face from another one, lifted by 10^-1 to 10^-7 of the distance
  RAY_FROM_AFAR,  // from 10^4 times the size of the bounds, at an edge
  RAY_SEGMENT,    // t_max at, just before or just behind a point of a face
  RAY_INACTIVE,   // t_max < 0
  RAY_KINDS
} RayKind;

// The rays take turns: ray i is of kind i % RAY_KINDS. Directions have lengths from 10^-2 to 10^2.
void trace_rays_make(TraceRay *out, uint32_t count, const Soup *soup, uint64_t seed);

// Prints ray `i` of trace_rays_make so that it can be traced again.
void trace_ray_print(const char *what, const TraceRay *ray, uint32_t i);
