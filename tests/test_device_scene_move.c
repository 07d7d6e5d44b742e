// A scene on a device follows a host's that moves: afterwards it holds what a scene made anew holds, and says what
// moved.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/moved_scene.h"
#include "support/picture_fixture.h"

enum { FLOOR, BOX, BALL, SIGN, OBJECTS };

// A floor, a box, a ball and a sign with tangents and a normal map; a lamp and a sun.
static Scene scene_make(void)
{
  static const uint8_t bumps[4][4] = {{128, 128, 255, 255}, {140, 120, 250, 255}, {120, 140, 250, 255}, {128, 99, 250}};
  Scene scene = scene_empty();
  Material bumpy = material_plain(vec3(1, 1, 1), 0, 1);
  bumpy.normal_slot.texture = scene_add_texture(&scene, 2, 2, bumps);
  scene_add_material(&scene, material_plain(vec3(1, 0.5, 0.2), 0, 0.5));
  scene_add_material(&scene, bumpy);
  scene_add_quad(&scene, 0, vec3(-5, 0, 5), vec3(10, 0, 0), vec3(0, 0, -10));
  scene_add_box(&scene, 0, vec3(-2, 0, -1), vec3(-1, 1, 1));
  scene_add_sphere(&scene, 0, vec3(1, 1, 0), 1, 24);
  scene_add_quad(&scene, 1, vec3(-1, 2, -3), vec3(2, 0, 0), vec3(0, 1, 0));
  scene_add_light(&scene, light_point(vec3(0, 4, 0), 100));
  scene_add_light(&scene, light_directional(vec3(0.3, -1, 0.2), 2));
  Primitive *sign = &scene.meshes[scene.objects[SIGN].mesh].primitives[0];
  sign->tangents = malloc(sign->vertex_count * sizeof *sign->tangents);
  assert_non_null(sign->tangents);
  for (uint32_t i = 0; i < sign->vertex_count; i++)
    memcpy(sign->tangents[i], (float[4]){1, 0, 0, 1}, sizeof *sign->tangents);
  picture_assert_ok(scene_check_complete(&scene, &picture_log));
  return scene;
}

static Mat4 *transform_of(Scene *scene, uint32_t object) { return &scene->objects[object].world_from_object; }

static void object_shift(Scene *scene, uint32_t object, double x, double y, double z)
{
  Mat4 *m = transform_of(scene, object);
  *m = mat4_mul(mat4_from_trs(vec3(x, y, z), (double[4]){0, 0, 0, 1}, vec3(1, 1, 1)), *m);
}

static void object_scale(Scene *scene, uint32_t object, double x, double y, double z)
{
  *transform_of(scene, object) = mat4_from_trs(vec3(0.25, 1, 0), (double[4]){0, 0, 0, 1}, vec3(x, y, z));
}

static float (*mesh_positions(Scene *scene, uint32_t object))[3]
{
  return scene->meshes[scene->objects[object].mesh].primitives[0].positions;
}

static DeviceScene movable_make(const Scene *scene)
{
  DeviceScene made;
  picture_assert_ok(device_scene_make_movable(&made, picture_device(0), scene, NULL, &picture_log));
  assert_int_equal(made.mover_count, 0);
  moved_scene_assert_trees(picture_device(0), &made);
  return made;
}

// Moves, and checks everything but the movers' bounds. `objects` are the movers expected.
static void move_and_check(DeviceScene *scene, uint32_t count, const uint32_t *objects)
{
  picture_assert_ok(device_scene_move(scene, picture_device(0), NULL, &picture_log));
  assert_int_equal(scene->mover_count, count);
  for (uint32_t i = 0; i < count; i++) assert_int_equal(scene->movers[i].object, objects[i]);
  moved_scene_assert_as_new(picture_device(0), scene);
}

#define MOVE_AND_CHECK(scene, ...) \
  move_and_check(scene, sizeof((uint32_t[]){__VA_ARGS__}) / sizeof(uint32_t), (uint32_t[]){__VA_ARGS__})

static void assert_bounds(const Mover *mover, Vec3 low, Vec3 high)
{
  const double got[6] = {mover->low.x, mover->low.y, mover->low.z, mover->high.x, mover->high.y, mover->high.z};
  const double want[6] = {low.x, low.y, low.z, high.x, high.y, high.z};
  for (int i = 0; i < 6; i++)
    if (fabs(got[i] - want[i]) > 1e-6) fail_msg("object %u: bound %d is %g, not %g", mover->object, i, got[i], want[i]);
}

static uint32_t spans_named(const Timeline *timeline, const char *name)
{
  uint32_t count = 0;
  for (size_t i = 0; i < timeline->count; i++) count += strcmp(timeline->spans[i].name, name) == 0;
  return count;
}

static void moved_objects_move_and_no_others(void **state)
{
  Scene scene = scene_make();
  DeviceScene on_device = movable_make(&scene);
  for (int frame = 0; frame < 5; frame++) {
    object_shift(&scene, BOX, 0.5, 0, 0);
    MOVE_AND_CHECK(&on_device, BOX);
    assert_bounds(&on_device.movers[0], vec3(-2 + 0.5 * frame, 0, -1), vec3(-0.5 + 0.5 * frame, 1, 1));
    object_shift(&scene, BALL, 0, 0.25, 0.5);
    object_shift(&scene, SIGN, 0, 0, 1);
    MOVE_AND_CHECK(&on_device, BALL, SIGN);
    assert_bounds(&on_device.movers[0], vec3(0, 0.25 * frame, -1 + 0.5 * frame),
                  vec3(2, 2.25 + 0.25 * frame, 1.5 + 0.5 * frame));
    assert_bounds(&on_device.movers[1], vec3(-1, 2, -3 + frame), vec3(1, 3, -2 + frame));
  }
  device_scene_free(&on_device);
  scene_free(&scene);
}

// What the device's arrays hold is spoilt first: what is then written shows.
static void geometry_spoil(const DeviceScene *scene)
{
  const DeviceBuffer *buffers[] = {&scene->positions, &scene->normals, &scene->corners, &scene->bvh2_nodes,
                                   &scene->bvh2_triangles};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) {
    DeviceBuffer spoilt = *buffers[i];
    picture_assert_ok(buffer_fill_words(picture_device(0), &spoilt, 0xdeadbeef, &picture_log));
  }
}

static void assert_still_spoilt(const DeviceBuffer *buffer)
{
  uint32_t *words = buffer_copied(picture_device(0), buffer);
  for (size_t i = 0; i < buffer->bytes / sizeof *words; i++) assert_int_equal(words[i], 0xdeadbeef);
  free(words);
}

static void assert_geometry_spoilt(const DeviceScene *scene)
{
  assert_still_spoilt(&scene->positions);
  assert_still_spoilt(&scene->normals);
  assert_still_spoilt(&scene->corners);
  assert_still_spoilt(&scene->bvh2_nodes);
  assert_still_spoilt(&scene->bvh2_triangles);
}

static void where_nothing_moves_nothing_is_written(void **state)
{
  Scene scene = scene_make();
  DeviceScene on_device = movable_make(&scene);
  object_shift(&scene, BALL, 0, 1, 0);
  MOVE_AND_CHECK(&on_device, BALL);
  geometry_spoil(&on_device);
  picture_assert_ok(device_scene_move(&on_device, picture_device(0), NULL, &picture_log));
  assert_int_equal(on_device.mover_count, 0);
  assert_geometry_spoilt(&on_device);
  device_scene_free(&on_device);
  scene_free(&scene);
}

// A transform whose bits change and whose vertices do not moves nothing.
static void a_move_under_rounding_is_none(void **state)
{
  Scene scene = scene_make();
  DeviceScene on_device = movable_make(&scene);
  transform_of(&scene, BOX)->m[13] += 1e-40;
  transform_of(&scene, BALL)->m[12] += 1e-300;
  geometry_spoil(&on_device);
  picture_assert_ok(device_scene_move(&on_device, picture_device(0), NULL, &picture_log));
  assert_int_equal(on_device.mover_count, 1);  // only the box has a vertex at 0
  assert_int_equal(on_device.movers[0].object, BOX);
  device_scene_free(&on_device);
  scene_free(&scene);
}

static void lights_move_alone(void **state)
{
  Scene scene = scene_make();
  DeviceScene on_device = movable_make(&scene);
  scene.lights[0].position_world = vec3(1, 4, 1);
  scene.lights[1].intensity = 3;
  MOVE_AND_CHECK(&on_device);
  scene.lights[1].direction_world = vec3(0, -1, 0);
  geometry_spoil(&on_device);
  picture_assert_ok(device_scene_move(&on_device, picture_device(0), NULL, &picture_log));
  assert_int_equal(on_device.mover_count, 0);
  assert_geometry_spoilt(&on_device);
  assert_true(on_device.light_infos[0].position.x == 1 && on_device.light_infos[1].direction.y == -1);
  device_scene_free(&on_device);
  scene_free(&scene);
}

static void meshes_change_in_place(void **state)
{
  Scene scene = scene_make();
  DeviceScene on_device = movable_make(&scene);
  mesh_positions(&scene, BALL)[7][1] += 0.5f;
  MOVE_AND_CHECK(&on_device, BALL);

  Primitive *box = &scene.meshes[scene.objects[BOX].mesh].primitives[0];
  box->normals[3][0] = -box->normals[3][0] + 0.125f;
  geometry_spoil(&on_device);
  Timeline timeline = {0};
  picture_assert_ok(device_scene_move(&on_device, picture_device(0), &timeline, &picture_log));
  assert_int_equal(spans_named(&timeline, "refit the BVH"), 0);
  assert_int_equal(on_device.mover_count, 1);
  assert_int_equal(on_device.movers[0].object, BOX);
  assert_bounds(&on_device.movers[0], vec3(-2, 0, -1), vec3(-1, 1, 1));
  timeline_free(&timeline);
  assert_still_spoilt(&on_device.positions);  // the normals alone changed
  assert_still_spoilt(&on_device.bvh2_nodes);
  device_scene_free(&on_device);

  on_device = movable_make(&scene);
  scene.meshes[scene.objects[SIGN].mesh].primitives[0].tangents[2][3] = -1;
  MOVE_AND_CHECK(&on_device, SIGN);
  scene.objects[FLOOR].mesh = scene.objects[SIGN].mesh;  // two objects of one mesh, and tangents of both
  device_scene_free(&on_device);
  on_device = movable_make(&scene);
  mesh_positions(&scene, SIGN)[1][2] = 2;
  MOVE_AND_CHECK(&on_device, FLOOR, SIGN);
  device_scene_free(&on_device);
  scene_free(&scene);
}

// A mesh that is flattened in several parts: what changes in one of them alone is found and written there.
static void large_meshes_move_in_parts(void **state)
{
  Scene scene = scene_make();
  const uint32_t large = scene_add_sphere(&scene, 0, vec3(0, 3, 0), 2, 100);
  DeviceScene on_device = movable_make(&scene);
  const Primitive *primitive = &scene.meshes[scene.objects[large].mesh].primitives[0];
  assert_true(primitive->triangle_count > 32768);
  object_shift(&scene, large, 0, 1, 0);
  MOVE_AND_CHECK(&on_device, large);
  assert_bounds(&on_device.movers[0], vec3(-2, 1, -2), vec3(2, 6, 2));
  for (uint32_t i = 1; i < 8; i++) {
    const uint32_t vertex = primitive->triangles[i * (primitive->triangle_count - 1) / 7][0];
    primitive->positions[vertex][0] *= 0.875f;
    primitive->normals[vertex - 1][1] *= 0.5f;
    MOVE_AND_CHECK(&on_device, large);
    assert_bounds(&on_device.movers[0], vec3(-2, 2, -2), vec3(2, 6, 2));
  }
  device_scene_free(&on_device);
  scene_free(&scene);
}

static void a_vertex_goes_to_infinity_and_comes_back(void **state)
{
  static const float far[] = {INFINITY, -INFINITY, NAN};
  Scene scene = scene_make();
  DeviceScene on_device = movable_make(&scene);
  float *vertex = mesh_positions(&scene, BALL)[40], was = vertex[1];
  const uint32_t triangles = (uint32_t)on_device.bvh2_triangles.bytes;
  for (int i = 0; i < 3; i++) {
    vertex[1] = far[i];
    MOVE_AND_CHECK(&on_device, BALL);
    assert_bounds(&on_device.movers[0], vec3(0, 0, -1), vec3(2, 2, 1));
    assert_true(on_device.bvh2_triangles.bytes < triangles);
    object_shift(&scene, BALL, 0, 0, 0.5);
    MOVE_AND_CHECK(&on_device, BALL);
    vertex[1] = was;
    object_shift(&scene, BALL, 0, 0, -0.5);
    MOVE_AND_CHECK(&on_device, BALL);
    assert_int_equal(on_device.bvh2_triangles.bytes, triangles);
  }
  device_scene_free(&on_device);
  scene_free(&scene);
}

static void an_object_leaves_wholly(void **state)
{
  Scene scene = scene_make();
  DeviceScene on_device = movable_make(&scene);
  Mat4 was = *transform_of(&scene, BOX);
  transform_of(&scene, BOX)->m[12] = NAN;
  MOVE_AND_CHECK(&on_device, BOX);
  assert_bounds(&on_device.movers[0], vec3(-2, 0, -1), vec3(-1, 1, 1));
  transform_of(&scene, BOX)->m[12] = INFINITY;
  MOVE_AND_CHECK(&on_device, BOX);
  assert_true(on_device.movers[0].low.x > on_device.movers[0].high.x);
  *transform_of(&scene, BOX) = was;
  MOVE_AND_CHECK(&on_device, BOX);
  for (uint32_t o = 0; o < OBJECTS; o++) transform_of(&scene, o)->m[13] = INFINITY;
  MOVE_AND_CHECK(&on_device, FLOOR, BOX, BALL, SIGN);
  assert_true(on_device.extent_m == 0);
  device_scene_free(&on_device);
  scene_free(&scene);
}

static void scales_may_be_zero_or_mirror(void **state)
{
  static const double scales[][3] = {{1, 1, 1}, {0, 0, 0}, {-1, 1, 1},  {-1, -1, -1}, {1, 0, 1},
                                     {2, 2, 2}, {1, 1, 1}, {-1, -1, 1}, {1e-30, 1, 1}};
  Scene scene = scene_make();
  DeviceScene on_device = movable_make(&scene);
  for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
    object_scale(&scene, BALL, scales[i][0], scales[i][1], scales[i][2]);
    object_scale(&scene, SIGN, scales[i][1], scales[i][0], scales[i][2]);
    MOVE_AND_CHECK(&on_device, BALL, SIGN);
  }
  device_scene_free(&on_device);
  scene_free(&scene);
}

// A mirrored object that looks as before is moved all the same: its triangles have turned round.
static void corners_alone_make_a_mover(void **state)
{
  static const float flat[3][3] = {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Scene scene = scene_make();
  memcpy(mesh_positions(&scene, FLOOR), flat, sizeof flat);
  mesh_positions(&scene, FLOOR)[3][0] = 0;
  Primitive *floor = &scene.meshes[scene.objects[FLOOR].mesh].primitives[0];
  for (uint32_t i = 0; i < floor->vertex_count; i++) memset(floor->normals[i], 0, sizeof floor->normals[i]);
  DeviceScene on_device = movable_make(&scene);
  object_shift(&scene, FLOOR, 0, 0, 0);
  transform_of(&scene, FLOOR)->m[0] = -1;
  MOVE_AND_CHECK(&on_device, FLOOR);
  device_scene_free(&on_device);
  scene_free(&scene);
}

static void what_came_or_went_is_refused(void **state)
{
  Log log = {0};
  Scene scene = scene_make();
  DeviceScene on_device = movable_make(&scene);
  scene.meshes[scene.objects[BALL].mesh].primitives[0].triangle_count--;
  assert_int_equal(device_scene_move(&on_device, picture_device(0), NULL, &log), STATUS_FAILED);
  assert_non_null(strstr(log.error, "came or went"));
  scene.meshes[scene.objects[BALL].mesh].primitives[0].triangle_count++;
  scene.light_count--;
  assert_int_equal(device_scene_move(&on_device, picture_device(0), NULL, &log), STATUS_FAILED);
  scene.light_count++;
  device_scene_free(&on_device);
  picture_assert_ok(device_scene_make(&on_device, picture_device(0), &scene, NULL, &picture_log));
  assert_null(on_device.kept);
  log = (Log){0};
  assert_int_equal(device_scene_move(&on_device, picture_device(0), NULL, &log), STATUS_FAILED);
  assert_non_null(strstr(log.error, "not made to be moved"));
  device_scene_free(&on_device);
  scene_free(&scene);
}

// Kernels know of a scene what they look at, and are shared by scenes that differ in the rest.
static void kernels_are_told_what_they_look_at_alone(void **state)
{
  static const struct {
    uint32_t uses;
    const char *plain, *masked;  // without and with alpha MASK
  } cases[] = {
      {READS_SURFACES, "-D HAS_TEXTURES -D HAS_VERTEX_COLORS -D HAS_NORMAL_MAPS ",
       "-D HAS_TEXTURES -D HAS_VERTEX_COLORS -D HAS_NORMAL_MAPS "},
      {TESTS_MASKS | TESTS_BLENDS, "", "-D HAS_TEXTURES -D HAS_VERTEX_COLORS -D HAS_MASK "},
      {TESTS_BLENDS, "", ""},
      {TESTS_MASKS | SKIPS_SHADOWLESS, "-D HAS_SHADOWLESS ",
       "-D HAS_TEXTURES -D HAS_VERTEX_COLORS -D HAS_MASK -D HAS_SHADOWLESS "},
  };
  DeviceScene scene = {.has_textures = true, .has_colors = true, .has_normal_maps = true, .has_shadowless = true};
  char options[256];
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    for (int masks = 0; masks < 2; masks++) {
      scene.has_masks = masks;
      device_scene_options(&scene, cases[i].uses, options, sizeof options);
      assert_string_equal(options, masks ? cases[i].masked : cases[i].plain);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(kernels_are_told_what_they_look_at_alone),
      cmocka_unit_test(moved_objects_move_and_no_others),
      cmocka_unit_test(where_nothing_moves_nothing_is_written),
      cmocka_unit_test(a_move_under_rounding_is_none),
      cmocka_unit_test(lights_move_alone),
      cmocka_unit_test(meshes_change_in_place),
      cmocka_unit_test(large_meshes_move_in_parts),
      cmocka_unit_test(a_vertex_goes_to_infinity_and_comes_back),
      cmocka_unit_test(an_object_leaves_wholly),
      cmocka_unit_test(scales_may_be_zero_or_mirror),
      cmocka_unit_test(corners_alone_make_a_mover),
      cmocka_unit_test(what_came_or_went_is_refused),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
