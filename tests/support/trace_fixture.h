// The traverse + intersect passes as tests drive them: a soup on a device, rays in, hits out, by each kernel and width.
#pragma once

#include "passes/trace.h"
#include "support/oracle_trace.h"
#include "support/soup_scene.h"

// Every kernel that can run on a CPU device; the third is what a GPU runs, work-groups and all.
typedef enum TraceKernel { TRACE_PACKET_16, TRACE_PACKET_8, TRACE_PACKET_1, TRACE_SINGLE, TRACE_KERNELS } TraceKernel;
extern const char *const trace_kernel_names[TRACE_KERNELS];

typedef struct TraceRay {
  float origin[3], direction[3], t_max;
} TraceRay;

typedef struct TraceHit {
  uint32_t triangle;  // HIT_NONE (ORACLE_MISS) for none
  float t, u, v;      // 0 where none
} TraceHit;

enum { TRACE_WIDTHS = 3, TRACE_CAPACITY = 1 << 16 };

typedef struct TraceFixture {
  Scene model;
  OracleScene oracle;
  Device *device;
  DeviceScene scene;
  Tracer tracers[TRACE_WIDTHS];
  RayStream stream;  // of two segments: any-hit rays go into the second
  HitStream hits;
  DeviceBuffer radiance;
} TraceFixture;

// Opens a CPU device and puts the soup there; it may be freed then. *out must stay where it is: the oracle points into
// it. Failures of any of these functions fail the test.
void trace_fixture_make(TraceFixture *out, const Soup *soup);
void trace_fixture_free(TraceFixture *fixture);

// Closest hits with t_min < t <= t_max, TRACE_CAPACITY rays a launch.
void trace_fixture_closest(TraceHit *out, TraceFixture *fixture, TraceKernel kernel, const TraceRay *rays,
                           uint32_t count, float t_min);

// out[i]: ray i is active and nothing blocks it. Fails the test where a weight goes to a wrong slot.
void trace_fixture_lit(bool *out, TraceFixture *fixture, TraceKernel kernel, const TraceRay *rays, uint32_t count);

// What an honest triangle test in float may be off by, as a share of the distance of the triangle's vertices: a sheared
// coordinate takes at most 6 roundings of 2^-24, so that a vertex is off by 6 x sqrt(2) of them across the ray.
#define TRACE_ROUNDING (8 * 0x1p-24)

// Within this of its start (OracleRay.start_margin) a ray may miss what it starts on: triangle_intersect bounds the
// error of t by 3 x (12 x y + 4 z (x + y)) roundings over the determinant, with x, y, z up to the distance of the
// vertices.
#define TRACE_START_MARGIN (64 * 0x1p-24)

// Within this of its end any hit may miss what it ends on: 3 times that error (cl/lib/hit.cl).
#define TRACE_END_MARGIN (3 * TRACE_START_MARGIN)

// The same ray for the oracle, with these margins; culls as camera rays do if `cull`.
OracleRay trace_oracle_ray(const TraceRay *ray, bool cull);
