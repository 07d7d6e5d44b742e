// Whole pictures by raster are those by rays, bit for bit, at every width of a lane.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "scene/scene_defaults.h"
#include "support/gltf_build.h"
#include "support/picture_fixture.h"
#include "support/scene_features.h"
#include "support/test_device.h"

enum { ALL_AOVS = 2 * AOV_NAME_REFLECTION - 1 };

static void check(const Scene *scene, const Camera *camera, PictureRequest request)
{
  request.settings.primary = PRIMARY_RAYS;
  Picture rays = picture_render(scene, camera, &request);
  request.settings.primary = PRIMARY_RASTER;
  Picture raster = picture_render(scene, camera, &request);
  picture_assert_signal(&rays, 0.1);
  picture_assert_same(&rays, &raster);
  picture_free(&rays);
  picture_free(&raster);
}

static const uint32_t all_lanes[] = {16, 8, 1};

// Every kind of material, alpha and light, all AOVs; waves that end within a row of bins.
static void every_feature_is_shaded_alike(void **state)
{
  Scene scene = scene_features();
  Camera camera = scene_features_camera();
  for (int i = 0; i < (test_on_gpu() ? 1 : 3); i++) {
    PictureRequest request = picture_request(101, 77, 4);
    request.lanes = all_lanes[i];
    request.aovs = ALL_AOVS;
    check(&scene, &camera, request);
    request.wave_rays = 2048;
    request.settings.lighting = LIGHTING_PHONG;
    check(&scene, &camera, request);
  }
  scene_free(&scene);
}

static void shipped_scenes_are_shaded_alike(void **state)
{
  static const char *const paths[] = {"scenes/room.glb", "scenes/colonnade.glb", "scenes/chrome.glb"};
  for (int i = 0; i < 3; i++) {
    Scene scene = gltf_read_fine(paths[i]);
    Camera camera;
    picture_assert_ok(scene_camera_choose(&camera, &scene, NULL, 16.0 / 9, &picture_log));
    check(&scene, &camera, picture_request(320, 180, 1));
    scene_free(&scene);
  }
}

// Where no ray is sent shading sets the picture's sums in the first waves and adds to them in those of later samples;
// by rays the film does, and where few rays are (hybrid). Waves of seven tiles, of which those at the edges are cut.
static void shading_fills_pictures_as_the_film_does(void **state)
{
  static const ShadowMethod methods[] = {SHADOWS_PCF, SHADOWS_HYBRID, SHADOWS_NONE, SHADOWS_RAYS};
  Camera camera;
  Scene scene = gltf_read_fine("scenes/room.glb");
  picture_assert_ok(scene_camera_choose(&camera, &scene, NULL, 101.0 / 77, &picture_log));
  for (int i = 0; i < (test_on_gpu() ? 1 : 3); i++) {
    PictureRequest request = picture_request(101, 77, 2);
    request.lanes = all_lanes[i];
    request.wave_rays = 64 * 7;
    request.settings.reflections = REFLECTIONS_NONE;
    for (int k = 0; k < (i == 0 ? 4 : 1); k++) {
      request.settings.shadows = methods[k];
      check(&scene, &camera, request);
    }
  }
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_feature_is_shaded_alike),
      cmocka_unit_test(shipped_scenes_are_shaded_alike),
      cmocka_unit_test(shading_fills_pictures_as_the_film_does),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
