#include "support/oracle_image.h"

#include <stdlib.h>

#include "base/parallel.h"
#include "support/oracle_camera.h"
#include "support/oracle_environment.h"
#include "support/oracle_surface.h"

enum { DOME_ROWS = 48, DOME_INNER = 3 };

OracleOptions oracle_options(uint32_t width, uint32_t height, uint32_t samples)
{
  return (OracleOptions){.width = width,
                         .height = height,
                         .samples = samples,
                         .model = ORACLE_PBR,
                         .ambient = 0.05,
                         .max_depth = 8,
                         .cast_shadows = true};
}

bool oracle_image_stable(const OracleImage *image, uint32_t x, uint32_t y)
{
  return image->margins[(size_t)y * image->width + x] > ORACLE_STABLE;
}

void oracle_image_free(OracleImage *image)
{
  free(image->radiance);
  free(image->margins);
  *image = (OracleImage){0};
}

// What all rays of an image share.
typedef struct Tracer {
  const OracleScene *scene;
  const OracleOptions *options;
  OracleDome dome;  // empty where no environment lights surfaces
} Tracer;

static double largest(Vec3 a) { return fmax(a.x, fmax(a.y, a.z)); }

static Tracer tracer_make(OracleScene *scene, const OracleOptions *options)
{
  Tracer tracer = {.scene = scene, .options = options};
  const Environment *environment = &scene->model->environment;
  scene->coverage = oracle_surface_coverage;
  bool black = environment->kind == ENVIRONMENT_CONSTANT && !(largest(vec3_from_floats(environment->constant)) > 0);
  if (options->model == ORACLE_PBR && environment->intensity > 0 && !black)
    tracer.dome = oracle_dome_make(environment, DOME_ROWS, DOME_INNER);
  return tracer;
}

// A ray that leaves the hit triangle.
static OracleRay ray_from(const Tracer *tracer, const OraclePoint *point, const OracleHit *hit, Vec3 direction,
                          double t_max)
{
  double scale_m = tracer->scene->scale_m;
  OracleRay ray = oracle_ray(point->position_world, direction, 1e-9 * scale_m / vec3_length(direction), t_max);
  ray.skip = hit->triangle;
  ray.reach_m = 0.1 * scale_m;
  return ray;
}

static Vec3 lights_at(const Tracer *tracer, const OraclePoint *point, const OracleHit *hit, Vec3 view, double *margin)
{
  Vec3 sum = {0};
  for (uint32_t i = 0; i < tracer->scene->model->light_count; i++) {
    OracleArrival arrival = oracle_light_at(&tracer->scene->model->lights[i], point->position_world);
    bool directional = !isfinite(arrival.distance_m);
    if (!point->surface.unlit && vec3_dot(point->normal_world, arrival.direction) > 0 &&
        largest(arrival.irradiance) > 0)
      *margin = fmin(*margin, fabs(vec3_dot(point->geometric_world, arrival.direction)));
    Vec3 direct = oracle_direct(tracer->options->model, &point->surface, point->normal_world, point->geometric_world,
                                view, &arrival);
    if (!(largest(direct) > 0)) continue;
    double lit = 1;
    if (tracer->options->cast_shadows) {
      double length_m = directional ? 1 : arrival.distance_m;
      OracleRay shadow =
          ray_from(tracer, point, hit, vec3_scale(arrival.direction, length_m), directional ? INFINITY : 1);
      lit = oracle_lit(tracer->scene, &shadow, margin);
    }
    sum = vec3_add(sum, vec3_scale(direct, lit));
  }
  return sum;
}

static Vec3 radiance_along(const Tracer *tracer, const OracleRay *ray, Vec3 throughput, uint32_t depth, double *margin);

static Vec3 reflection_at(const Tracer *tracer, const OraclePoint *point, const OracleHit *hit, Vec3 view,
                          Vec3 throughput, uint32_t depth, double *margin)
{
  if (point->surface.unlit || !oracle_is_mirror(&point->surface) || depth >= tracer->options->max_depth)
    return vec3(0, 0, 0);
  double n_dot_v = vec3_dot(point->normal_world, view);
  Vec3 weight = oracle_reflectance(tracer->options->model, &point->surface, n_dot_v);
  Vec3 rest = vec3_mul(throughput, weight);
  *margin = fmin(*margin, fabs(largest(rest) * 255 - 1));
  if (largest(rest) < 1.0 / 255) return vec3(0, 0, 0);
  Vec3 mirrored = vec3_sub(vec3_scale(point->normal_world, 2 * n_dot_v), view);
  *margin = fmin(*margin, fmax(0, vec3_dot(mirrored, point->geometric_world)));
  OracleRay reflected = ray_from(tracer, point, hit, mirrored, INFINITY);
  reflected.cull = true;
  return vec3_mul(weight, radiance_along(tracer, &reflected, rest, depth + 1, margin));
}

static Vec3 radiance_along(const Tracer *tracer, const OracleRay *ray, Vec3 throughput, uint32_t depth, double *margin)
{
  OracleHit hit;
  Vec3 view = vec3_unit_or(vec3_neg(ray->direction), vec3(0, 0, 0));
  oracle_closest(&hit, tracer->scene, ray);
  *margin = fmin(*margin, hit.margin);
  if (hit.triangle == ORACLE_MISS) return oracle_environment(&tracer->scene->model->environment, vec3_neg(view));

  OraclePoint point = oracle_surface_at(tracer->scene, ray, &hit);
  OracleModel model = tracer->options->model;
  double n_dot_v = vec3_dot(point.normal_world, view), alpha = point.surface.alpha;
  *margin = fmin(*margin, fmin(point.margin, point.surface.unlit ? INFINITY : fmax(0, n_dot_v)));
  Vec3 sum = oracle_own_light(model, &point.surface, tracer->options->ambient);
  sum = vec3_add(sum, oracle_environment_light(&tracer->scene->model->environment, &tracer->dome, model, &point.surface,
                                               point.normal_world, view));
  sum = vec3_add(sum, lights_at(tracer, &point, &hit, view, margin));
  sum = vec3_add(sum, reflection_at(tracer, &point, &hit, view, vec3_scale(throughput, alpha), depth, margin));
  if (alpha >= 1) return sum;

  OracleRay onward = *ray;
  onward.t_min = hit.t;
  onward.skip = hit.triangle;
  Vec3 behind = radiance_along(tracer, &onward, vec3_scale(throughput, 1 - alpha), depth, margin);
  return vec3_add(vec3_scale(sum, alpha), vec3_scale(behind, 1 - alpha));
}

typedef struct Picture {
  Tracer tracer;
  const Camera *camera;
  double (*pattern)[2];
  OracleImage image;
} Picture;

static void pixel_render(void *context, size_t index)
{
  Picture *picture = context;
  const OracleOptions *options = picture->tracer.options;
  uint32_t x = (uint32_t)(index % options->width), y = (uint32_t)(index / options->width);
  Vec3 sum = {0};
  double margin = ORACLE_MARGIN_MAX;
  for (uint32_t i = 0; i < options->samples; i++) {
    OracleRay ray = oracle_camera_ray(picture->camera, options->width, options->height, x + picture->pattern[i][0],
                                      y + picture->pattern[i][1]);
    sum = vec3_add(sum, radiance_along(&picture->tracer, &ray, vec3(1, 1, 1), 0, &margin));
  }
  double *radiance = picture->image.radiance[index];
  radiance[0] = sum.x / options->samples;
  radiance[1] = sum.y / options->samples;
  radiance[2] = sum.z / options->samples;
  picture->image.margins[index] = margin;
}

OracleImage oracle_image_render(OracleScene *scene, const Camera *camera, const OracleOptions *options)
{
  size_t pixel_count = (size_t)options->width * options->height;
  Picture picture = {.tracer = tracer_make(scene, options), .camera = camera};
  picture.image = (OracleImage){.width = options->width, .height = options->height};
  picture.image.radiance = oracle_array(pixel_count, sizeof *picture.image.radiance);
  picture.image.margins = oracle_array(pixel_count, sizeof *picture.image.margins);
  picture.pattern = oracle_array(options->samples, sizeof *picture.pattern);
  oracle_sample_pattern(picture.pattern, options->samples);
  parallel_for(pixel_count, pixel_render, &picture);
  free(picture.pattern);
  oracle_dome_free(&picture.tracer.dome);
  return picture.image;
}
