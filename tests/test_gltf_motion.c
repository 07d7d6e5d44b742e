// Animations of glTF files: each kind of interpolation and each thing that moves, on files small enough to know where
// all goes at any time.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_defaults.h"
#include "support/gltf_build.h"
#include "support/scene_same.h"

#define ONE_MESH "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"

typedef struct Keys {
  const char *path, *interpolation, *type;  // the accessor's type of values
  int count, value_count;
  const float *times, *values;
} Keys;

// A triangle with morph targets whose node moves by keys.
static GltfMotion *keys_open(Scene *scene, const Keys *keys)
{
  GltfBuild build = gltf_targets_build();
  int width = keys->type[0] == 'S' ? 1 : keys->type[3] - '0';
  gltf_array(&build, 5126, "SCALAR", keys->times, sizeof(float) * (size_t)keys->count, keys->count, "");
  gltf_array(&build, 5126, keys->type, keys->values, sizeof(float) * (size_t)(width * keys->value_count),
             keys->value_count, "");
  return gltf_motion_fine(scene,
                          gltf_save(&build,
                                    ONE_NODE "," GLTF_MORPHED_TRIANGLE ",'animations':[{'samplers':[{'input':3,'output'"
                                             ":4,'interpolation':'%s'}],'channels':[{'sampler':0,'target':{'node':0,"
                                             "'path':'%s'}}]}]",
                                    keys->interpolation, keys->path),
                          NULL);
}

// ---- interpolation -------------------------------------------------------------------------------------------------

static const float uneven_s[] = {0.5f, 1, 2.5f, 2.75f};

static void linear_goes_straight_and_holds_at_the_ends(void **state)
{
  const float values[] = {1, 2, 3, -1, 5, 4, 0, 0, 100, 7, 7, 7};
  const char *const paths[] = {"translation", "scale"};
  for (int p = 0; p < 2; p++) {
    Scene scene;
    GltfMotion *motion = keys_open(&scene, &(Keys){paths[p], "LINEAR", "VEC3", 4, 4, uneven_s, values});
    assert_near(gltf_motion_length_s(motion), 2.75);
    for (double t = -1; t < 4; t += 0.0625) {
      double clamped = fmin(fmax(t, 0.5), 2.75), expected[3];
      int k = clamped < 1 ? 0 : clamped < 2.5 ? 1 : 2;
      double u = (clamped - uneven_s[k]) / (uneven_s[k + 1] - uneven_s[k]);
      for (int c = 0; c < 3; c++) expected[c] = (1 - u) * values[3 * k + c] + u * values[3 * k + 3 + c];
      gltf_pose_fine(motion, &scene, t);
      const Mat4 *world = &scene.objects[0].world_from_object;
      for (int c = 0; c < 3; c++) assert_near(p ? world->m[5 * c] : world->m[12 + c], expected[c]);
    }
    gltf_motion_end(motion, &scene);
  }
}

static void steps_hold_until_the_next_key(void **state)
{
  const float values[] = {1, 0, 0, 2, 0, 0, 3, 0, 0, 4, 0, 0};
  const struct {
    double time_s, x;
  } cases[] = {{0, 1}, {0.5, 1}, {0.9999999, 1}, {1, 2}, {2.4999999, 2}, {2.5, 3}, {2.74, 3}, {2.75, 4}, {9, 4}};
  Scene scene;
  GltfMotion *motion = keys_open(&scene, &(Keys){"translation", "STEP", "VEC3", 4, 4, uneven_s, values});
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    gltf_pose_fine(motion, &scene, cases[i].time_s);
    assert_near(scene.objects[0].world_from_object.m[12], cases[i].x);
  }
  gltf_motion_end(motion, &scene);
}

// A cubic polynomial is what splines with its values and slopes give, whatever the keys are.
static void cubic_splines_follow_a_polynomial(void **state)
{
  const double k[3][4] = {{1, 2, -3, 0.5}, {0, -1, 0, 2}, {-4, 0, 1, 0}};
  float values[4][3][3];
  for (int i = 0; i < 4; i++)
    for (int c = 0; c < 3; c++) {
      double t = uneven_s[i], slope = k[c][1] + t * (2 * k[c][2] + t * 3 * k[c][3]);
      values[i][0][c] = values[i][2][c] = (float)slope;
      values[i][1][c] = (float)(k[c][0] + t * (k[c][1] + t * (k[c][2] + t * k[c][3])));
    }
  for (int c = 0; c < 3; c++) values[0][0][c] = values[3][2][c] = 1e6f;  // leads in, leads out: never looked at
  Scene scene;
  GltfMotion *motion = keys_open(&scene, &(Keys){"translation", "CUBICSPLINE", "VEC3", 4, 12, uneven_s, **values});
  for (double t = 0; t < 3; t += 0.03125) {
    double at = fmin(fmax(t, 0.5), 2.75);
    gltf_pose_fine(motion, &scene, t);
    for (int c = 0; c < 3; c++)
      assert_near(scene.objects[0].world_from_object.m[12 + c],
                  k[c][0] + at * (k[c][1] + at * (k[c][2] + at * k[c][3])));
  }
  gltf_motion_end(motion, &scene);
}

static void quaternion_set(float out[4], double degrees, double side)
{
  double half = degrees * M_PI / 360;
  const double q[4] = {0, 0, side * sin(half), side * cos(half)};
  for (int c = 0; c < 4; c++) out[c] = (float)q[c];
}

static void assert_turned(const Scene *scene, double degrees)
{
  double angle = degrees * M_PI / 180;
  assert_vec3(mat4_direction(&scene->objects[0].world_from_object, vec3(1, 0, 0)), cos(angle), sin(angle), 0);
}

// With an even speed, and the shorter way though the keys' signs say the longer; a whole turn's half, and hardly any.
static void rotations_turn_evenly_and_the_shorter_way(void **state)
{
  const double degrees[][2] = {{0, 90}, {10, 189}, {-170, 5}, {30, 30}, {0, 1e-4}, {100, 101}};
  for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++)
    for (int side = -1; side <= 1; side += 2) {
      float values[2][4];
      Scene scene;
      quaternion_set(values[0], degrees[i][0], 1);
      quaternion_set(values[1], degrees[i][1], side);
      GltfMotion *motion = keys_open(&scene, &(Keys){"rotation", "LINEAR", "VEC4", 2, 2, uneven_s, *values});
      for (int step = 0; step <= 8; step++) {
        gltf_pose_fine(motion, &scene, 0.5 + step / 16.0);
        assert_turned(&scene, degrees[i][0] + (degrees[i][1] - degrees[i][0]) * step / 8);
      }
      gltf_motion_end(motion, &scene);
    }
}

static void cubic_rotations_come_out_unit_length(void **state)
{
  float values[2][3][4] = {0};
  Scene scene;
  quaternion_set(values[0][1], 0, 1);
  quaternion_set(values[1][1], 90, 1);
  values[0][2][2] = 3;  // leaves quickly
  values[1][0][3] = -1;
  GltfMotion *motion = keys_open(&scene, &(Keys){"rotation", "CUBICSPLINE", "VEC4", 2, 6, uneven_s, **values});
  for (int step = 0; step <= 8; step++) {
    double u = step / 8.0, h = 0.5, r = sqrt(0.5);
    double b = 3 * u * u - 2 * u * u * u, leave = u * u * u - 2 * u * u + u, reach = u * u * u - u * u;
    double z = b * r + h * leave * 3, w = (1 - b) + b * r - h * reach;
    gltf_pose_fine(motion, &scene, 0.5 + h * u);
    assert_turned(&scene, 2 * atan2(z, w) * 180 / M_PI);
    assert_near(mat4_determinant3(&scene.objects[0].world_from_object), 1);
  }
  gltf_motion_end(motion, &scene);
}

// Normalised integers of each width, and a value that a sparse accessor replaces.
static void rotations_and_weights_of_integers(void **state)
{
  const int8_t bytes[] = {0, 0, 0, 127, 0, 0, 127, 0};
  const int16_t shorts[] = {0, 0, 0, 32767, 0, 0, 32767, 0};
  const uint8_t ubytes[] = {0, 51, 255, 0};
  const uint16_t ushorts[] = {0, 13107, 65535, 0}, second[] = {1};
  const struct {
    int type;
    const void *data;
    size_t size;
    bool is_rotation;
  } cases[] = {{5120, bytes, sizeof bytes, true},
               {5122, shorts, sizeof shorts, true},
               {5121, ubytes, sizeof ubytes, false},
               {5123, ushorts, sizeof ushorts, false},
               {5126, NULL, 0, false}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    GltfBuild build = gltf_targets_build();
    Scene scene;
    GLTF_FLOATS(&build, "SCALAR", 2, 0, 1);
    if (cases[i].data) {
      gltf_array(&build, cases[i].type, cases[i].is_rotation ? "VEC4" : "SCALAR", cases[i].data, cases[i].size,
                 cases[i].is_rotation ? 2 : 4, ",'normalized':true");
    } else {
      int base = gltf_view(&build, (const float[]){0, 9, 1, 0}, 16, 0), to = gltf_view(&build, second, 2, 0);
      int value = gltf_view(&build, (const float[]){0.2f}, 4, 0);
      gltf_accessor(&build,
                    "{'bufferView':%d,'componentType':5126,'type':'SCALAR','count':4,'sparse':{'count':1,'indices':{"
                    "'bufferView':%d,'componentType':5123},'values':{'bufferView':%d}}}",
                    base, to, value);
    }
    GltfMotion *motion = gltf_motion_fine(
        &scene,
        gltf_save(&build,
                  ONE_NODE "," GLTF_MORPHED_TRIANGLE
                           ",'animations':[{'samplers':[{'input':3,'output':4}],'channels':[{'sampler':0,'target':{"
                           "'node':0,'path':'%s'}}]}]",
                  cases[i].is_rotation ? "rotation" : "weights"),
        NULL);
    gltf_pose_fine(motion, &scene, 0.25);
    if (cases[i].is_rotation)
      assert_turned(&scene, 45);
    else
      ASSERT_FLOATS(scene.meshes[0].primitives[0].positions[0], 0.25f, 0.15f, 0);
    gltf_motion_end(motion, &scene);
  }
}

static void weights_of_each_interpolation(void **state)
{
  const float linear[] = {0, 1, 1, 3, 2, 2, 0, 0};
  const float cubic[] = {9, 9, 0, 1, 2, -4, 0, 0, 1, 1, 0, 0};  // two keys: in tangents, weights, out tangents
  const double u = 0.5, h = 0.5;
  const struct {
    Keys keys;
    double x, y;
  } cases[] = {
      {{"weights", "LINEAR", "SCALAR", 4, 8, uneven_s, linear}, 0.5, 2},
      {{"weights", "STEP", "SCALAR", 4, 8, uneven_s, linear}, 0, 1},
      {{"weights", "CUBICSPLINE", "SCALAR", 2, 12, uneven_s, cubic},
       0.5 + h * (u * u * u - 2 * u * u + u) * 2,
       1 - h * (u * u * u - 2 * u * u + u) * 4},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    Scene scene;
    GltfMotion *motion = keys_open(&scene, &cases[i].keys);
    ASSERT_FLOATS(scene.meshes[0].primitives[0].positions[1], 1.5f, 0.25f, 0);  // at rest: the mesh's own weights
    gltf_pose_fine(motion, &scene, 0.75);
    ASSERT_FLOATS(scene.meshes[0].primitives[0].positions[1], (float)(1 + cases[i].x), (float)cases[i].y, 0);
    gltf_motion_end(motion, &scene);
  }
}

static void times_before_after_and_none(void **state)
{
  const float values[] = {1, 2, 3, -1, 5, 4, 0, 0, 100, 7, 7, 7};
  Scene scene;
  GltfMotion *motion = keys_open(&scene, &(Keys){"translation", "LINEAR", "VEC3", 4, 4, uneven_s, values});
  const double early[] = {-INFINITY, -1e300, -1, -0.0, 0, 0.5}, late[] = {2.75, 3, 1e300, INFINITY};
  for (size_t i = 0; i < sizeof early / sizeof *early; i++) {
    gltf_pose_fine(motion, &scene, early[i]);
    assert_vec3(gltf_object_point(&scene, 0, 0, 0, 0), 1, 2, 3);
  }
  for (size_t i = 0; i < sizeof late / sizeof *late; i++) {
    gltf_pose_fine(motion, &scene, late[i]);
    assert_vec3(gltf_object_point(&scene, 0, 0, 0, 0), 7, 7, 7);
  }
  gltf_pose_fails(motion, &scene, NAN, STATUS_USAGE, "test.glb: a pose at a time that is not a number: ");
  gltf_motion_end(motion, &scene);
}

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
  GltfMotion *motion = keys_open(&scene, &(Keys){"translation", "LINEAR", "VEC3", 2, 2, times, values});
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
  GltfMotion *motion = keys_open(&scene, &(Keys){"scale", "LINEAR", "VEC3", 2, 2, uneven_s, values});
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
      cmocka_unit_test(linear_goes_straight_and_holds_at_the_ends),
      cmocka_unit_test(steps_hold_until_the_next_key),
      cmocka_unit_test(cubic_splines_follow_a_polynomial),
      cmocka_unit_test(rotations_turn_evenly_and_the_shorter_way),
      cmocka_unit_test(cubic_rotations_come_out_unit_length),
      cmocka_unit_test(rotations_and_weights_of_integers),
      cmocka_unit_test(weights_of_each_interpolation),
      cmocka_unit_test(times_before_after_and_none),
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
