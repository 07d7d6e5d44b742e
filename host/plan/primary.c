#include "plan/primary.h"

#include <math.h>

// Milliseconds, for T triangles, P pixels and S samples a pixel:
//   raster  fixed + S (T triangle + sqrt(T P) edge + P pixel)
//   rays    fixed + S (sqrt(T P) edge + P pixel)
// sqrt(T P) is how long the outlines of T triangles are that fill P pixels between them: raster tries each triangle on
// the blocks along it, and a packet of rays parts there.
typedef struct PassModel {
  double fixed, triangle, edge, pixel;
} PassModel;

typedef struct PrimaryModel {
  PassModel raster, rays;
} PrimaryModel;

// Fitted to room, chrome, colonnade, field, a bust of 313 k triangles and seven of the shared models (680 to 10^6
// triangles) from 160 x 90 to 1920 x 1080 at 1 and 4 samples: processor time of PoCL on a Zen 5, by two cores; squares
// of the logarithms of predicted to measured. Nearly nine of ten predictions are within a factor of two of what was
// measured; of 108 choices 96 are right, and all together take 0.8 % longer than the best would.
static const PrimaryModel cpu_model = {
    .raster = {.triangle = 4.8e-6, .edge = 1.34e-5, .pixel = 4.9e-7},
    .rays = {.edge = 2.6e-5, .pixel = 1.38e-6},
};

// From what room, colonnade, field and a hall of 743 k triangles took on an H100 at 640 x 360 and 1920 x 1080, packing
// of the triangles included: within 26 %. Raster was never the slower there, and up to twice as quick.
static const PrimaryModel gpu_model = {
    .raster = {.fixed = 0.102, .triangle = 5e-8, .edge = 1.84e-7, .pixel = 2.7e-8},
    .rays = {.fixed = 0.09, .edge = 4.8e-7, .pixel = 6.5e-8},
};

static double pass_ms(const PassModel *m, const PrimaryFacts *facts)
{
  double triangles = (double)facts->triangles, pixels = (double)facts->pixels;
  return m->fixed + facts->samples * (triangles * m->triangle + sqrt(triangles * pixels) * m->edge + pixels * m->pixel);
}

const char *primary_name(PrimaryMethod method)
{
  static const char *const names[] = {"auto", "raster", "rays"};
  return names[method];
}

PrimaryCost primary_cost(const PrimaryFacts *facts)
{
  const PrimaryModel *model = facts->gpu ? &gpu_model : &cpu_model;
  return (PrimaryCost){pass_ms(&model->raster, facts), pass_ms(&model->rays, facts)};
}

PrimaryMethod primary_choose(PrimaryMethod asked, const PrimaryCost *cost)
{
  if (asked != PRIMARY_AUTO) return asked;
  return cost->raster_ms < cost->rays_ms ? PRIMARY_RASTER : PRIMARY_RAYS;
}
