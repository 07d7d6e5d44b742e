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
  request.settings.max_roughness = 1;
  request.settings.max_depth = 1;
  return request;
}

static Picture rough_picture(const Scene *scene, ReflectionMethod method, uint32_t samples)
{
  Camera camera = room_camera();
  PictureRequest request = rough_request(method, samples);
  return picture_render(scene, &camera, &request);
}

static double mean_difference(const Picture *a, const Picture *b)
{
  double sum = 0;
  for (size_t i = 0; i < SIDE * SIDE; i++) sum += mirrors_difference(a, b, i);
  return sum / (SIDE * SIDE);
}

static void rough_surfaces_come_near_to_rays_by_cubes(void **state)
{
  static const double roughnesses[] = {0.1, 0.3, 0.6, 0.9};
  for (int r = 0; r < 4; r++) {
    Scene scene = rough_room(roughnesses[r]);
    Picture rays = rough_picture(&scene, REFLECTIONS_RAYS, 1024);
    for (ReflectionMethod m = REFLECTIONS_ENVIRONMENT; m <= REFLECTIONS_IMPOSTOR; m++) {
      PictureRequest request = rough_request(m, 16);
      if (m == REFLECTIONS_ENVIRONMENT) request.settings.max_roughness = 0;
      Camera camera = room_camera();
      Picture map = picture_render(&scene, &camera, &request);
      print_message("%g %s: %.4f\n", roughnesses[r], reflections_name(m), mean_difference(&rays, &map));
      picture_free(&map);
    }
    picture_free(&rays);
    scene_free(&scene);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rough_surfaces_come_near_to_rays_by_cubes),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
