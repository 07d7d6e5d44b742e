#include "plan/shadow_cost.h"

#include <math.h>

// Milliseconds for T triangles, P pixels, S samples a pixel and M maps:
//   rays    S (fixed + sqrt(T P) edge + P pixel)
//   maps    maps_fixed + T M map_triangle + T map_list + P map_pixel
//   judged  S (judge_fixed + sqrt(T P) judge_edge + P judge_pixel); x verdict_known where verdicts are kept
// sqrt(T P) is how long the outlines of T triangles are that fill P pixels, as in plan/primary.c.
typedef struct ShadowModel {
  double fixed, edge, pixel;
  double maps_fixed, map_triangle, map_list, map_pixel;
  double judge_fixed, judge_edge, judge_pixel;
  double verdict_known;
} ShadowModel;

// From room, chrome, colonnade and field at 1280 x 720 and 1920 x 1080: processor time of PoCL's kernels on a Zen 5,
// above that without shadows, divided by its two cores. Within 30 %; a single picture by hybrid takes 15 %
// less than this in chrome, and 25 % more in colonnade.
static const ShadowModel cpu_model = {
    .edge = 2.9e-5,
    .pixel = 6.3e-6,
    .map_triangle = 4e-6,
    .map_list = 4.5e-5,
    .map_pixel = 4e-7,
    .judge_edge = 1.6e-5,
    .judge_pixel = 1.2e-6,
    .verdict_known = 1.0 / 3,
};

// From room, chrome, colonnade, field and carousel on an H200 at 1280 x 720 and 1920 x 1080, 1 to 16 samples: rays
// within 15 %, hybrid within 30 %; of field at one sample it takes less than half of this.
static const ShadowModel gpu_model = {
    .fixed = 0.064,
    .edge = 1.9e-7,
    .pixel = 8.3e-8,
    .maps_fixed = 0.4,
    .map_triangle = 6.5e-7,
    .map_list = 8e-7,
    .judge_fixed = 0.1,
    .judge_edge = 7e-8,
    .judge_pixel = 2e-8,
    .verdict_known = 1,
};

static const double share_most = 0.5;  // of the rays' time, for which hybrid is taken

ShadowCost shadow_cost(const ShadowCostFacts *facts)
{
  const ShadowModel *m = facts->gpu ? &gpu_model : &cpu_model;
  double triangles = (double)facts->triangles, pixels = (double)facts->pixels, edges = sqrt(triangles * pixels);
  double drawn = m->maps_fixed + triangles * (facts->maps * m->map_triangle + m->map_list),
         marked = pixels * m->map_pixel;
  double judged = facts->samples * (m->judge_fixed + edges * m->judge_edge + pixels * m->judge_pixel);
  double frames = facts->frames > 1 ? facts->frames : 1;
  double anew = facts->kept < 1 ? (1 - facts->kept) * drawn + marked : 0;
  double known = facts->kept * (1 - m->verdict_known) * judged;
  return (ShadowCost){
      .rays_ms = facts->samples * (m->fixed + edges * m->edge + pixels * m->pixel),
      .hybrid_ms = drawn + marked + judged,
      .kept_ms = judged,
      .sequence_ms = judged + (drawn + marked + (frames - 1) * anew - fmax(frames - 2, 0) * known) / frames,
  };
}

bool shadow_hybrid_gains(const ShadowCost *cost) { return cost->sequence_ms < share_most * cost->rays_ms; }
