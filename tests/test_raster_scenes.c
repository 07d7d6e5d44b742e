// Raster of camera visibility against rays on whole scenes: every sample of every scene in scenes/ and of the shared
// models, bit for bit, by each way and at each width.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "scene/scene_defaults.h"
#include "support/gltf_build.h"
#include "support/raster_fixture.h"
#include "support/shared_models.h"

enum { WIDTH = 108, HEIGHT = 68 };

// Checks the views of a scene from each of its cameras, or from the default one, at 1 and 4 samples. Returns how many
// samples hit.
static uint32_t scene_check(const char *path, Scene *scene)
{
  uint32_t count = 0;
  RasterFixture fixture;
  raster_fixture_make(&fixture, scene);
  for (uint32_t index = 0; index == 0 || index < scene->camera_count; index++) {
    Camera camera;
    char name[16];
    snprintf(name, sizeof name, "%u", index);
    raster_assert_ok(
        scene_camera_choose(&camera, scene, scene->camera_count ? name : NULL, (double)WIDTH / HEIGHT, &raster_log));
    for (uint32_t samples = 1; samples <= 4; samples += 3) {
      RasterShot shot = raster_shot(&camera, WIDTH, HEIGHT, samples);
      RasterHits hits = raster_assert_same(&fixture, &shot, path);
      count += raster_hits_count(&hits);
      raster_hits_free(&hits);
    }
  }
  raster_fixture_free(&fixture);
  return count;
}

static void check_shipped(const char *path, uint32_t least_hits)
{
  Scene scene = gltf_read_fine(path);
  uint32_t hits = scene_check(path, &scene);
  if (hits < least_hits) fail_msg("%s: only %u samples hit anything", path, hits);
  scene_free(&scene);
}

static void shipped_scenes_are_seen_as_rays_see_them(void **state)
{
  check_shipped("scenes/room.glb", 5 * WIDTH * HEIGHT);
  check_shipped("scenes/colonnade.glb", 4 * WIDTH * HEIGHT);
  check_shipped("scenes/chrome.glb", 4 * WIDTH * HEIGHT);
  check_shipped("scenes/field.glb", 2 * WIDTH * HEIGHT);
}

static void model_check(void *context, const char *path, Scene *scene)
{
  *(uint64_t *)context += scene_check(path, scene);
}

static void shared_models_are_seen_as_rays_see_them(void **state)
{
  uint64_t hits = 0;
  uint32_t models = shared_models_visit(model_check, &hits);
  printf("%u models, %llu samples hit\n", models, (unsigned long long)hits);
  assert_true(models >= 40);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(shipped_scenes_are_seen_as_rays_see_them),
      cmocka_unit_test(shared_models_are_seen_as_rays_see_them),
  };
  return cmocka_run_group_tests(tests, raster_tests_begin, raster_tests_end);
}
