// Animations of the shared models: each vertex goes where a second reading of the file, in the test, takes it.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/gltf_build.h"
#include "support/gltf_raw.h"
#include "support/scene_same.h"

static const char *asset_path(const char *name)
{
  static char path[512];
  const char *assets = gltf_assets();
  if (!assets) skip();
  snprintf(path, sizeof path, "%s/%s", assets, name);
  return path;
}

// The inner box turns by half about X from 1.25 to 2.5 s, and goes up and down by 2.52.
static void box_animated_moves(void **state)
{
  Scene scene;
  GltfMotion *motion = gltf_motion_fine(&scene, asset_path("BoxAnimated/BoxAnimated.glb"), NULL);
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
  gltf_motion_end(motion, &scene);
}

// The largest distance of a vertex of an object's first primitive from where the second reading has it.
static double farthest_off(const GltfRaw *raw, const Scene *scene, uint32_t object, size_t animation, double time_s,
                           size_t node)
{
  const Primitive *primitive = &scene->meshes[scene->objects[object].mesh].primitives[0];
  GltfRawPose *pose = gltf_raw_pose(raw, animation, time_s, node);
  double farthest = 0;
  for (uint32_t i = 0; i < primitive->vertex_count; i++) {
    double expected[3];
    gltf_raw_vertex(expected, pose, i);
    const float *p = primitive->positions[i];
    Vec3 got = gltf_object_point(scene, object, (double)p[0], (double)p[1], (double)p[2]);
    Vec3 off = vec3_sub(got, vec3(expected[0], expected[1], expected[2]));
    farthest = fmax(farthest, vec3_length(off));
  }
  assert_int_equal(primitive->vertex_count, gltf_raw_vertex_count(pose));
  gltf_raw_pose_free(pose);
  return farthest;
}

// Posed at each of the times, an object of a file is nowhere farther off than `most`, and somewhere it has moved by
// more than a hundred times that from one time to the next.
static void check_file(const char *name, const char *choice, size_t animation, const double *times, int count,
                       size_t node, double most)
{
  Scene scene;
  const char *path = asset_path(name);
  GltfRaw raw = gltf_raw_open(path);
  GltfMotion *motion = gltf_motion_fine(&scene, path, choice);
  assert_string_equal(gltf_warnings, "");
  for (int i = 0; i < count; i++) {
    double before = i ? farthest_off(&raw, &scene, 0, animation, times[i], node) : INFINITY;
    gltf_pose_fine(motion, &scene, times[i]);
    double off = farthest_off(&raw, &scene, 0, animation, times[i], node);
    if (off > most || before < 100 * most) fail_msg("%s at %g s: off by %g, before by %g", name, times[i], off, before);
  }
  gltf_motion_end(motion, &scene);
  gltf_raw_close(&raw);
}

// The fox is 155 units long; between keys and on them, before the first and after the last.
static void the_fox_surveys_walks_and_runs(void **state)
{
  const double survey[] = {0.5, 1.7, 0.041666, 3.4}, walk[] = {0.3, 0.1, 0.7083333134651184},
               run[] = {0.5, 0.9, 0.2, 9};
  check_file("Fox/Fox.glb", "Survey", 0, survey, 4, 1, 1e-4);
  check_file("Fox/Fox.glb", "Walk", 1, walk, 3, 1, 1e-4);
  check_file("Fox/Fox.glb", "2", 2, run, 4, 1, 1e-4);
}

static void rigged_models_bend(void **state)
{
  const double simple[] = {0.5, 1, 1.8}, figure[] = {0, 0.625, 1.25};
  check_file("RiggedSimple/RiggedSimple.glb", NULL, 0, simple, 3, 2, 2e-6);
  check_file("RiggedFigure/RiggedFigure.glb", NULL, 0, figure, 3, 1, 2e-6);
}

// At keys and between them; quantised to bytes and shorts as well.
static void the_cube_morphs(void **state)
{
  const double times[] = {0.5, 1.5, 2.51, 3.9};
  check_file("AnimatedMorphCube/AnimatedMorphCube.glb", "Square", 0, times, 4, 0, 5e-7);
  check_file("AnimatedMorphCubeQuantized/AnimatedMorphCube.gltf", "Square", 0, times, 4, 0, 5e-7);
}

// Nine cubes, each moved by an animation of its own: at each key, the values that the file has.
static void each_interpolation_meets_its_keys(void **state)
{
  const char *path = asset_path("InterpolationTest/InterpolationTest.glb");
  GltfRaw raw = gltf_raw_open(path);
  const json_t *animations = json_object_get(raw.json, "animations");
  assert_int_equal(json_array_size(animations), 9);
  for (size_t a = 0; a < 9; a++) {
    Scene scene;
    const json_t *from = json_array_get(animations, a), *sampler = json_array_get(json_object_get(from, "samplers"), 0);
    const json_t *target = json_object_get(json_array_get(json_object_get(from, "channels"), 0), "target");
    const char *name = json_string_value(json_object_get(from, "name"));
    size_t keys, values, one, width;
    double *times = gltf_raw_numbers(&raw, (size_t)json_integer_value(json_object_get(sampler, "input")), &keys, &one);
    double *numbers =
        gltf_raw_numbers(&raw, (size_t)json_integer_value(json_object_get(sampler, "output")), &values, &width);
    const json_t *node =
        json_array_get(json_object_get(raw.json, "nodes"), (size_t)json_integer_value(json_object_get(target, "node")));
    GltfMotion *motion = gltf_motion_fine(&scene, path, name);
    uint32_t object = 0;
    while (strcmp(scene.objects[object].name, json_string_value(json_object_get(node, "name"))) != 0) object++;
    for (size_t k = 0; k < keys; k++) {
      const double *value = numbers + width * (values == 3 * keys ? 3 * k + 1 : k);
      const Mat4 *world = &scene.objects[object].world_from_object;
      gltf_pose_fine(motion, &scene, times[k]);
      if (strstr(name, "Translation")) {
        assert_vec3(mat4_point(world, vec3(0, 0, 0)), value[0], value[1], value[2]);
      } else if (strstr(name, "Scale")) {
        assert_vec3(vec3(world->m[0], world->m[5], world->m[10]), value[0], value[1], value[2]);
      } else {
        double scale = vec3_length(mat4_direction(world, vec3(1, 0, 0)));
        Mat4 turned = mat4_from_trs(vec3(0, 0, 0), value, vec3(scale, scale, scale));
        for (int c = 0; c < 12; c++) assert_near(world->m[c], turned.m[c]);
      }
    }
    gltf_motion_end(motion, &scene);
    free(times);
    free(numbers);
  }
  gltf_raw_close(&raw);
}

static void posing_back_and_forth_gives_the_same_bytes(void **state)
{
  const char *path = asset_path("Fox/Fox.glb");
  Scene scene, anew;
  GltfMotion *motion = gltf_motion_fine(&scene, path, "Run"), *motion_anew = gltf_motion_fine(&anew, path, "Run");
  for (int i = 0; i < 24; i++) gltf_pose_fine(motion, &scene, i / 24.0);
  gltf_pose_fine(motion, &scene, 0.4);
  gltf_pose_fine(motion_anew, &anew, 0.4);
  assert_true(scenes_same(&scene, &anew));
  gltf_motion_end(motion, &scene);
  gltf_motion_end(motion_anew, &anew);
}

static void compressed_animations_are_refused_by_name(void **state)
{
  gltf_motion_fails(asset_path("FoxMeshopt/FoxMeshopt.glb"), "Run", STATUS_UNSUPPORTED, "EXT_meshopt_compression");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(box_animated_moves),
      cmocka_unit_test(the_fox_surveys_walks_and_runs),
      cmocka_unit_test(rigged_models_bend),
      cmocka_unit_test(the_cube_morphs),
      cmocka_unit_test(each_interpolation_meets_its_keys),
      cmocka_unit_test(posing_back_and_forth_gives_the_same_bytes),
      cmocka_unit_test(compressed_animations_are_refused_by_name),
  };
  return cmocka_run_group_tests(tests, gltf_tests_begin, gltf_tests_end);
}
