// Cube maps of mirrors that the camera sees in mirrors.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "shared/cube.h"
#include "support/mirrors.h"

// The camera looks at a mirror, and in that at a ball behind its back; another ball is in a box.
static Scene back_scene(void)
{
  Scene scene = mirrors_room();
  const int mirror = mirrors_material(&scene, false);
  scene_add_quad(&scene, mirror, vec3(-1, -0.8, -1.5), vec3(2, 0, 0), vec3(0, 1.6, 0));
  scene_add_sphere(&scene, mirror, vec3(0.1, 0.1, 1.3), 0.25, 16);
  scene_add_sphere(&scene, mirror, vec3(2, 1.2, 1.4), 0.1, 8);
  const int wall = scene_add_material(&scene, material_glowing(vec3(0.2, 0.2, 0.2)));
  scene_add_box(&scene, wall, vec3(1.8, 1, 1.2), vec3(2.2, 1.4, 1.6));
  return scene;
}

// Mirrors have a cube for what the camera sees of them in mirrors, where that is by cubes, and none where nobody looks.
static void a_mirror_in_a_mirror_has_a_cube(void **state)
{
  static const struct {
    ReflectionMethod first, deep;
    uint32_t deep_cubes, cubes;
  } cases[] = {{REFLECTIONS_IMPOSTOR, REFLECTIONS_LIKE_FIRST, 1, 2},
               {REFLECTIONS_RAYS, REFLECTIONS_BOX, 1, 1},
               {REFLECTIONS_CUBE, REFLECTIONS_RAYS, 0, 1},
               {REFLECTIONS_CUBE, REFLECTIONS_ENVIRONMENT, 0, 1}};
  Scene scene = back_scene();
  Camera camera = camera_perspective(vec3(-0.3, 0, 1), vec3(0, 0, -1.5), 1);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    RenderSettings settings = mirrors_request(128, cases[i].first, 64).settings;
    settings.deep_reflections = cases[i].deep;
    const uint64_t texel_bytes = cases[i].first == REFLECTIONS_IMPOSTOR ? 20 : 16;
    const ReflectorSummary seen = mirrors_summary(&scene, &camera, &settings);
    const bool looked_for = cases[i].deep_cubes > 0;
    assert_int_equal(seen.visible, 1);
    assert_int_equal(seen.deep_cubes, cases[i].deep_cubes);
    assert_int_equal(seen.bytes, cases[i].cubes * CUBE_TEXELS(64) * texel_bytes);
    if (looked_for) assert_true(seen.within == 1 && seen.within_alone == 1 && seen.unseen == 1);
  }
  RenderSettings once = mirrors_request(128, REFLECTIONS_IMPOSTOR, 0).settings;
  once.max_depth = 1;
  assert_int_equal(mirrors_summary(&scene, &camera, &once).deep_cubes, 0);
  scene_free(&scene);
}

// Mirrors in mirrors' cubes show what is about them, not the black sky beyond.
static void mirrors_in_cubes_show_their_cubes(void **state)
{
  Scene scene = back_scene();
  Camera camera = camera_perspective(vec3(-0.3, 0, 1), vec3(0, 0, -1.5), 1);
  PictureRequest by_rays = mirrors_request(96, REFLECTIONS_RAYS, 0);
  PictureRequest deep = mirrors_request(96, REFLECTIONS_IMPOSTOR, 128), open = deep;
  open.settings.deep_reflections = REFLECTIONS_ENVIRONMENT;
  Picture rays = picture_render(&scene, &camera, &by_rays), by_deep = picture_render(&scene, &camera, &deep),
          by_open = picture_render(&scene, &camera, &open);
  double off_deep = 0, off_open = 0;
  for (size_t i = 0; i < 96 * 96; i++) {
    off_deep += mirrors_difference(&rays, &by_deep, i);
    off_open += mirrors_difference(&rays, &by_open, i);
  }
  if (!(off_open > 100 && off_deep < 0.8 * off_open)) fail_msg("%g off, %g without", off_deep, off_open);
  picture_free(&rays);
  picture_free(&by_deep);
  picture_free(&by_open);
  scene_free(&scene);
}

// However many rays are in flight, and on every run: one cube is drawn of another.
static void the_bytes_do_not_hang_on_the_waves(void **state)
{
  Scene scene = back_scene();
  Camera camera = camera_perspective(vec3(-0.3, 0, 1), vec3(0, 0, -1.5), 1);
  PictureRequest request = mirrors_request(64, REFLECTIONS_IMPOSTOR, 64);
  mirrors_assert_same_in_waves(&scene, &camera, &request);
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_mirror_in_a_mirror_has_a_cube),
      cmocka_unit_test(mirrors_in_cubes_show_their_cubes),
      cmocka_unit_test(the_bytes_do_not_hang_on_the_waves),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
