// Whole pictures by raster are those by rays, bit for bit, at every width of a lane.

#include <math.h>
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

// Of tiles of camera rays that are on one triangle a map is asked at once, those that see nothing are filled; of a
// stream's rays neither is done. Waves of one sample, which set the picture's sums and then add to them.
static void whole_tiles_are_shaded_as_their_pixels(void **state)
{
  Vec3 low, high;
  Scene scene = gltf_read_fine("scenes/room.glb");
  Light *lights = scene.lights;
  const size_t light_count = scene.light_count;
  scene_bounds(&scene, &low, &high);
  Light spot = {.kind = LIGHT_SPOT,
                .color = {1, 1, 1},
                .intensity = 40,
                .range_m = INFINITY,
                .outer_cone_rad = 0.7,
                .position_world = vec3(0.6 * low.x + 0.4 * high.x, 0.1 * low.y + 0.9 * high.y, 0.5 * (low.z + high.z)),
                .direction_world = vec3_unit_or(vec3(0.2, -1, 0.1), vec3(0, -1, 0))};
  scene.lights = &spot;
  scene.light_count = 1;
  scene.environment = (Environment){.kind = ENVIRONMENT_CONSTANT, .constant = {0.2f, 0.3f, 0.4f}, .intensity = 1};
  for (int i = 0; i < (test_on_gpu() ? 2 : 4); i++) {
    Camera camera;
    picture_assert_ok(scene_camera_choose(&camera, &scene, i % 2 ? "fit" : NULL, 16.0 / 9, &picture_log));
    PictureRequest request = picture_request(320, 180, 2);
    request.lanes = all_lanes[i / 2];
    request.wave_rays = 64 * 400;
    request.settings.shadows = SHADOWS_PCF;
    request.settings.reflections = REFLECTIONS_NONE;
    check(&scene, &camera, request);
  }
  scene.lights = lights;
  scene.light_count = light_count;
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_feature_is_shaded_alike),
      cmocka_unit_test(shipped_scenes_are_shaded_alike),
      cmocka_unit_test(shading_fills_pictures_as_the_film_does),
      cmocka_unit_test(whole_tiles_are_shaded_as_their_pixels),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
