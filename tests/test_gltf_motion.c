// Animations of glTF files: each kind of interpolation and each thing that moves, on files small enough to know where
// all goes at any time.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/gltf_build.h"
#include "support/scene_same.h"

#define ONE_MESH "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"
#define TRIANGLE_WITH_TARGETS                                                                                         \
  "'meshes':[{'weights':[0.5,0.25],'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':1},{'POSITION':" \
  "2}"                                                                                                                \
  "]}]}]"

// Positions of a triangle, and of two morph targets that push it along X and Y.
static GltfBuild targets_build(void)
{
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  GLTF_FLOATS(&build, "VEC3", 3, 1, 0, 0, 1, 0, 0, 1, 0, 0);
  GLTF_FLOATS(&build, "VEC3", 3, 0, 1, 0, 0, 1, 0, 0, 1, 0);
  return build;
}

typedef struct Keys {
  const char *path, *interpolation, *type;  // the accessor's type of values
  int count, value_count;
  const float *times, *values;
} Keys;

// A triangle with morph targets whose node 0 moves by keys, below `more`.
static GltfMotion *keys_open(Scene *scene, const Keys *keys)
{
  GltfBuild build = targets_build();
  int width = keys->type[0] == 'S' ? 1 : keys->type[3] - '0';
  gltf_array(&build, 5126, "SCALAR", keys->times, sizeof(float) * (size_t)keys->count, keys->count, "");
  gltf_array(&build, 5126, keys->type, keys->values, sizeof(float) * (size_t)(width * keys->value_count),
             keys->value_count, "");
  return gltf_motion_fine(scene,
                          gltf_save(&build,
                                    ONE_NODE "," TRIANGLE_WITH_TARGETS ",'animations':[{'samplers':[{'input':3,'output'"
                                             ":4,'interpolation':'%s'}],'channels':[{'sampler':0,'target':{'node':0,"
                                             "'path':'%s'}}]}]",
                                    keys->interpolation, keys->path),
                          NULL);
}

static void motion_end(GltfMotion *motion, Scene *scene)
{
  gltf_motion_close(motion);
  scene_free(scene);
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
    motion_end(motion, &scene);
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
  motion_end(motion, &scene);
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
  motion_end(motion, &scene);
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
      motion_end(motion, &scene);
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
  motion_end(motion, &scene);
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
    GltfBuild build = targets_build();
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
                  ONE_NODE "," TRIANGLE_WITH_TARGETS
                           ",'animations':[{'samplers':[{'input':3,'output':4}],'channels':[{'sampler':0,'target':{"
                           "'node':0,'path':'%s'}}]}]",
                  cases[i].is_rotation ? "rotation" : "weights"),
        NULL);
    gltf_pose_fine(motion, &scene, 0.25);
    if (cases[i].is_rotation)
      assert_turned(&scene, 45);
    else
      ASSERT_FLOATS(scene.meshes[0].primitives[0].positions[0], 0.25f, 0.15f, 0);
    motion_end(motion, &scene);
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
    motion_end(motion, &scene);
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
  motion_end(motion, &scene);
}

// ---- what moves ----------------------------------------------------------------------------------------------------

// One key a track of what each node of a file has; the test says where it goes.
#define TRACK(sampler, node, path) "{'sampler':" #sampler ",'target':{'node':" #node ",'path':'" path "'}}"

static void children_instances_cameras_and_lights_follow(void **state)
{
  GltfBuild build = targets_build();
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
                "'channels':[" TRACK(0, 0, "translation") "," TRACK(1, 0, "rotation") "," TRACK(
                    2, 1, "scale") "," TRACK(2, 2, "scale") "]}]"),
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
  motion_end(motion, &scene);
}

static void a_mesh_whose_weights_move_on_a_node_is_that_nodes_own(void **state)
{
  GltfBuild build = targets_build();
  Scene scene;
  GLTF_FLOATS(&build, "SCALAR", 2, 0, 1);
  GLTF_FLOATS(&build, "SCALAR", 4, 0, 0, 4, 8);
  GltfMotion *motion = gltf_motion_fine(
      &scene,
      gltf_save(&build,
                "'scenes':[{'nodes':[0,1,2,3]}],'nodes':[{'mesh':0},{'mesh':0},{'mesh':0},{'mesh':0,'weights':[1,1]}]"
                "," TRIANGLE_WITH_TARGETS
                ",'animations':[{'samplers':[{'input':3,'output':4}],'channels':[" TRACK(0, 1, "weights") "]}]"),
      NULL);
  assert_int_equal(scene.mesh_count, 3);
  assert_int_equal(scene.objects[0].mesh, scene.objects[2].mesh);
  gltf_pose_fine(motion, &scene, 0.5);
  ASSERT_FLOATS(scene.meshes[scene.objects[0].mesh].primitives[0].positions[0], 0.5f, 0.25f, 0);
  ASSERT_FLOATS(scene.meshes[scene.objects[1].mesh].primitives[0].positions[0], 2, 4, 0);
  ASSERT_FLOATS(scene.meshes[scene.objects[3].mesh].primitives[0].positions[0], 1, 1, 0);
  motion_end(motion, &scene);
}

// Half of the vertices hang on a joint that turns, one on both by half; flat normals are those of the pose.
static void skins_follow_their_joints(void **state)
{
  const uint8_t joints[3][4] = {{0}, {1}, {0, 1}};
  const float weights[3][4] = {{1}, {1}, {0.5f, 0.5f}};
  GltfBuild build = targets_build();
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
                "'channels':[" TRACK(0, 2, "rotation") "," TRACK(0, 0, "rotation") "]}]"),
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
  motion_end(motion, &scene);
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
  motion_end(motion, &scene);
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
  motion_end(motion, &scene);
  motion_end(motion_anew, &anew);
}

// What was counted against the limit once is not counted for each pose.
static void a_thousand_poses_need_the_memory_of_one(void **state)
{
  Scene scene;
  gltf_options.max_memory_bytes = 1500000;
  GltfMotion *motion = gltf_motion_fine(&scene, "scenes/carousel.glb", NULL);
  for (int i = 0; i < 1000; i++) gltf_pose_fine(motion, &scene, i / 500.0);
  motion_end(motion, &scene);
  gltf_options.max_memory_bytes = 100000;
  gltf_motion_fails("scenes/carousel.glb", NULL, STATUS_TOO_LARGE, "needs more memory than allowed");
}

// ---- choice --------------------------------------------------------------------------------------------------------

// A triangle that three animations move, to 1, 2 and 3.
static const char *choices_save(void)
{
  GltfBuild build = targets_build();
  char animations[1024] = "";
  const char *const names[] = {"walk", "run", "2"};
  GLTF_FLOATS(&build, "SCALAR", 1, 0);
  for (int i = 0; i < 3; i++) {
    float value[3] = {(float)(i + 1)};
    int output = gltf_array(&build, 5126, "VEC3", value, sizeof value, 1, "");
    snprintf(animations + strlen(animations), sizeof animations - strlen(animations),
             "%s{'name':'%s','samplers':[{'input':3,'output':%d}],'channels':[" TRACK(0, 0, "translation") "]}",
             i ? "," : "", names[i], output);
  }
  return gltf_save(&build, ONE_NODE "," ONE_MESH ",'animations':[%s]", animations);
}

static void animations_are_chosen_by_name_or_index(void **state)
{
  const struct {
    const char *choice;
    double x;
  } cases[] = {{NULL, 1}, {"walk", 1}, {"run", 2}, {"0", 1}, {"1", 2}, {"2", 3}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    Scene scene;
    GltfMotion *motion = gltf_motion_fine(&scene, choices_save(), cases[i].choice);
    assert_int_equal(strstr(gltf_warnings, "animation 0 'walk' of 3 is followed") != NULL, !cases[i].choice);
    gltf_pose_fine(motion, &scene, 0);
    assert_near(scene.objects[0].world_from_object.m[12], cases[i].x);
    motion_end(motion, &scene);
  }
  gltf_motion_fails(choices_save(), "rum", STATUS_USAGE, "no animation 'rum': did you mean 'run'?");
  gltf_motion_fails(choices_save(), "3", STATUS_USAGE, "no animation 3: the file has 3: ");
  gltf_motion_fails(choices_save(), "99999999999999999999999", STATUS_USAGE, "the file has 3");
  gltf_motion_fails("scenes/room.glb", "walk", STATUS_USAGE, "no animation 'walk': it has none");
  gltf_motion_fails("none.glb", NULL, STATUS_NOT_FOUND, "none.glb: ");
}

static void a_file_without_animations_stands_still(void **state)
{
  Scene scene, still = gltf_read_fine("scenes/room.glb");
  GltfMotion *motion = gltf_motion_fine(&scene, "scenes/room.glb", NULL);
  assert_string_equal(gltf_warnings, "");
  assert_true(gltf_motion_length_s(motion) == 0);
  gltf_pose_fine(motion, &scene, 3);
  assert_true(scenes_same(&scene, &still));
  motion_end(motion, &scene);
  scene_free(&still);
}

// ---- what is not followed, and what is refused ---------------------------------------------------------------------

// Opens a triangle below two nodes (1 has a matrix) whose accessors 3 to 6 are times and values of two keys.
static const char *sampled_save(const char *animation)
{
  GltfBuild build = targets_build();
  GLTF_FLOATS(&build, "SCALAR", 2, 0, 1);                  // 3
  GLTF_FLOATS(&build, "VEC3", 2, 0, 0, 0, 2, 2, 2);        // 4
  GLTF_FLOATS(&build, "SCALAR", 4, 0, 0, 1, 1);            // 5
  GLTF_FLOATS(&build, "VEC4", 2, 0, 0, 0, 1, 0, 0, 1, 0);  // 6
  GLTF_FLOATS(&build, "SCALAR", 2, 1, 1);                  // 7: does not rise
  GLTF_FLOATS(&build, "SCALAR", 2, 1, 0.5f);               // 8: falls
  GLTF_FLOATS(&build, "SCALAR", 2, -1, 1);                 // 9: begins before the beginning
  GLTF_FLOATS(&build, "SCALAR", 2, 0, INFINITY);           // 10
  GLTF_FLOATS(&build, "SCALAR", 2, NAN, 1);                // 11
  GLTF_FLOATS(&build, "VEC3", 2, 0, 0, 0, NAN, 2, 2);      // 12
  const uint16_t shorts[] = {0, 1, 2, 3};
  gltf_array(&build, 5123, "SCALAR", shorts, sizeof shorts, 4, "");                    // 13: not normalised
  gltf_array(&build, 5123, "SCALAR", shorts, sizeof shorts, 4, ",'normalized':true");  // 14
  GLTF_FLOATS(&build, "VEC3", 2, 0, 0, 0, 3e38f, 0, 0);                                // 15
  GLTF_FLOATS(&build, "SCALAR", 4, 0, 0, 3e38f, 3e38f);                                // 16
  return gltf_save(
      &build,
      "'extensionsUsed':['KHR_lights_punctual'],'extensions':{'KHR_lights_punctual':{'lights':[{'type':"
      "'point'}]}},'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0,'name':'thing'},{'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,"
      "0,0,1],'children':[2]},{'name':'bare','scale':[1e300,1e300,1e300],'children':[3]},{'name':'far',"
      "'extensions':{'KHR_lights_punctual':{'light':0}}}],'meshes':[{'primitives':[{'attributes':{'POSITION'"
      ":0},'targets':[{'POSITION':1},{'POSITION':1}]}]}]"
      ",'animations':[{'name':'it',%s}]",
      animation);
}

#define SAMPLER(input, output) "'samplers':[{'input':" #input ",'output':" #output "}]"

static void channels_that_are_not_followed_are_named(void **state)
{
  const struct {
    const char *animation, *warning;
    double x;
  } cases[] = {
      {SAMPLER(3, 4) ",'channels':[" TRACK(0, 1, "translation") "]",
       "animations[0] 'it' channels[0], the translation of nodes[1], is not followed: the node has a matrix: give it",
       0},
      {SAMPLER(3, 5) ",'channels':[" TRACK(0, 2, "weights") "]",
       "the weights of nodes[2], is not followed: it draws no morph targets", 0},
      {SAMPLER(3, 4) ",'channels':[" TRACK(0, 0, "translation") "," TRACK(0, 0, "translation") "]",
       "channels[1], the translation of nodes[0], is not followed: an earlier channel moves the same", 2},
      {SAMPLER(3, 4) ",'channels':[" TRACK(0, 0, "pointer") "," TRACK(0, 0, "translation") "]",
       "channels[0] is not followed: it moves 'pointer'", 2},
      {SAMPLER(3, 4) ",'channels':[{'sampler':0,'target':{'path':'pointer','extensions':{'KHR_animation_pointer':{"
                     "'pointer':'/nodes/0/translation'}}}}," TRACK(0, 0, "translation") "]",
       "channels[0] is not followed: it moves 'pointer'", 2},
      {SAMPLER(3, 4) ",'channels':[{'sampler':0,'target':{'path':'translation'}}," TRACK(0, 0, "translation") "]", "",
       2},
      {SAMPLER(3, 7) ",'channels':[]", "", 0},
      {"'samplers':[],'channels':[]", "", 0},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    Scene scene;
    GltfMotion *motion = gltf_motion_fine(&scene, sampled_save(cases[i].animation), NULL);
    if (!strstr(gltf_warnings, cases[i].warning) || (*gltf_warnings && !*cases[i].warning))
      fail_msg("case %zu: '%s' without '%s'", i, gltf_warnings, cases[i].warning);
    gltf_pose_fine(motion, &scene, 1);
    assert_near(scene.objects[0].world_from_object.m[12], cases[i].x);
    motion_end(motion, &scene);
  }
}

static void bad_keys_are_refused_and_rest_is_drawn(void **state)
{
  const struct {
    const char *animation, *message;
  } cases[] = {
      {SAMPLER(7, 4), "animations[0] 'it' channels[0]: key 1, at 1 s, does not follow the one at 1 s: repair"},
      {SAMPLER(8, 4), "key 1, at 0.5 s, does not follow the one at 1 s"},
      {SAMPLER(9, 4), "channels[0]: its first key is at -1 s"},
      {SAMPLER(10, 4), "channels[0]: accessors[10] element 1 is not a finite number"},
      {SAMPLER(11, 4), "accessors[11] element 0 is not a finite number"},
      {SAMPLER(4, 4), "accessors[4] has 3 components, not 1"},
      {SAMPLER(14, 4), "accessors[14], its times, holds no floats"},
      {SAMPLER(3, 5), "accessors[5] has 1 components, not 3"},
      {SAMPLER(3, 6), "accessors[6] has 4 components, not 3"},
      {SAMPLER(3, 0), "accessors[0] has 3 elements, not 2"},
      {SAMPLER(3, 12), "accessors[12] element 1 is not a finite number"},
      {"'samplers':[{'input':3,'output':4,'interpolation':'CUBICSPLINE'}]", "accessors[4] has 2 elements, not 6"},
  };
  char text[512];
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    snprintf(text, sizeof text, "%s,'channels':[" TRACK(0, 0, "translation") "]", cases[i].animation);
    gltf_motion_fails(sampled_save(text), NULL, STATUS_BAD_SCENE, cases[i].message);
    Scene scene = gltf_read_fine(sampled_save(text));
    assert_non_null(strstr(gltf_warnings, "1 animations: the pose at rest is drawn: add --frames to see them move"));
    scene_free(&scene);
  }
  gltf_motion_fails(sampled_save(SAMPLER(3, 7) ",'channels':[" TRACK(0, 0, "weights") "]"), NULL, STATUS_BAD_SCENE,
                    "accessors[7] has 2 elements, not 4");
  gltf_motion_fails(sampled_save(SAMPLER(3, 13) ",'channels':[" TRACK(0, 0, "weights") "]"), NULL, STATUS_BAD_SCENE,
                    "accessors[13] holds integers that are not normalized");
  gltf_motion_fails(sampled_save(SAMPLER(3, 4) ",'channels':[" TRACK(0, 0, "rotation") "]"), NULL, STATUS_BAD_SCENE,
                    "accessors[4] has 3 components, not 4");
}

static void a_pose_that_leaves_all_numbers_is_refused(void **state)
{
  const struct {
    const char *animation, *message;
  } cases[] = {
      {SAMPLER(3, 15) ",'channels':[" TRACK(0, 3, "scale") "]", "nodes[3] 'far' has a transform that is not finite"},
      {SAMPLER(3, 4) ",'channels':[" TRACK(0, 3, "translation") "]", "the light 'far' goes to infinity"},
      {SAMPLER(3, 16) ",'channels':[" TRACK(0, 0, "weights") "]",
       "meshes[0] '' primitives[0]: vertex 0 is not finite in its pose"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    Scene scene;
    GltfMotion *motion = gltf_motion_fine(&scene, sampled_save(cases[i].animation), NULL);
    gltf_pose_fine(motion, &scene, 0);
    gltf_pose_fails(motion, &scene, 1, STATUS_BAD_SCENE, cases[i].message);
    gltf_pose_fine(motion, &scene, 0);
    motion_end(motion, &scene);
  }
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
      cmocka_unit_test(a_scale_of_zero_keeps_its_object),
      cmocka_unit_test(the_same_time_gives_the_same_bytes),
      cmocka_unit_test(a_thousand_poses_need_the_memory_of_one),
      cmocka_unit_test(animations_are_chosen_by_name_or_index),
      cmocka_unit_test(a_file_without_animations_stands_still),
      cmocka_unit_test(channels_that_are_not_followed_are_named),
      cmocka_unit_test(bad_keys_are_refused_and_rest_is_drawn),
      cmocka_unit_test(a_pose_that_leaves_all_numbers_is_refused),
  };
  return cmocka_run_group_tests(tests, gltf_tests_begin, gltf_tests_end);
}
