// Planar reflections against those of rays: the same picture, hardly a ray traced.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/mirrors.h"

// No pixel may be off but `most`, and no more than `traced_most` of the rays are traced.
static void scene_check(const char *name, const Scene *scene, const Camera *camera, uint32_t lanes, uint32_t samples,
                        size_t most, double traced_most)
{
  MirrorsShown *rays = mirrors_shown(scene, camera, REFLECTIONS_RAYS, 0, lanes, samples);
  MirrorsShown *planar = mirrors_shown(scene, camera, REFLECTIONS_PLANAR, 0, lanes, samples);
  size_t off = mirrors_off(rays, planar);
  print_message("%s: %zu pixels off, %.0f rays in %u planes, %.4f traced\n", name, off, planar->rays, planar->planes,
                planar->traced / planar->rays);
  assert_true(planar->rays > 1000);
  if (off > most || planar->traced > traced_most * planar->rays)
    fail_msg("%s: %zu pixels off, %g traced", name, off, planar->traced / planar->rays);
  free(rays);
  free(planar);
}

// A room of plain walls with a wall mirror that turns a little from the wall behind it, and things before both.
static Scene room_scene(double turn)
{
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(0.7, 0.6, 0.5), 0, 1));
  int red = scene_add_material(&scene, material_plain(vec3(0.8, 0.1, 0.1), 0, 1));
  int green = scene_add_material(&scene, material_plain(vec3(0.1, 0.7, 0.2), 0, 1));
  scene_add_quad(&scene, white, vec3(-3, -1, 4), vec3(6, 0, 0), vec3(0, 0, -8));    // floor, through the mirror's plane
  scene_add_quad(&scene, white, vec3(-3, -1, -1.5), vec3(6, 0, 0), vec3(0, 4, 0));  // behind the mirror
  scene_add_quad(&scene, green, vec3(3, -1, 4), vec3(-6, 0, 0), vec3(0, 4, 0));     // behind the camera
  scene_add_quad(&scene, red, vec3(-3, -1, 4), vec3(0, 0, -8), vec3(0, 4, 0));
  scene_add_box(&scene, red, vec3(-0.8, -1, 0.4), vec3(-0.4, 0.2, 0.8));
  scene_add_box(&scene, green, vec3(0.9, -1, -2.5), vec3(1.2, 0.6, -1.6));  // behind the wall
  scene_add_sphere(&scene, green, vec3(0.5, -0.5, 0.6), 0.3, 16);
  scene_add_quad(&scene, mirrors_material(&scene, false), vec3(-1, -0.8, -1.2), vec3(2 * cos(turn), 0, 2 * sin(turn)),
                 vec3(0, 1.6, 0));
  scene_add_light(&scene, light_point(vec3(0.8, 2, 2), 12));
  return scene;
}

static void a_wall_mirror_is_that_of_rays(void **state)
{
  static const uint32_t widths[] = {0, 8, 1};
  for (int i = 0; i < 6; i++) {
    Scene scene = room_scene(0.15 * (i % 3 - 1));
    Camera camera = camera_perspective(vec3(0.3 * i - 0.8, 0.3, 2.5), vec3(0, 0, -1), 0.8);
    scene_check("room", &scene, &camera, widths[i % 3], i < 3 ? 1 : 4, 0, 0.3);
    scene_free(&scene);
  }
}

static void a_parallel_view_is_that_of_rays(void **state)
{
  Scene scene = room_scene(0.1);
  Camera camera = camera_orthographic(vec3(0.5, 0.6, 2.5), vec3(0, 0, -1), 1);
  scene_check("parallel", &scene, &camera, 0, 1, 0, 0.12);
  scene_free(&scene);
}

// The sky is there where the mirrored camera sees nothing.
static void a_mirror_outside_shows_the_sky(void **state)
{
  Scene scene = scene_empty();
  mirrors_sky(&scene);
  scene_add_quad(&scene, mirrors_material(&scene, true), vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8));
  scene_add_box(&scene, scene_add_material(&scene, material_plain(vec3(0.6, 0.3, 0.2), 0, 1)), vec3(-0.5, -0.7, -0.5),
                vec3(0.5, 0.9, 0.5));  // through the mirror
  Camera camera = camera_perspective(vec3(1, 2, 4), vec3(0, 0, 0), 0.9);
  scene_check("lake", &scene, &camera, 0, 1, 0, 0.03);
  scene_free(&scene);
}

// A box shows three sides, of which one is drawn; a ball has no plane.
static void what_is_not_in_the_plane_is_traced(void **state)
{
  Scene scene = room_scene(0);
  int mirror = mirrors_material(&scene, false);
  scene_add_box(&scene, mirror, vec3(-0.2, -1, -0.4), vec3(0.3, -0.1, 0));
  scene_add_sphere(&scene, mirror, vec3(0, 0.4, 0), 0.2, 16);
  Camera camera = camera_perspective(vec3(0.4, 0.5, 2.5), vec3(0, 0, -1), 0.8);
  scene_check("box and ball", &scene, &camera, 0, 1, 0, 0.5);
  MirrorsShown *planar = mirrors_shown(&scene, &camera, REFLECTIONS_PLANAR, 0, 0, 1);
  assert_true(planar->reflectors.visible == 3 && planar->reflectors.flat == 2 && planar->planes == 2);
  assert_true(planar->traced > 300);
  free(planar);
  scene_free(&scene);
}

// Tiles of a floor are one plane; more planes than there is room for are traced.
static void planes_are_counted(void **state)
{
  Scene tiles = room_scene(0), fan = room_scene(0);
  int mirror = mirrors_material(&tiles, false), other = mirrors_material(&fan, false);
  for (int i = 0; i < 12; i++) {
    scene_add_quad(&tiles, mirror, vec3(0.2 * i - 1.2, -0.9, 1), vec3(0.18, 0, 0), vec3(0, 0, -1));
    double turn = 0.05 * i;
    scene_add_quad(&fan, other, vec3(0.3 * i - 1.8, -0.95, 0.2), vec3(0.28 * cos(turn), 0.28 * sin(turn), 0),
                   vec3(0, 0, -1));
  }
  Camera camera = camera_perspective(vec3(0, 0.8, 2.5), vec3(0, -0.4, -0.5), 0.8);
  MirrorsShown *few = mirrors_shown(&tiles, &camera, REFLECTIONS_PLANAR, 0, 0, 1);
  assert_true(few->planes == 2 && few->planes_left_out == 0 && few->reflectors.flat > 10);
  free(few);
  scene_check("fan", &fan, &camera, 0, 1, 0, 0.9);
  MirrorsShown *many = mirrors_shown(&fan, &camera, REFLECTIONS_PLANAR, 0, 0, 1);
  assert_true(many->planes == PLANES_MOST && many->planes_left_out == many->reflectors.flat - PLANES_MOST);
  free(many);
  scene_free(&tiles);
  scene_free(&fan);
}

// However many rays are in flight, and for a part of the picture.
static void the_bytes_do_not_hang_on_the_waves(void **state)
{
  Scene scene = room_scene(0.1);
  Camera camera = camera_perspective(vec3(0.3, 0.3, 2.5), vec3(0, 0, -1), 0.8);
  PictureRequest request = mirrors_request(100, REFLECTIONS_PLANAR, 0);
  Picture whole = picture_render(&scene, &camera, &request);
  request.wave_rays = 2048;
  Picture parts = picture_render(&scene, &camera, &request);
  picture_assert_same(&whole, &parts);
  picture_assert_signal(&whole, 0.2);
  picture_free(&whole);
  picture_free(&parts);
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_wall_mirror_is_that_of_rays),
      cmocka_unit_test(a_parallel_view_is_that_of_rays),
      cmocka_unit_test(a_mirror_outside_shows_the_sky),
      cmocka_unit_test(what_is_not_in_the_plane_is_traced),
      cmocka_unit_test(planes_are_counted),
      cmocka_unit_test(the_bytes_do_not_hang_on_the_waves),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
