// Where lights shine at all, against the shader's own formula at points.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "passes/cube_capture.h"
#include "passes/cube_lit.h"
#include "passes/light_reach.h"
#include "passes/raster_view.h"
#include "support/picture_fixture.h"

enum { LIGHTS = 2000, POINTS = 200, OBJECTS = 3 };

static const Vec3 room_low = {-5, -3, -4}, room_high = {4, 3, 6};

static double between(double low, double high) { return low + (high - low) * rand() / RAND_MAX; }

static Vec3 within(Vec3 low, Vec3 high)
{
  return vec3(between(low.x, high.x), between(low.y, high.y), between(low.z, high.z));
}

static Float3 narrow(Vec3 v) { return (Float3){(float)v.x, (float)v.y, (float)v.z}; }

static Vec3 wide(Float3 v) { return vec3((double)v.x, (double)v.y, (double)v.z); }

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
    cube_cameras(cameras, 64, wide(narrow(eye)), 1e-3f);
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

// Texels of a cube that show places up to 6 m away, or nothing; bit f of *faces: the light shines on one of face f's.
static void cube_fill(float (*texels)[4], uint32_t *faces, const CubeInfo *cube, const LightInfo *light)
{
  CameraInfo cameras[CUBE_FACES];
  const Vec3 eye = wide(cube->center);
  cube_cameras(cameras, cube->size, eye, 1e-3f);
  for (uint32_t i = 0; i < CUBE_TEXELS(cube->size); i++) {
    const uint32_t face = i / (cube->size * cube->size);
    const CameraInfo *camera = &cameras[face];
    const double x = (i % cube->size + 0.5) * (double)camera->scale - (double)camera->center_x;
    const double y = (i / cube->size % cube->size + 0.5) * (double)camera->scale - (double)camera->center_y;
    const Vec3 across = vec3_scale(wide(camera->right), x), down = vec3_scale(wide(camera->down), y);
    const double depth_m = between(0.1, 6);
    texels[i][3] = (float)(rand() % 4 ? 1 / depth_m : 0);
    const Vec3 way = vec3_add(wide(camera->forward), vec3_add(across, down));
    if (texels[i][3] > 0 && is_lit(light, vec3_add(eye, vec3_scale(way, depth_m)))) *faces |= 1u << face;
  }
}

// Faces are those with a texel that shows something lit, but for what is at the very rim of the light.
static void faces_with_something_lit_are_found(void **state)
{
  enum { CUBES = 200, BEFORE = 64 };
  Device *device = picture_device(0);
  float(*texels)[4] = calloc(BEFORE + CUBE_TEXELS(8), sizeof *texels);
  uint32_t wrong = 0, lit_count = 0;
  assert_non_null(texels);
  srand(8);
  for (int i = 0; i < CUBES; i++) {
    const LightInfo lights[2] = {any_light(), {.kind = LIGHT_KIND_DIRECTIONAL}};  // the second one is off
    const CubeInfo cube = {.center = narrow(within(room_low, room_high)), .size = 8, .first_texel = BEFORE};
    CubeLit lit = {0};
    DeviceBuffer buffer = {0};
    uint32_t wanted = 0, found;
    cube_fill(texels + BEFORE, &wanted, &cube, &lights[0]);
    picture_assert_ok(cube_lit_make(&lit, device, lights, 2, &picture_log));
    picture_assert_ok(
        buffer_create(&buffer, device, (BEFORE + CUBE_TEXELS(8)) * sizeof *texels, texels, "texels", &picture_log));
    picture_assert_ok(cube_lit_find(&found, &lit, device, &cube, &buffer, 1e-5f, &picture_log));
    if (wanted & ~found) fail_msg("cube %d: faces %x are lit, %x are found", i, wanted, found);
    wrong += wanted != found;
    lit_count += wanted != 0 && wanted != (1u << CUBE_FACES) - 1;
    buffer_free(&buffer);
    cube_lit_free(&lit);
  }
  if (!(lit_count > CUBES / 10 && wrong <= 2)) fail_msg("%u cubes of %u are wrong", wrong, lit_count);
  free(texels);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_lit_is_within_reach),
                                     cmocka_unit_test(faces_with_something_lit_are_found)};
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
