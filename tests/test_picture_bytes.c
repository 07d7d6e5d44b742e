// The same input gives the same bytes: on every run, and however the work is cut into waves.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_defaults.h"
#include "support/picture_fixture.h"
#include "support/scene_features.h"

enum { ALL_AOVS = 2 * AOV_NAME_REFLECTION - 1 };

// Waves of one tile, of a few tiles with some of the samples, and of the whole picture.
static void waves_check(uint32_t lanes, LightingModel model, EnvironmentLightMethod environment_light)
{
  Scene scene = scene_features();
  Camera camera = scene_features_camera();
  PictureRequest request = picture_request(37, 21, 4);
  scene_set_sky(&scene);
  request.settings.lighting = model;
  request.settings.environment_light = environment_light;
  request.settings.max_roughness = environment_light == ENVIRONMENT_LIGHT_SAMPLED;
  request.aovs = ALL_AOVS;
  request.lanes = lanes;
  Picture whole = picture_render(&scene, &camera, &request);
  picture_assert_signal(&whole, 0.2);
  static const uint32_t sizes[] = {0, 64, 64 * 7, 64 * 15 * 2};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
    request.wave_rays = sizes[i];
    Picture picture = picture_render(&scene, &camera, &request);
    picture_assert_same(&whole, &picture);
    picture_free(&picture);
  }
  picture_free(&whole);
  scene_free(&scene);
}

static void waves_of_any_size_give_the_same_bytes(void **state)
{
  waves_check(0, LIGHTING_PBR, ENVIRONMENT_LIGHT_SH_AO);
  waves_check(8, LIGHTING_PHONG, ENVIRONMENT_LIGHT_NONE);
}

static void waves_of_any_size_give_the_same_bytes_on_one_lane(void **state)
{
  waves_check(1, LIGHTING_PBR, ENVIRONMENT_LIGHT_SH);
}

static void waves_of_any_size_give_the_same_samples(void **state)
{
  waves_check(0, LIGHTING_PBR, ENVIRONMENT_LIGHT_SAMPLED);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(waves_of_any_size_give_the_same_bytes),
      cmocka_unit_test(waves_of_any_size_give_the_same_bytes_on_one_lane),
      cmocka_unit_test(waves_of_any_size_give_the_same_samples),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
