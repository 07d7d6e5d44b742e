// Which objects are left out of a cube map and listed, and how each is found: rules, without a device.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "plan/cube_error.h"
#include "plan/near_list.h"
#include "scene/scene_build.h"

static Log test_log;

static NearList list_of(const Scene *scene, uint32_t reflector, double radius_m, uint64_t triangles_most,
                        ReflectionMethod reflections)
{
  ObjectFacts *facts;
  NearList list;
  assert_int_equal(object_facts_make(&facts, scene, &test_log), STATUS_OK);
  assert_int_equal(near_list_make(&list, scene, facts, reflector, vec3(0, 0, 0), radius_m, triangles_most, &test_log),
                   STATUS_OK);
  near_list_choose(&list, facts, vec3(0, 0, 0), reflections, 100);
  free(facts);
  return list;
}

static const NearObject *listed(const NearList *list, uint32_t object)
{
  for (uint32_t i = 0; i < list->count; i++)
    if (list->objects[i].object == object) return &list->objects[i];
  return NULL;
}

enum { BALL, ROOM, INSIDE, STRADDLES, CORNER, FAR_AWAY, FAR_MIRROR, GLASS, AROUND, ROUND };

// By number as above; a radius of 1 is the one of interest.
static Scene things_scene(void)
{
  Scene scene = scene_empty();
  int plain = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  int mirror = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 1, 0));
  Material glass = material_plain(vec3(1, 1, 1), 0, 1);
  glass.alpha_mode = ALPHA_BLEND;
  int blend = scene_add_material(&scene, glass);
  scene_add_sphere(&scene, mirror, vec3(0, 0, 0), 0.1, 8);
  scene_add_box(&scene, plain, vec3(-3, -3, -3), vec3(3, 3, 3));
  scene_add_box(&scene, plain, vec3(0.3, -0.1, -0.1), vec3(0.5, 0.1, 0.1));
  scene_add_box(&scene, plain, vec3(-0.2, 0.8, -0.2), vec3(0.2, 1.4, 0.2));
  // Its bounds come within 0.8, its surface does not.
  scene_add_triangle(&scene, plain, (const Vec3[3]){{0.5, 0.5, 2}, {2, 0.5, 0.5}, {0.5, 2, 0.5}},
                     (const Vec3[3]){{1, 0, 0}, {1, 0, 0}, {1, 0, 0}});
  scene_add_box(&scene, plain, vec3(-0.2, -2, -0.2), vec3(0.2, -1.5, 0.2));
  scene_add_sphere(&scene, mirror, vec3(0, 0, 2.5), 0.3, 8);
  scene_add_box(&scene, blend, vec3(-0.6, -0.1, -0.1), vec3(-0.4, 0.1, 0.1));
  scene_add_box(&scene, plain, vec3(-0.5, -0.4, -0.5), vec3(0.5, -0.3, 0.5));
  scene_add_sphere(&scene, plain, vec3(0, 0, -0.6), 0.2, 16);
  return scene;
}

static void what_has_surface_within_the_radius_is_listed_whole(void **state)
{
  Scene scene = things_scene();
  NearList list = list_of(&scene, BALL, 1, UINT64_MAX, REFLECTIONS_CANDIDATES);
  static const bool near[] = {false, false, true, true, false, false, true, true, true, true};
  for (uint32_t i = 0; i < sizeof near; i++)
    if (near[i] != (listed(&list, i) != NULL)) fail_msg("object %u is %s", i, near[i] ? "missing" : "listed");
  for (uint32_t i = 1; i < list.count; i++) assert_true(list.objects[i - 1].distance_m <= list.objects[i].distance_m);
  for (uint32_t i = 0; i < list.count; i++) assert_int_equal(list.objects[i].method, NEAR_BY_RAYS);
  near_list_free(&list);
  // A wall of the room is 3 away, its corners farther.
  list = list_of(&scene, BALL, 3.01, UINT64_MAX, REFLECTIONS_CANDIDATES);
  assert_non_null(listed(&list, ROOM));
  assert_non_null(listed(&list, CORNER));
  near_list_free(&list);
  scene_free(&scene);
}

static void each_is_found_by_its_own_method(void **state)
{
  Scene scene = things_scene();
  NearList list = list_of(&scene, BALL, 1, UINT64_MAX, REFLECTIONS_SNAPSHOT);
  assert_int_equal(listed(&list, INSIDE)->method, NEAR_BY_SNAPSHOT);
  assert_int_equal(listed(&list, STRADDLES)->method, NEAR_BY_SNAPSHOT);
  assert_int_equal(listed(&list, ROUND)->method, NEAR_BY_SNAPSHOT);
  assert_int_equal(listed(&list, FAR_MIRROR)->reason, NEAR_MIRROR);
  assert_int_equal(listed(&list, GLASS)->reason, NEAR_BLEND);
  assert_int_equal(listed(&list, AROUND)->reason, NEAR_TOO_WIDE);
  for (uint32_t i = 0; i < list.count; i++)
    assert_int_equal(list.objects[i].method == NEAR_BY_SNAPSHOT, list.objects[i].reason == NEAR_AS_ASKED);
  near_list_free(&list);
  // From 100 triangles on.
  list = list_of(&scene, BALL, 1, UINT64_MAX, REFLECTIONS_MIXED);
  for (uint32_t i = 0; i < list.count; i++)
    assert_int_equal(list.objects[i].method, list.objects[i].object == ROUND ? NEAR_BY_SNAPSHOT : NEAR_BY_RAYS);
  assert_int_equal(listed(&list, FAR_MIRROR)->reason, NEAR_MIRROR);
  near_list_free(&list);
  scene_free(&scene);
}

// Ten thousand: the nearest are kept, and of those the nearest are photographed.
static void what_is_over_the_limit_is_counted(void **state)
{
  Scene scene = scene_empty();
  int plain = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  scene_add_sphere(&scene, plain, vec3(0, 0, 0), 0.1, 8);
  for (int i = 0; i < 10000; i++) {
    Vec3 at = vec3(0.5 + 1e-5 * (9999 - i), 0, 0);
    scene_add_box(&scene, plain, at, vec3_add(at, vec3(1e-3, 1e-3, 1e-3)));
  }
  NearList list = list_of(&scene, 0, 1, 12 * 1000 + 5, REFLECTIONS_SNAPSHOT);
  assert_int_equal(list.count, 1000);
  assert_int_equal(list.left_out, 9000);
  for (uint32_t i = 0; i < list.count; i++) {
    assert_int_equal(list.objects[i].object, 10000 - i);
    assert_int_equal(list.objects[i].reason, i < SNAPSHOTS_MOST ? NEAR_AS_ASKED : NEAR_CROWDED);
  }
  near_list_free(&list);
  scene_free(&scene);
}

// Every corner is within it, and one of them at its edge on either axis at most half the picture's excess away.
static void a_frustum_holds_the_whole_object(void **state)
{
  const Vec3 eye = vec3(0.2, -0.1, 0.4);
  for (int i = 0; i < 200; i++) {
    double a = 0.7 * i, b = 0.31 * i;
    Vec3 middle = vec3_add(eye, vec3(2 * cos(a) * cos(b), 2 * sin(b), 2 * sin(a) * cos(b)));
    Vec3 half = vec3(0.1 + 0.01 * (i % 30), 0.2, 0.1 + 0.02 * (i % 13));
    SnapshotFrustum f;
    assert_true(snapshot_frustum_fit(&f, eye, vec3_sub(middle, half), vec3_add(middle, half)));
    assert_true(fabs(vec3_dot(f.right, f.down)) < 1e-12 && fabs(vec3_dot(f.right, f.forward)) < 1e-12);
    assert_true(vec3_length(vec3_sub(vec3_cross(f.right, f.down), f.forward)) < 1e-12);
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (int corner = 0; corner < 8; corner++) {
      Vec3 sign = vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      Vec3 to = vec3_sub(vec3_add(middle, vec3_mul(sign, half)), eye);
      double depth = vec3_dot(to, f.forward), x = vec3_dot(to, f.right) / depth, y = vec3_dot(to, f.down) / depth;
      assert_true(depth > 0 && depth <= f.beyond_m * (1 + 1e-12));
      low[0] = fmin(low[0], x - f.left);
      low[1] = fmin(low[1], y - f.top);
      high[0] = fmax(high[0], x - f.left);
      high[1] = fmax(high[1], y - f.top);
    }
    for (int axis = 0; axis < 2; axis++) assert_true(low[axis] > -1e-12 && high[axis] < f.width + 1e-12);
    assert_true(fmax(high[0] - low[0], high[1] - low[1]) > f.width - 1e-9);
  }
  SnapshotFrustum f;
  assert_false(snapshot_frustum_fit(&f, eye, vec3(-1, -1, -1), vec3(1, 1, 1)));  // about it
  assert_false(snapshot_frustum_fit(&f, eye, eye, eye));
  assert_false(snapshot_frustum_fit(&f, eye, vec3(-5, -5, 1), vec3(5, 5, 1.1)));  // a wall before it
}

static void the_radius_is_where_parallax_is_as_allowed(void **state)
{
  for (double most = 0.05; most < 1.5; most += 0.1) {
    double radius = cube_near_radius_m(0.7, most);
    assert_true(fabs(cube_parallax_most_rad(0.7, radius) - most) < 1e-9);
    assert_true(cube_parallax_most_rad(0.7, 1.01 * radius) < most);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_has_surface_within_the_radius_is_listed_whole),
      cmocka_unit_test(each_is_found_by_its_own_method),
      cmocka_unit_test(what_is_over_the_limit_is_counted),
      cmocka_unit_test(a_frustum_holds_the_whole_object),
      cmocka_unit_test(the_radius_is_where_parallax_is_as_allowed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
