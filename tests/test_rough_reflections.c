// What rough surfaces reflect by prefiltered cube maps, against samples of their lobes and closed forms.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/mirrors.h"

enum { SIDE = 64 };

// A rough floor and a rough ball in a room of glowing tiles, with glowing things beside them.
static Scene rough_room(double roughness)
{
  Scene scene = mirrors_room();
  int metal = scene_add_material(&scene, material_plain(vec3(0.9, 0.9, 0.9), 1, roughness));
  scene_add_quad(&scene, metal, vec3(-1.85, -1, -2.25), vec3(0, 0, 3.9), vec3(4.2, 0, 0));
  scene_add_sphere(&scene, metal, vec3(-0.5, -0.3, -0.6), 0.5, 48);
  int red = scene_add_material(&scene, material_glowing(vec3(2, 0.2, 0.1)));
  int blue = scene_add_material(&scene, material_glowing(vec3(0.1, 0.3, 2)));
  scene_add_box(&scene, red, vec3(0.5, -1, -1.4), vec3(0.9, -0.2, -1));
  scene_add_sphere(&scene, blue, vec3(0.4, -0.7, 0), 0.3, 24);
  return scene;
}

static Camera room_camera(void) { return camera_perspective(vec3(0.3, 0.3, 1.5), vec3(0, -0.55, -0.8), 0.9); }

static PictureRequest rough_request(ReflectionMethod method, uint32_t samples)
{
  PictureRequest request = mirrors_request(SIDE, method, 0);
  request.settings.samples = samples;
  request.settings.max_roughness = method == REFLECTIONS_ENVIRONMENT ? 0 : 1;
  request.settings.max_depth = 1;
  return request;
}

static Picture rough_picture(const Scene *scene, ReflectionMethod method, uint32_t samples)
{
  Camera camera = room_camera();
  PictureRequest request = rough_request(method, samples);
  return picture_render(scene, &camera, &request);
}

// Is it one of those that show the ball's middle?
static bool is_ball(size_t i)
{
  const double x = (double)(i % SIDE) / SIDE - 0.25, y = (double)(i / SIDE) / SIDE - 0.4;
  return x * x + y * y < 0.15 * 0.15;
}

static double mean_difference(const Picture *a, const Picture *b, bool of_ball)
{
  double sum = 0, count = 0;
  for (size_t i = 0; i < SIDE * SIDE; i++) {
    if (of_ball && !is_ball(i)) continue;
    sum += mirrors_difference(a, b, i);
    count++;
  }
  return sum / count;
}

// Mean differences from many samples: floor and ball, and the ball alone, of which little is hidden from its centre.
static void rough_surfaces_come_near_to_rays_by_cubes(void **state)
{
  static const double roughnesses[] = {0.1, 0.3, 0.6, 0.9};
  for (int r = 0; r < 4; r++) {
    Scene scene = rough_room(roughnesses[r]);
    Picture rays = rough_picture(&scene, REFLECTIONS_RAYS, 1024);
    double off[4], ball[4];
    for (int rung = 0; rung < 4; rung++) {
      Picture map = rough_picture(&scene, REFLECTIONS_ENVIRONMENT + rung, rung ? 16 : 1);
      off[rung] = mean_difference(&rays, &map, false);
      ball[rung] = mean_difference(&rays, &map, true);
      picture_free(&map);
    }
    print_message(
        "roughness %g: environment %.3f, cube %.3f, box %.3f, impostor %.3f; of the ball %.3f %.3f %.3f %.3f\n",
        roughnesses[r], off[0], off[1], off[2], off[3], ball[0], ball[1], ball[2], ball[3]);
    assert_true(off[1] < 0.6 * off[0] && off[2] < 0.45 * off[0] && off[3] < 0.45 * off[0]);
    assert_true(ball[1] < 0.3 * ball[0] && ball[2] < 0.2 * ball[0] && ball[3] < 0.2 * ball[0]);
    picture_free(&rays);
    scene_free(&scene);
  }
}

// In a uniform surrounding a rough metal comes out as by the harmonics' light, whatever the rung and the environment's
// light: the same albedo times the same radiance.
static void a_furnace_stays_as_it_is(void **state)
{
  static const EnvironmentLightMethod lights[] = {ENVIRONMENT_LIGHT_SH, ENVIRONMENT_LIGHT_AMBIENT,
                                                  ENVIRONMENT_LIGHT_SAMPLED};
  static const uint32_t widths[] = {0, 8, 1};
  Camera camera = room_camera();
  for (int i = 0; i < 3; i++) {
    Scene scene = scene_empty();
    scene_set_constant(&scene, 0.7, 0.7, 0.7);
    scene_add_sphere(&scene, scene_add_material(&scene, material_plain(vec3(0.9, 0.6, 0.3), 1, 0.2 + 0.3 * i)),
                     vec3(0, -0.55, -0.8), 0.8, 32);
    PictureRequest sh = rough_request(REFLECTIONS_ENVIRONMENT, 1);
    sh.lanes = widths[i];
    sh.settings.max_roughness = 0;
    Picture wanted = picture_render(&scene, &camera, &sh);
    for (ReflectionMethod method = REFLECTIONS_CUBE; method < REFLECTIONS_HYBRID; method++) {
      if (method == REFLECTIONS_PLANAR) continue;
      PictureRequest request = rough_request(method, 1);
      request.lanes = widths[i];
      request.settings.environment_light = lights[(i + (int)method) % 3];
      Picture got = picture_render(&scene, &camera, &request);
      for (size_t k = 0; k < SIDE * SIDE; k++) {
        double off = mirrors_difference(&wanted, &got, k);
        if (!(off < 1e-5)) fail_msg("%s, pixel %zu: %g off", reflections_name(method), k, off);
      }
      picture_free(&got);
    }
    picture_free(&wanted);
    scene_free(&scene);
  }
}

// A bright environment behind black walls: what the cube shows takes its place, and is not added to it.
static void walls_hide_the_environment(void **state)
{
  Camera camera = room_camera();
  for (uint32_t samples = 1; samples <= 16; samples += 15) {
    Scene scene = rough_room(0.4);
    scene_set_constant(&scene, 5, 5, 5);
    for (size_t i = 0; i < scene.material_count; i++)
      for (int c = 0; c < 3; c++) scene.materials[i].emission[c] = 0;
    for (size_t i = 0; i < scene.material_count; i++) scene.materials[i].unlit = scene.materials[i].roughness >= 1;
    PictureRequest open = rough_request(REFLECTIONS_ENVIRONMENT, samples),
                   closed = rough_request(REFLECTIONS_CUBE, samples);
    open.settings.max_roughness = 0;
    closed.settings.environment_light = samples > 1 ? ENVIRONMENT_LIGHT_SAMPLED : ENVIRONMENT_LIGHT_SH;
    Picture lit = picture_render(&scene, &camera, &open), dark = picture_render(&scene, &camera, &closed);
    const size_t ball = (size_t)(SIDE * 0.4) * SIDE + (size_t)(SIDE * 0.25);
    assert_true((double)lit.radiance[ball][0] > 3);
    if (!((double)dark.radiance[ball][0] < 0.15)) fail_msg("%u samples: %g", samples, (double)dark.radiance[ball][0]);
    picture_free(&lit);
    picture_free(&dark);
    scene_free(&scene);
  }
}

// What a mirror shows does not change by what rough surfaces beside it ask.
static void mirrors_show_what_they_showed(void **state)
{
  Scene scene = rough_room(0.3);
  scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0.9, 0.1, -0.4), 0.35, 32);
  Camera camera = room_camera();
  for (ReflectionMethod method = REFLECTIONS_CUBE; method < REFLECTIONS_HYBRID; method++) {
    PictureRequest before = rough_request(method, 1), after = before;
    before.settings.max_roughness = 0;
    before.aovs = after.aovs = AOV_NAME_OBJECT;
    Picture a = picture_render(&scene, &camera, &before), b = picture_render(&scene, &camera, &after);
    const uint32_t *objects = picture_integers(&a, "object.id");
    size_t seen = 0, changed = 0;
    for (size_t i = 0; i < SIDE * SIDE; i++) {
      const double off = mirrors_difference(&a, &b, i);
      const bool is_mirror = objects[i] + 1 == scene.object_count;
      seen += is_mirror;
      changed += !is_mirror && off > 0.05;
      if (is_mirror && off > 0) fail_msg("%s, pixel %zu: %g off", reflections_name(method), i, off);
    }
    assert_true(seen > 100 && (changed > 500 || method == REFLECTIONS_PLANAR));
    picture_free(&a);
    picture_free(&b);
  }
  scene_free(&scene);
}

// With lists, rough surfaces see the impostor, of which nothing is left out.
static void lists_leave_rough_surfaces_to_whole_cubes(void **state)
{
  Scene scene = rough_room(0.3);
  Picture whole = rough_picture(&scene, REFLECTIONS_IMPOSTOR, 1), mixed = rough_picture(&scene, REFLECTIONS_MIXED, 1);
  picture_assert_same(&whole, &mixed);
  scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0.9, 0.1, -0.4), 0.35, 32);
  Picture both = rough_picture(&scene, REFLECTIONS_MIXED, 1);
  const size_t ball = (size_t)(SIDE * 0.4) * SIDE + (size_t)(SIDE * 0.25);
  assert_true(mirrors_difference(&whole, &both, ball) < 0.1);
  picture_free(&whole);
  picture_free(&mixed);
  picture_free(&both);
  scene_free(&scene);
}

// Cubes are as fine as lobes are narrow; where there is no room, rough surfaces show the environment.
static void rough_reflectors_share_the_room(void **state)
{
  Scene scene = rough_room(0.3), smooth = rough_room(0.1);
  Camera camera = room_camera();
  PictureRequest request = rough_request(REFLECTIONS_CUBE, 1);
  request.settings.width = request.settings.height = 512;
  ReflectorSummary summary = mirrors_summary(&scene, &camera, &request.settings);
  assert_true(summary.visible == 2 && summary.rough == 2 && summary.left_out == 0);
  assert_true(summary.least_px == 64 && summary.greatest_px == 64);
  summary = mirrors_summary(&smooth, &camera, &request.settings);
  assert_true(summary.greatest_px == 512);
  request.settings.cubes.max_bytes = 1000;
  summary = mirrors_summary(&scene, &camera, &request.settings);
  assert_true(summary.left_out == 2 && summary.bytes == 0);
  scene_set_constant(&scene, 0.5, 0.5, 0.5);
  request = rough_request(REFLECTIONS_CUBE, 1);
  request.settings.cubes.max_bytes = 1000;
  Picture out = picture_render(&scene, &camera, &request), sky = rough_picture(&scene, REFLECTIONS_ENVIRONMENT, 1);
  for (size_t i = 0; i < SIDE * SIDE; i++) assert_true(mirrors_difference(&out, &sky, i) < 1e-5);
  picture_free(&out);
  picture_free(&sky);
  scene_free(&scene);
  scene_free(&smooth);
}

static void pictures_are_the_same_in_waves(void **state)
{
  static const ReflectionMethod methods[] = {REFLECTIONS_BOX, REFLECTIONS_IMPOSTOR, REFLECTIONS_SNAPSHOT};
  Scene scene = rough_room(0.3);
  scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0.9, 0.1, -0.4), 0.35, 32);
  Camera camera = room_camera();
  for (int i = 0; i < 3; i++) {
    PictureRequest request = rough_request(methods[i], 1);
    request.settings.max_depth = 4;
    mirrors_assert_same_in_waves(&scene, &camera, &request);
  }
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rough_surfaces_come_near_to_rays_by_cubes),
      cmocka_unit_test(a_furnace_stays_as_it_is),
      cmocka_unit_test(walls_hide_the_environment),
      cmocka_unit_test(mirrors_show_what_they_showed),
      cmocka_unit_test(lists_leave_rough_surfaces_to_whole_cubes),
      cmocka_unit_test(rough_reflectors_share_the_room),
      cmocka_unit_test(pictures_are_the_same_in_waves),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
