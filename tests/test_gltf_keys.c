// Animations of glTF files: each kind of interpolation, of each kind of value.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/gltf_keys.h"

static const float uneven_s[] = {0.5f, 1, 2.5f, 2.75f};

static void linear_goes_straight_and_holds_at_the_ends(void **state)
{
  const float values[] = {1, 2, 3, -1, 5, 4, 0, 0, 100, 7, 7, 7};
  const char *const paths[] = {"translation", "scale"};
  for (int p = 0; p < 2; p++) {
    Scene scene;
    GltfMotion *motion = gltf_keys_open(&scene, &(Keys){paths[p], "LINEAR", "VEC3", 4, 4, uneven_s, values});
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
  GltfMotion *motion = gltf_keys_open(&scene, &(Keys){"translation", "STEP", "VEC3", 4, 4, uneven_s, values});
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
  GltfMotion *motion = gltf_keys_open(&scene, &(Keys){"translation", "CUBICSPLINE", "VEC3", 4, 12, uneven_s, **values});
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
      GltfMotion *motion = gltf_keys_open(&scene, &(Keys){"rotation", "LINEAR", "VEC4", 2, 2, uneven_s, *values});
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
  GltfMotion *motion = gltf_keys_open(&scene, &(Keys){"rotation", "CUBICSPLINE", "VEC4", 2, 6, uneven_s, **values});
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
    GltfMotion *motion = gltf_keys_open(&scene, &cases[i].keys);
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
  GltfMotion *motion = gltf_keys_open(&scene, &(Keys){"translation", "LINEAR", "VEC3", 4, 4, uneven_s, values});
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
  };
  return cmocka_run_group_tests(tests, gltf_tests_begin, gltf_tests_end);
}
