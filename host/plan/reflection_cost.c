#include "plan/reflection_cost.h"

#include <math.h>

static const double traced_share = 0.1, shaded_share = 0.5;

// Nanoseconds. Tracing a ray: trace + edge sqrt(triangles); looking one up: lookup + march a texel of a face's side;
// `texel` is what drawing one takes besides a ray of its own.
typedef struct ReflectionModel {
  double fixed_ms, trace, edge, shade, shadow, lookup, march, texel;
} ReflectionModel;

// From what room, chrome, colonnade and a hall of 743 k triangles took at 640 x 360 with PoCL on two cores of a Zen 4:
// no gain was measured on any of them, however many samples. Lookups and what lists add to a texel: the room's ball,
// maps of 64 to 512 texels a side, a loaded Zen 5.
static const ReflectionModel cpu_model = {
    .trace = 20, .edge = 0.5, .shade = 35, .shadow = 30, .lookup = 300, .march = 0.8, .texel = 150};

// From what lookups, tracing and drawing maps took at 1920 x 1080 on an H100, before hybrid reflections were there.
static const ReflectionModel gpu_model = {.fixed_ms = 0.3,
                                          .trace = 0.3,
                                          .edge = 4e-4,
                                          .shade = 0.2,
                                          .shadow = 0.15,
                                          .lookup = 0.05,
                                          .march = 3e-4,
                                          .texel = 1.2};

ReflectionCost reflection_cost(const ReflectionFacts *facts)
{
  const ReflectionModel *m = facts->gpu ? &gpu_model : &cpu_model;
  double light = m->shade + facts->lights * m->shadow, trace = m->trace + m->edge * sqrt((double)facts->triangles);
  double texels = 6.0 * facts->size_px * facts->size_px;
  double asked = m->lookup + m->march * facts->size_px + traced_share * (trace + light) + shaded_share * light;
  return (ReflectionCost){
      .rays_ms = 1e-6 * facts->rays * (trace + light),
      .hybrid_ms = m->fixed_ms + 1e-6 * (texels * (trace + light + m->texel) + facts->rays * asked)};
}
