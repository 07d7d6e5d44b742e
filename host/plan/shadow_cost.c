#include "plan/shadow_cost.h"

#include <math.h>

// Milliseconds for T triangles, P pixels, S samples a pixel and M maps:
//   rays    S (fixed + sqrt(T P) edge + P pixel)
//   hybrid  maps_fixed + T M map_triangle + sqrt(T P) map_edge + P map_pixel + S (judge_fixed + sqrt(T P) judge_edge
//           + P judge_pixel)
// sqrt(T P) is how long the outlines of T triangles are that fill P pixels, as in plan/primary.c; a map has about as
// many texels where receivers are as the picture has pixels.
typedef struct ShadowModel {
  double fixed, edge, pixel;
  double maps_fixed, map_triangle, map_edge, map_pixel;
  double judge_fixed, judge_edge, judge_pixel;
} ShadowModel;

// From room, chrome, colonnade and field at 1920 x 1080: processor time of PoCL's kernels on a Zen 5, divided by its
// two cores. Both within 15 %, but for a picture of colonnade by hybrid, which takes 1.4 times as much.
static const ShadowModel cpu_model = {
    .edge = 2.9e-5,
    .pixel = 6.3e-6,
    .map_triangle = 4e-6,
    .map_edge = 1.7e-5,
    .judge_edge = 2e-5,
    .judge_pixel = 2.4e-6,
};

// From room, colonnade and field on an H100 with all tiles of the maps drawn: within 30 %.
static const ShadowModel gpu_model = {
    .fixed = 0.06,
    .edge = 3.2e-7,
    .pixel = 1.15e-7,
    .maps_fixed = 0.1,
    .map_triangle = 8e-7,
    .judge_fixed = 0.05,
    .judge_edge = 2.7e-7,
    .judge_pixel = 1e-7,
};

static const double gain_least = 0.9;

ShadowCost shadow_cost(const ShadowCostFacts *facts)
{
  const ShadowModel *m = facts->gpu ? &gpu_model : &cpu_model;
  double triangles = (double)facts->triangles, pixels = (double)facts->pixels, edges = sqrt(triangles * pixels);
  double maps = m->maps_fixed + triangles * facts->maps * m->map_triangle + edges * m->map_edge + pixels * m->map_pixel;
  return (ShadowCost){
      .rays_ms = facts->samples * (m->fixed + edges * m->edge + pixels * m->pixel),
      .hybrid_ms = maps + facts->samples * (m->judge_fixed + edges * m->judge_edge + pixels * m->judge_pixel),
  };
}

bool shadow_hybrid_gains(const ShadowCost *cost) { return cost->hybrid_ms < gain_least * cost->rays_ms; }
