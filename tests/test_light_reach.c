// Where lights shine at all, against the shader's own formula at points.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "passes/cube_capture.h"
#include "passes/light_reach.h"
#include "passes/raster_view.h"

enum { LIGHTS = 2000, POINTS = 200, OBJECTS = 3 };

static const Vec3 room_low = {-5, -3, -4}, room_high = {4, 3, 6};

static double between(double low, double high) { return low + (high - low) * rand() / RAND_MAX; }

static Vec3 within(Vec3 low, Vec3 high)
{
  return vec3(between(low.x, high.x), between(low.y, high.y), between(low.z, high.z));
}

static Float3 narrow(Vec3 v) { return (Float3){(float)v.x, (float)v.y, (float)v.z}; }

// Narrow and wide, near and far; some are off, some of a length that they do not reach.
static LightInfo any_light(void)
{
  static const double cones[] = {0.02, 0.1, 0.5, 1, 1.5};
  const double outer = cones[rand() % 5], inner = outer * between(0, 1);
  const double scale = 1 / fmax(1e-3, cos(inner) - cos(outer));
  const Vec3 along = vec3_unit_or(within(vec3(-1, -1, -1), vec3(1, 1, 1)), vec3(0, 0, 1));
  return (LightInfo){.kind = rand() % 8   ? LIGHT_KIND_SPOT
                             : rand() % 4 ? LIGHT_KIND_POINT
                                          : LIGHT_KIND_DIRECTIONAL,
                     .position = narrow(within(vec3(-8, -6, -7), vec3(7, 6, 9))),
                     .direction = narrow(along),
                     .radiant = {rand() % 10 ? 1 : 0, 0, 0},
                     .range_m = rand() % 2 ? INFINITY : (float)between(0.1, 6),
                     .spot_scale = (float)scale,
                     .spot_offset = (float)(-cos(outer) * scale)};
}

// As cl/shade/shade.cl has it.
static bool is_lit(const LightInfo *light, Vec3 at)
{
  const Float3 p = light->position, d = light->direction;
  const float x = p.x - (float)at.x, y = p.y - (float)at.y, z = p.z - (float)at.z, squared = x * x + y * y + z * z;
  const float ratio = squared / light->range_m / light->range_m, length = sqrtf(squared);
  if (!(light->radiant.x > 0)) return false;
  if (light->kind == LIGHT_KIND_DIRECTIONAL) return true;
  if (!(1 - ratio * ratio > 0)) return false;
  const float cosine = -(d.x * (x / length) + d.y * (y / length) + d.z * (z / length));
  return light->kind == LIGHT_KIND_POINT || cosine * light->spot_scale + light->spot_offset > 0;
}

static int face_of(Vec3 v)
{
  const double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
  if (x >= y && x >= z) return v.x < 0;
  return y >= z ? 2 + (v.y < 0) : 4 + (v.z < 0);
}

// No point is lit on a face of which it is said that the light does not reach it, and most lights leave most faces out.
static void what_is_lit_is_within_reach(void **state)
{
  uint32_t seen = 0, lit_count = 0;
  srand(7);
  for (int l = 0; l < LIGHTS; l++) {
    const LightInfo light = any_light();
    const LightReach reach = light_reach(&light, room_low, room_high);
    const Vec3 eye = within(room_low, room_high);
    ObjectFacts objects[OBJECTS];
    CameraInfo cameras[CUBE_FACES];
    bool reached[CUBE_FACES];
    for (int o = 0; o < OBJECTS; o++) {
      const Vec3 a = within(room_low, room_high), b = within(room_low, room_high);
      objects[o] = (ObjectFacts){.low = vec3_min(a, b), .high = vec3_max(a, b), .drawn = true};
    }
    cube_cameras(cameras, 64, vec3((double)(float)eye.x, (double)(float)eye.y, (double)(float)eye.z), 1e-3f);
    for (int face = 0; face < CUBE_FACES; face++) {
      const RasterView view = raster_view_of_camera(&cameras[face]);
      reached[face] = light_reach_seen(&reach, &view, objects, OBJECTS);
      seen += reached[face];
    }
    for (int i = 0; i < POINTS; i++) {
      const Vec3 at = within(objects[i % OBJECTS].low, objects[i % OBJECTS].high);
      if (!is_lit(&light, at)) continue;
      lit_count++;
      if (!reached[face_of(vec3_sub(at, eye))]) fail_msg("light %d: a point is lit on a face that is not reached", l);
    }
  }
  assert_true(lit_count > LIGHTS * POINTS / 20);
  assert_in_range(seen, 1, LIGHTS * CUBE_FACES / 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_lit_is_within_reach)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
