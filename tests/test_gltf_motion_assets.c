// Animations of the shared models: what moves goes where its keys say.
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/gltf_build.h"

static GltfMotion *asset_open(Scene *scene, const char *name, const char *animation)
{
  char path[512];
  const char *assets = gltf_assets();
  if (!assets) skip();
  snprintf(path, sizeof path, "%s/%s", assets, name);
  return gltf_motion_fine(scene, path, animation);
}

// The inner box turns by half about X from 1.25 to 2.5 s, and goes up and down by 2.52.
static void box_animated_moves(void **state)
{
  Scene scene;
  GltfMotion *motion = asset_open(&scene, "BoxAnimated/BoxAnimated.glb", NULL);
  assert_string_equal(gltf_warnings, "");
  assert_near(gltf_motion_length_s(motion), 3.708329916000366);
  const struct {
    double time_s, height, z_turns;  // turns of the inner box
  } poses[] = {{0, 0, 0},        {0.5, 1.008, 0},     {1.25, 2.52, 0},       {1.5, 2.52, 0.1}, {1.875, 2.52, 0.25},
               {2.5, 2.52, 0.5}, {3, 1.4772358, 0.5}, {3.708329916, 0, 0.5}, {100, 0, 0.5}};
  assert_string_equal(scene.objects[1].name, "inner_box");
  for (size_t i = 0; i < sizeof poses / sizeof *poses; i++) {
    double angle = 2 * M_PI * poses[i].z_turns;
    gltf_pose_fine(motion, &scene, poses[i].time_s);
    assert_vec3(gltf_object_point(&scene, 1, 0, 0, 0), 0, poses[i].height, 0);
    assert_vec3(mat4_direction(&scene.objects[1].world_from_object, vec3(0, 0, 1)), 0, -sin(angle), cos(angle));
    assert_vec3(gltf_object_point(&scene, 0, 1, 2, 3), 1, 2, 3);
  }
  gltf_motion_close(motion);
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(box_animated_moves),
  };
  return cmocka_run_group_tests(tests, gltf_tests_begin, gltf_tests_end);
}
