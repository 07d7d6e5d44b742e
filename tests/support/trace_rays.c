#include "support/trace_rays.h"

#include <stdio.h>

static const char *const kind_names[RAY_KINDS] = {"anywhere",      "at a face",  "at an edge",  "at a vertex",
                                                  "axis-parallel", "in a plane", "from a face", "from a vertex",
                                                  "grazing",       "from afar",  "segment",     "inactive"};

typedef struct RayMaker {
  Random random;
  const Soup *soup;
  Vec3 low, high;
} RayMaker;

static double share(RayMaker *maker) { return (random_next(&maker->random) + 0.5) / 4294967296.0; }
static bool coin(RayMaker *maker) { return random_next(&maker->random) >> 31; }
static float zero(RayMaker *maker) { return coin(maker) ? 0.0f : -0.0f; }

static Vec3 direction_any(RayMaker *maker)
{
  double z = 2 * share(maker) - 1, phi = 2 * M_PI * share(maker), r = sqrt(1 - z * z);
  return vec3(r * cos(phi), r * sin(phi), z);
}

static Vec3 point_in_bounds(RayMaker *maker)
{
  Vec3 size = vec3_sub(maker->high, maker->low);
  return vec3_add(maker->low, vec3_mul(size, vec3(share(maker), share(maker), share(maker))));
}

// A point about as far from the bounds as they are wide.
static Vec3 point_outside(RayMaker *maker, double distance)
{
  double size_m = vec3_length(vec3_sub(maker->high, maker->low));
  Vec3 middle = vec3_scale(vec3_add(maker->low, maker->high), 0.5);
  return vec3_add(middle, vec3_scale(direction_any(maker), distance * size_m));
}

typedef enum Place { ON_FACE, ON_EDGE, ON_VERTEX } Place;

static uint32_t any_triangle(RayMaker *maker) { return random_next(&maker->random) % maker->soup->triangle_count; }

static Vec3 point_on(RayMaker *maker, uint32_t triangle, Place place)
{
  const Soup *soup = maker->soup;
  const uint32_t *corners = soup->triangles[triangle];
  uint32_t turn = random_next(&maker->random) % 3;
  double u = place == ON_VERTEX ? 0 : share(maker), v = place == ON_FACE ? share(maker) * (1 - u) : 0;
  Vec3 a = vec3_from_floats(soup->positions[corners[turn]]);
  Vec3 b = vec3_from_floats(soup->positions[corners[(turn + 1) % 3]]);
  Vec3 c = vec3_from_floats(soup->positions[corners[(turn + 2) % 3]]);
  return vec3_add(vec3_add(vec3_scale(a, 1 - u - v), vec3_scale(b, u)), vec3_scale(c, v));
}

static void floats_set(float out[3], Vec3 v)
{
  out[0] = (float)v.x;
  out[1] = (float)v.y;
  out[2] = (float)v.z;
}

static TraceRay ray_make(RayMaker *maker, Vec3 origin, Vec3 direction)
{
  TraceRay ray = {.t_max = INFINITY};
  floats_set(ray.origin, origin);
  floats_set(ray.direction, vec3_scale(vec3_unit_or(direction, vec3(0, 0, 1)), pow(10, 4 * share(maker) - 2)));
  return ray;
}

// At `target`, as nearly as the rounded origin and direction let it.
static TraceRay ray_at(RayMaker *maker, Vec3 origin, Vec3 target)
{
  float rounded[3];
  floats_set(rounded, origin);
  origin = vec3_from_floats(rounded);
  return ray_make(maker, origin, vec3_sub(target, origin));
}

static TraceRay ray_axis_parallel(RayMaker *maker)
{
  uint32_t axis = random_next(&maker->random) % 3;
  TraceRay ray =
      ray_at(maker, point_outside(maker, 1), point_on(maker, any_triangle(maker), coin(maker) ? ON_VERTEX : ON_FACE));
  Vec3 target = point_on(maker, any_triangle(maker), coin(maker) ? ON_VERTEX : ON_FACE);
  float start = ray.origin[axis];
  floats_set(ray.origin, target);
  for (uint32_t i = 0; i < 3; i++) ray.direction[i] = zero(maker);
  ray.origin[axis] = start;
  ray.direction[axis] =
      ray.origin[axis] > target.x * (axis == 0) + target.y * (axis == 1) + target.z * (axis == 2) ? -1 : 1;
  if (share(maker) < 0.1) ray.direction[axis] = -ray.direction[axis];
  return ray;
}

static TraceRay ray_in_plane(RayMaker *maker)
{
  uint32_t axis = random_next(&maker->random) % 3;
  float target[3];
  floats_set(target, point_on(maker, any_triangle(maker), ON_VERTEX));
  Vec3 origin = point_outside(maker, 1);
  if (axis == 0) origin.x = target[0];
  if (axis == 1) origin.y = target[1];
  if (axis == 2) origin.z = target[2];
  TraceRay ray = ray_at(maker, origin, vec3_from_floats(target));
  ray.direction[axis] = zero(maker);
  return ray;
}

static TraceRay ray_grazing(RayMaker *maker)
{
  uint32_t triangle = any_triangle(maker);
  const uint32_t *corners = maker->soup->triangles[triangle];
  Vec3 a = vec3_from_floats(maker->soup->positions[corners[0]]);
  Vec3 to_b = vec3_sub(vec3_from_floats(maker->soup->positions[corners[1]]), a);
  Vec3 to_c = vec3_sub(vec3_from_floats(maker->soup->positions[corners[2]]), a);
  Vec3 normal = vec3_unit_or(vec3_cross(to_b, to_c), vec3(0, 0, 1));
  Vec3 target = point_on(maker, triangle, ON_FACE), from = point_on(maker, triangle, coin(maker) ? ON_EDGE : ON_VERTEX);
  double distance_m = vec3_length(vec3_sub(target, from)) * (1 + 10 * share(maker));
  from = vec3_add(target, vec3_scale(vec3_unit_or(vec3_sub(from, target), to_b), distance_m));
  return ray_at(maker, vec3_add(from, vec3_scale(normal, distance_m * pow(10, -1 - 6 * share(maker)))), target);
}

static TraceRay ray_segment(RayMaker *maker)
{
  static const double ends[] = {1 - 1e-3, 1 - 1e-6, 1, 1 + 1e-6, 1 + 1e-3};
  Vec3 origin = point_outside(maker, share(maker)), target = point_on(maker, any_triangle(maker), ON_FACE);
  TraceRay ray = ray_at(maker, origin, target);
  floats_set(ray.direction, vec3_sub(target, vec3_from_floats(ray.origin)));
  ray.t_max = (float)ends[random_next(&maker->random) % 5];
  return ray;
}

static TraceRay ray_of_kind(RayMaker *maker, RayKind kind)
{
  TraceRay ray = {0};
  switch (kind) {
    case RAY_ANYWHERE: return ray_at(maker, point_outside(maker, share(maker)), point_in_bounds(maker));
    case RAY_AT_FACE: return ray_at(maker, point_outside(maker, 1), point_on(maker, any_triangle(maker), ON_FACE));
    case RAY_AT_EDGE:
      return ray_at(maker, point_outside(maker, share(maker)), point_on(maker, any_triangle(maker), ON_EDGE));
    case RAY_AT_VERTEX:
      return ray_at(maker, point_outside(maker, share(maker)), point_on(maker, any_triangle(maker), ON_VERTEX));
    case RAY_AXIS_PARALLEL: return ray_axis_parallel(maker);
    case RAY_IN_PLANE: return ray_in_plane(maker);
    case RAY_FROM_SURFACE: return ray_make(maker, point_on(maker, any_triangle(maker), ON_FACE), direction_any(maker));
    case RAY_FROM_VERTEX: return ray_make(maker, point_on(maker, any_triangle(maker), ON_VERTEX), direction_any(maker));
    case RAY_GRAZING: return ray_grazing(maker);
    case RAY_FROM_AFAR: return ray_at(maker, point_outside(maker, 1e4), point_on(maker, any_triangle(maker), ON_EDGE));
    case RAY_SEGMENT: return ray_segment(maker);
    case RAY_INACTIVE:
      ray = ray_at(maker, point_outside(maker, 1), point_on(maker, any_triangle(maker), ON_FACE));
      break;
    case RAY_KINDS: break;
  }
  ray.t_max = -1;
  return ray;
}

void trace_rays_make(TraceRay *out, uint32_t count, const Soup *soup, uint64_t seed)
{
  RayMaker maker = {.random = random_make(seed), .soup = soup};
  maker.low = maker.high = vec3_from_floats(soup->positions[0]);
  for (uint32_t i = 1; i < soup->vertex_count; i++) {
    maker.low = vec3_min(maker.low, vec3_from_floats(soup->positions[i]));
    maker.high = vec3_max(maker.high, vec3_from_floats(soup->positions[i]));
  }
  for (uint32_t i = 0; i < count; i++) out[i] = ray_of_kind(&maker, (RayKind)(i % RAY_KINDS));
}

void trace_ray_print(const char *what, const TraceRay *ray, uint32_t i)
{
  const float *o = ray->origin, *d = ray->direction;
  printf("%s: ray %u (%s) from %a %a %a along %a %a %a to %a\n", what, i, kind_names[i % RAY_KINDS], o[0], o[1], o[2],
         d[0], d[1], d[2], ray->t_max);
}
