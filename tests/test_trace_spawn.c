// Rays that start on a surface: they do not hit it, nor what lies in the same plane, and they do hit what touches it.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/picture_fixture.h"
#include "support/trace_fixture.h"

enum { SIZE_PX = 128, ELEVATIONS = 12 };

static const double elevations_deg[ELEVATIONS] = {0.5, 0.7, 1, 1.5, 2.5, 4, 7, 12, 20, 35, 60, 90};
static const uint32_t widths[] = {16, 8, 1};

// A floor of 10 m x 10 m about `middle`: position = middle + x right + y ahead, up along right x ahead. Points of it
// are multiples of 2^-7, so that overlapping triangles share a plane exactly where right and ahead are of few bits.
typedef struct Floor {
  Vec3 middle, right, ahead;
  bool overlaps;  // 300 small triangles lie in the plane as well
} Floor;

static const Floor floors[] = {
    {{0, 0, 0}, {1, 0, 0}, {0, 0, -1}, true},                    // at y = 0, where an offset by rounding is 0
    {{0, 0, 0}, {0, 0, -1}, {1, 0, 0}, true},                    // seen from below: the other side
    {{0, 0, 0}, {1, 0.5, 0}, {0, 0, -1}, true},                  // tilted
    {{0, 0.75, 0}, {1, 0.5, 0}, {0, 0.25, -1}, true},            // tilted twice
    {{8192, 512, -4096}, {1, 0, 0}, {0, 0, -1}, true},           // far from the origin
    {{8192, 512, -4096}, {1, 0.5, 0}, {0, 0, -1}, true},         // and tilted
    {{100, -50, 70}, {0.36, 0.8, 0.48}, {-0.8, 0, 0.6}, false},  // two triangles, turned
    {{100, -50, 70}, {0.8, 0, -0.6}, {0.36, 0.8, 0.48}, false},
};
enum { FLOORS = sizeof floors / sizeof *floors };

static Vec3 floor_point(const Floor *floor, double x, double y)
{
  return vec3_add(floor->middle, vec3_add(vec3_scale(floor->right, x), vec3_scale(floor->ahead, y)));
}

static Vec3 floor_up(const Floor *floor) { return vec3_unit_or(vec3_cross(floor->right, floor->ahead), vec3(0, 1, 0)); }

static Scene floor_scene(const Floor *floor, Material material)
{
  Scene scene = scene_empty();
  Random random = random_make(21);
  int index = scene_add_material(&scene, material);
  scene_add_quad(&scene, index, floor_point(floor, -5, -5), vec3_scale(floor->right, 10), vec3_scale(floor->ahead, 10));
  for (int i = 0; floor->overlaps && i < 300; i++) {
    Vec3 corners[3], up[3] = {floor_up(floor), floor_up(floor), floor_up(floor)};
    double x = random_next(&random) % 1024 / 128.0 - 4, y = random_next(&random) % 1024 / 128.0 - 4;
    for (int corner = 0; corner < 3; corner++)
      corners[corner] =
          floor_point(floor, x + random_next(&random) % 128 / 128.0, y + random_next(&random) % 128 / 128.0);
    scene_add_triangle(&scene, index, corners, up);
  }
  return scene;
}

// From straight above, or along the floor at 3 degrees.
static Camera floor_camera(const Floor *floor, bool grazing)
{
  Vec3 up = floor_up(floor), eye = vec3_add(floor_point(floor, 0.3, -0.2), vec3_scale(up, 9));
  if (grazing) eye = vec3_add(floor_point(floor, -6, -5), vec3_scale(up, 0.4));
  return camera_perspective(eye, floor_point(floor, 0.25, 0.125), grazing ? 0.5 : 1);
}

// Every light adds the same with and without shadow rays, to the bit.
static void assert_nothing_shadowed(const Scene *scene, const Camera *camera, uint32_t lanes)
{
  PictureRequest request = picture_request(SIZE_PX, SIZE_PX, 1);
  request.lanes = lanes;
  Picture shadowed = picture_render(scene, camera, &request);
  request.settings.shadows = SHADOWS_NONE;
  Picture bare = picture_render(scene, camera, &request);
  uint32_t seen = 0, differ = 0;
  for (int i = 0; i < SIZE_PX * SIZE_PX; i++) {
    seen += bare.radiance[i][3] > 0;
    differ += memcmp(shadowed.radiance[i], bare.radiance[i], sizeof bare.radiance[i]) != 0;
  }
  picture_free(&shadowed);
  picture_free(&bare);
  assert_in_range(seen, SIZE_PX * SIZE_PX / 8, SIZE_PX * SIZE_PX);
  assert_int_equal(differ, 0);
}

static void floor_does_not_shadow_itself(void **state)
{
  for (int f = 0; f < FLOORS; f++) {
    const Floor *floor = &floors[f];
    Scene scene = floor_scene(floor, material_plain(vec3(0.5, 0.5, 0.5), 0, 1));
    Vec3 up = floor_up(floor), right = vec3_unit_or(floor->right, up), ahead = vec3_cross(up, right);
    for (int i = 0; i < ELEVATIONS; i++) {
      double elevation_rad = elevations_deg[i] * M_PI / 180, azimuth_rad = 2.4 * i;
      Vec3 along = vec3_add(vec3_scale(right, cos(azimuth_rad)), vec3_scale(ahead, sin(azimuth_rad)));
      Vec3 to_light = vec3_add(vec3_scale(along, cos(elevation_rad)), vec3_scale(up, sin(elevation_rad)));
      scene_add_light(&scene, light_directional(vec3_neg(to_light), 1));
    }
    scene_add_light(&scene, light_point(vec3_add(floor_point(floor, 0.5, 0.25), vec3_scale(up, 0.05)), 1));
    scene_add_light(&scene, light_point(vec3_add(floor_point(floor, -4, 3), vec3_scale(up, 0.1)), 1));
    for (int grazing = 0; grazing < 2; grazing++) {
      Camera camera = floor_camera(floor, grazing);
      assert_nothing_shadowed(&scene, &camera, widths[(f + grazing) % 3]);
    }
    scene_free(&scene);
  }
}

// In phong a mirror of reflectance 1/2 shows half the environment, and half of that again where a ray hits the floor
// that it leaves.
static void floor_does_not_reflect_itself(void **state)
{
  for (int f = 0; f < FLOORS; f++) {
    Scene scene = floor_scene(&floors[f], material_plain(vec3(0.5, 0.5, 0.5), 1, 0));
    Camera camera = floor_camera(&floors[f], f % 2);
    PictureRequest request = picture_request(SIZE_PX, SIZE_PX, 1);
    uint32_t seen = 0;
    scene_set_constant(&scene, 1, 1, 1);
    request.lanes = widths[f % 3];
    request.settings.lighting = LIGHTING_PHONG;
    request.settings.ambient = 0;
    Picture picture = picture_render(&scene, &camera, &request);
    for (int i = 0; i < SIZE_PX * SIZE_PX; i++) {
      if (!(picture.radiance[i][3] > 0)) continue;
      seen++;
      assert_float_equal(picture.radiance[i][0], 0.5 * picture.radiance[i][3], 1e-6);
    }
    assert_in_range(seen, SIZE_PX * SIZE_PX / 8, SIZE_PX * SIZE_PX);
    picture_free(&picture);
    scene_free(&scene);
  }
}

// Rays from a floor at a wall that stands on it, both of about `size_m`, from a distance of 2^-17 of that on: far below
// what a scene epsilon would cost, and about twice the error bound of the hit.
static void wall_is_hit_from_where_it_meets_the_floor(void **state)
{
  enum { COUNT = 20000 };
  static TraceRay rays[COUNT];
  static bool lit[COUNT];
  static TraceHit hits[COUNT];
  static const float sizes_m[] = {0.01f, 1, 10, 1000};
  for (size_t s = 0; s < sizeof sizes_m / sizeof *sizes_m; s++) {
    const float size_m = sizes_m[s];
    TraceFixture fixture;
    Soup soup = {0};
    Random random = random_make(22);
    uint32_t a = soup_vertex(&soup, 0, 0, -size_m), b = soup_vertex(&soup, 0, 0, size_m);
    uint32_t c = soup_vertex(&soup, 0, size_m, size_m), d = soup_vertex(&soup, 0, size_m, -size_m);
    uint32_t e = soup_vertex(&soup, size_m, 0, -size_m), g = soup_vertex(&soup, size_m, 0, size_m);
    soup_triangle(&soup, a, b, c);
    soup_triangle(&soup, a, c, d);
    soup_triangle(&soup, a, b, g);
    soup_triangle(&soup, a, g, e);
    for (int i = 0; i < COUNT; i++) {
      double distance_m = size_m * pow(2, random_between(&random, -17, -2));
      double elevation_rad = random_between(&random, 0.5, 75) * M_PI / 180;
      double azimuth_rad = random_between(&random, -60, 60) * M_PI / 180;
      rays[i] = (TraceRay){{(float)distance_m, 0, size_m * random_between(&random, -0.5, 0.5)},
                           {(float)(-cos(elevation_rad) * cos(azimuth_rad)), (float)sin(elevation_rad),
                            (float)(cos(elevation_rad) * sin(azimuth_rad))},
                           INFINITY};
      // Those that would pass over the wall start nearer to it.
      if (distance_m * tan(elevation_rad) / cos(azimuth_rad) > 0.9 * size_m) rays[i].origin[0] *= 0.2f;
    }
    trace_fixture_make(&fixture, &soup);
    for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
      trace_fixture_closest(hits, &fixture, (TraceKernel)kernel, rays, COUNT, 0);
      trace_fixture_lit(lit, &fixture, (TraceKernel)kernel, rays, COUNT);
      for (int i = 0; i < COUNT; i++) {
        assert_false(lit[i]);
        assert_in_range(hits[i].triangle, 0, 1);
      }
    }
    trace_fixture_free(&fixture);
    soup_free(&soup);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(floor_does_not_shadow_itself),
      cmocka_unit_test(floor_does_not_reflect_itself),
      cmocka_unit_test(wall_is_hit_from_where_it_meets_the_floor),
  };
  return cmocka_run_group_tests_name("trace_spawn", tests, picture_tests_begin, picture_tests_end);
}
