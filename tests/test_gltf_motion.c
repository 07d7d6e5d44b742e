// Animations of glTF files: each thing that moves, on files small enough to know where all goes at any time.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_defaults.h"
#include "support/gltf_keys.h"
#include "support/scene_same.h"

#define ONE_MESH "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"

static const float uneven_s[] = {0.5f, 1, 2.5f, 2.75f};

// ---- what moves ----------------------------------------------------------------------------------------------------

static void children_instances_cameras_and_lights_follow(void **state)
{
  GltfBuild build = gltf_targets_build();
  Scene scene;
  GLTF_FLOATS(&build, "SCALAR", 2, 0, 1);                  // 3
  GLTF_FLOATS(&build, "VEC3", 2, 0, 0, 0, 0, 0, 8);        // 4
  GLTF_FLOATS(&build, "VEC4", 2, 0, 0, 0, 1, 0, 1, 0, 0);  // 5: half a turn about Y
  GLTF_FLOATS(&build, "VEC3", 2, 2, 2, 2, -3, 1, 0.5f);    // 6: a scale that mirrors
  GLTF_FLOATS(&build, "VEC3", 2, 1, 0, 0, 5, 0, 0);        // 7: two instances
  GltfMotion *motion = gltf_motion_fine(
      &scene,
      gltf_save(&build,
                "'extensionsUsed':['EXT_mesh_gpu_instancing','KHR_lights_punctual'],'extensions':{"
                "'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{}}]}},'cameras':[{'type':'perspective',"
                "'perspective':{'yfov':1,'znear':1}}],'scenes':[{'nodes':[0,4]}],'nodes':[{'children':[1,2,3]},"
                "{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':7}}}},"
                "{'camera':0,'translation':[1,0,0]},{'translation':[0,1,0],'extensions':{'KHR_lights_punctual':{"
                "'light':0}}},{'mesh':0}]," ONE_MESH
                ",'animations':[{'samplers':[{'input':3,'output':4},{'input':3,'output':5},{'input':3,'output':6}],"
                "'channels':[" GLTF_TRACK(0, 0, "translation") "," GLTF_TRACK(1, 0, "rotation") "," GLTF_TRACK(
                    2, 1, "scale") "," GLTF_TRACK(2, 2, "scale") "]}]"),
      NULL);
  assert_int_equal(scene.object_count, 3);
  gltf_pose_fine(motion, &scene, 1);
  assert_vec3(gltf_object_point(&scene, 0, 1, 1, 1), 6, 1, 7.5);
  assert_vec3(gltf_object_point(&scene, 1, 1, 1, 1), 18, 1, 7.5);
  assert_vec3(gltf_object_point(&scene, 2, 1, 1, 1), 1, 1, 1);
  assert_int_equal(scene.meshes[0].primitives[0].triangle_count, 1);
  const Mat4 *camera = &scene.cameras[0].world_from_camera;
  assert_vec3(mat4_point(camera, vec3(0, 0, 0)), -1, 0, 8);
  assert_vec3(mat4_direction(camera, vec3(0, 0, -1)), 0, 0, 1);
  assert_near(mat4_determinant3(camera), 1);
  assert_vec3(scene.lights[0].position_world, 0, 1, 8);
  assert_vec3(scene.lights[0].direction_world, 0, 0, 1);
  gltf_pose_fine(motion, &scene, 0.5);
  assert_vec3(gltf_object_point(&scene, 0, 0, 0, 0), 0, 0, 4 + 0.5);
  assert_vec3(scene.lights[0].direction_world, -1, 0, 0);
  gltf_motion_end(motion, &scene);
}

static void a_mesh_whose_weights_move_on_a_node_is_that_nodes_own(void **state)
{
  GltfBuild build = gltf_targets_build();
  Scene scene;
  GLTF_FLOATS(&build, "SCALAR", 2, 0, 1);
  GLTF_FLOATS(&build, "SCALAR", 4, 0, 0, 4, 8);
  GltfMotion *motion = gltf_motion_fine(
      &scene,
      gltf_save(&build,
                "'scenes':[{'nodes':[0,1,2,3]}],'nodes':[{'mesh':0},{'mesh':0},{'mesh':0},{'mesh':0,'weights':[1,1]}]"
                "," GLTF_MORPHED_TRIANGLE
                ",'animations':[{'samplers':[{'input':3,'output':4}],'channels':[" GLTF_TRACK(0, 1, "weights") "]}]"),
      NULL);
  assert_int_equal(scene.mesh_count, 3);
  assert_int_equal(scene.objects[0].mesh, scene.objects[2].mesh);
  gltf_pose_fine(motion, &scene, 0.5);
  ASSERT_FLOATS(scene.meshes[scene.objects[0].mesh].primitives[0].positions[0], 0.5f, 0.25f, 0);
  ASSERT_FLOATS(scene.meshes[scene.objects[1].mesh].primitives[0].positions[0], 2, 4, 0);
  ASSERT_FLOATS(scene.meshes[scene.objects[3].mesh].primitives[0].positions[0], 1, 1, 0);
  gltf_motion_end(motion, &scene);
}

// Half of the vertices hang on a joint that turns, one on both by half; flat normals are those of the pose.
static void skins_follow_their_joints(void **state)
{
  const uint8_t joints[3][4] = {{0}, {1}, {0, 1}};
  const float weights[3][4] = {{1}, {1}, {0.5f, 0.5f}};
  GltfBuild build = gltf_targets_build();
  Scene scene;
  GLTF_FLOATS(&build, "SCALAR", 2, 0, 1);                  // 3
  GLTF_FLOATS(&build, "VEC4", 2, 0, 0, 0, 1, 1, 0, 0, 0);  // 4: half a turn about X
  gltf_array(&build, 5121, "VEC4", joints, sizeof joints, 3, "");
  gltf_array(&build, 5126, "VEC4", weights, sizeof weights, 3, "");
  GltfMotion *motion = gltf_motion_fine(
      &scene,
      gltf_save(&build,
                "'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0,'skin':0,'translation':[50,50,50]},{'children':[2]},"
                "{'translation':[0,1,0]}],'skins':[{'joints':[1,2]}],'meshes':[{'primitives':[{'attributes':{"
                "'POSITION':0,'JOINTS_0':5,'WEIGHTS_0':6}}]}],'animations':[{'samplers':[{'input':3,'output':4}],"
                "'channels':[" GLTF_TRACK(0, 2, "rotation") "," GLTF_TRACK(0, 0, "rotation") "]}]"),
      NULL);
  const float(*positions)[3] = (const float(*)[3])scene.meshes[0].primitives[0].positions;
  ASSERT_FLOATS(positions[2], 0, 1.5f, 0);
  gltf_pose_fine(motion, &scene, 0.5);  // a quarter: joint 1 takes (0, y, z) to (0, 1 - z, y)
  ASSERT_FLOATS(positions[0], 0, 0, 0);
  ASSERT_FLOATS(positions[1], 1, 1, 0);
  ASSERT_FLOATS(positions[2], 0, 1, 0.5f);
  float length = sqrtf(0.25f + 0.25f + 1);
  ASSERT_FLOATS(scene.meshes[0].primitives[0].normals[0], 0.5f / length, -0.5f / length, 1 / length);
  assert_vec3(gltf_object_point(&scene, 0, 1, 2, 3), 1, 2, 3);
  gltf_motion_end(motion, &scene);
}

// A scene without lights is given a sun, which stays where it is.
static void lights_that_are_not_of_the_file_stay(void **state)
{
  Scene scene;
  Log log = {0};
  const float values[] = {0, 0, 0, 0, 90, 0}, times[] = {0, 1};
  GltfMotion *motion = gltf_keys_open(&scene, &(Keys){"translation", "LINEAR", "VEC3", 2, 2, times, values});
  assert_int_equal(scene_add_default_lighting(&scene, true, &log), STATUS_OK);
  assert_int_equal(scene.light_count, 1);
  const Light sun = scene.lights[0];
  gltf_pose_fine(motion, &scene, 1);
  assert_memory_equal(&scene.lights[0], &sun, sizeof sun);
  gltf_motion_close(motion);
  scene_free(&scene);
}

static void a_scale_of_zero_keeps_its_object(void **state)
{
  const float values[] = {1, 1, 1, 0, 0, 0};
  Scene scene;
  GltfMotion *motion = gltf_keys_open(&scene, &(Keys){"scale", "LINEAR", "VEC3", 2, 2, uneven_s, values});
  gltf_pose_fine(motion, &scene, 1);
  assert_int_equal(scene.object_count, 1);
  assert_int_equal(scene_triangle_count(&scene), 1);
  assert_vec3(gltf_object_point(&scene, 0, 1, 1, 1), 0, 0, 0);
  gltf_pose_fine(motion, &scene, 0.75);
  assert_vec3(gltf_object_point(&scene, 0, 1, 1, 1), 0.5, 0.5, 0.5);
  gltf_motion_end(motion, &scene);
}

// ---- the scene with all of it --------------------------------------------------------------------------------------

// Whatever was posed before, and on a scene opened anew; addresses stay.
static void the_same_time_gives_the_same_bytes(void **state)
{
  Scene scene, anew;
  GltfMotion *motion = gltf_motion_fine(&scene, "scenes/carousel.glb", "carousel");
  GltfMotion *motion_anew = gltf_motion_fine(&anew, "scenes/carousel.glb", "0");
  const void *positions = scene.meshes[0].primitives[0].positions, *objects = scene.objects;
  assert_string_equal(gltf_warnings, "");
  assert_near(gltf_motion_length_s(motion), 2);
  assert_true(scenes_same(&scene, &anew));
  gltf_pose_fine(motion, &scene, 0.7);
  gltf_pose_fine(motion, &scene, 1.55);
  assert_false(scenes_same(&scene, &anew));
  gltf_pose_fine(motion, &scene, 0.7);
  gltf_pose_fine(motion_anew, &anew, 0.7);
  assert_true(scenes_same(&scene, &anew));
  assert_ptr_equal(scene.meshes[0].primitives[0].positions, positions);
  assert_ptr_equal(scene.objects, objects);
  gltf_motion_end(motion, &scene);
  gltf_motion_end(motion_anew, &anew);
}

// What was counted against the limit once is not counted for each pose.
static void a_thousand_poses_need_the_memory_of_one(void **state)
{
  Scene scene;
  gltf_options.max_memory_bytes = 1500000;
  GltfMotion *motion = gltf_motion_fine(&scene, "scenes/carousel.glb", NULL);
  for (int i = 0; i < 1000; i++) gltf_pose_fine(motion, &scene, i / 500.0);
  gltf_motion_end(motion, &scene);
  gltf_options.max_memory_bytes = 100000;
  gltf_motion_fails("scenes/carousel.glb", NULL, STATUS_TOO_LARGE, "needs more memory than allowed");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(children_instances_cameras_and_lights_follow),
      cmocka_unit_test(a_mesh_whose_weights_move_on_a_node_is_that_nodes_own),
      cmocka_unit_test(skins_follow_their_joints),
      cmocka_unit_test(lights_that_are_not_of_the_file_stay),
      cmocka_unit_test(a_scale_of_zero_keeps_its_object),
      cmocka_unit_test(the_same_time_gives_the_same_bytes),
      cmocka_unit_test(a_thousand_poses_need_the_memory_of_one),
  };
  return cmocka_run_group_tests(tests, gltf_tests_begin, gltf_tests_end);
}
