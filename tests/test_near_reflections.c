// Reflections by lists of what is near (snapshot, candidates, mixed) against reflections by rays.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/mirrors.h"

static int glow(Scene *scene, double r, double g, double b)
{
  return scene_add_material(scene, material_glowing(vec3(r, g, b)));
}

// A mirror ball in the room, and things of many shapes about it.
static Scene things_scene(void)
{
  Scene scene = mirrors_room();
  scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0, 0, 0), 0.35, 48);
  scene_add_box(&scene, glow(&scene, 0.2, 0.9, 0.4), vec3(0.45, -0.3, 0.1), vec3(0.75, 0.1, 0.4));
  scene_add_sphere(&scene, glow(&scene, 0.9, 0.5, 0.1), vec3(-0.6, 0.1, 0.35), 0.2, 16);
  scene_add_box(&scene, glow(&scene, 0.1, 0.2, 0.9), vec3(-0.3, -0.5, -0.4), vec3(0.4, -0.42, 0.5));
  scene_add_sphere(&scene, glow(&scene, 0.7, 0.1, 0.6), vec3(0.1, 0.6, 0.3), 0.12, 24);
  scene_add_quad(&scene, glow(&scene, 0.9, 0.9, 0.2), vec3(-0.2, -0.2, 0.8), vec3(0, 0.4, 0), vec3(0.4, 0, 0));
  return scene;
}

static Camera things_camera(void)
{
  Camera camera = camera_perspective(vec3(0.9, 0.6, 1.55), vec3(0, 0, 0), 0.6);
  camera.znear_m = 1e-3;
  return camera;
}

// `radius` 0: auto.
static PictureRequest request_of(ReflectionMethod method, uint32_t side, float radius)
{
  PictureRequest request = mirrors_request(side, method, side > 96 ? 512 : 256);
  request.settings.cubes.near_radius_m = radius;
  request.settings.cubes.complex_from = 100;  // triangles: the balls, and not the boxes
  return request;
}

// Pixels that show one thing by rays and another by the method.
static size_t wrong_pixels(const Scene *scene, const Camera *camera, ReflectionMethod method, uint32_t side,
                           float radius, uint32_t lanes, size_t *even)
{
  PictureRequest by_rays = request_of(REFLECTIONS_RAYS, side, radius), by_map = request_of(method, side, radius);
  by_rays.lanes = by_map.lanes = lanes;
  Picture rays = picture_render(scene, camera, &by_rays), map = picture_render(scene, camera, &by_map);
  picture_assert_signal(&rays, 0.5);
  size_t wrong = mirrors_even_wrong(&rays, &map, 2, 2e-3, even);
  picture_free(&rays);
  picture_free(&map);
  return wrong;
}

static const ReflectionMethod methods[] = {REFLECTIONS_SNAPSHOT, REFLECTIONS_CANDIDATES, REFLECTIONS_MIXED};

static void assert_right(const Scene *scene, const Camera *camera, uint32_t side, float radius)
{
  for (uint32_t lanes = 0; lanes < 2; lanes++)
    for (int i = 0; i < 3; i++) {
      size_t even, wrong = wrong_pixels(scene, camera, methods[i], side, radius, lanes, &even);
      if (wrong || even < side * side / 3)
        fail_msg("%s, lanes %u: %zu of %zu pixels are wrong", reflections_name(methods[i]), lanes, wrong, even);
    }
}

static NearTotals totals_of(const Scene *scene, const Camera *camera, ReflectionMethod method, uint32_t side,
                            float radius)
{
  PictureRequest request = request_of(method, side, radius);
  return mirrors_near(scene, camera, &request.settings);
}

static void things_about_a_ball_are_where_rays_see_them(void **state)
{
  Scene scene = things_scene();
  Camera camera = things_camera();
  assert_right(&scene, &camera, 128, 0);
  NearTotals snapshot = totals_of(&scene, &camera, REFLECTIONS_SNAPSHOT, 128, 0);
  NearTotals candidates = totals_of(&scene, &camera, REFLECTIONS_CANDIDATES, 128, 0);
  NearTotals mixed = totals_of(&scene, &camera, REFLECTIONS_MIXED, 128, 0);
  assert_int_equal(snapshot.cubes, 1);
  assert_int_equal(candidates.snapshots, 0);
  assert_int_equal(mixed.snapshots, 2);
  assert_true(snapshot.snapshots > mixed.snapshots && snapshot.listed == candidates.listed);
  // Rays by the list where that is all, few where most is photographed; and few are left to be traced.
  assert_true(candidates.counts[NEAR_LISTED] > 500 && candidates.counts[NEAR_FAILED_SNAPSHOT] == 0);
  assert_true(snapshot.counts[NEAR_LISTED] < candidates.counts[NEAR_LISTED]);
  assert_true(snapshot.counts[NEAR_FAILED_SNAPSHOT] > 0);
  if (5 * candidates.counts[NEAR_LEFT] > candidates.rays || 3 * snapshot.counts[NEAR_LEFT] > snapshot.rays)
    fail_msg("left: candidates %u, snapshot %u of %u", (unsigned)candidates.counts[NEAR_LEFT],
             (unsigned)snapshot.counts[NEAR_LEFT], (unsigned)snapshot.rays);
  scene_free(&scene);
}

// Whole, whatever the radius cuts through: nothing is missing, and nothing is there twice.
static void the_radius_may_cut_through_anything(void **state)
{
  Scene scene = things_scene();
  Camera camera = things_camera();
  uint32_t listed = 0;
  for (int i = 0; i < 5; i++) {
    static const float radii[] = {1e-3f, 0.5f, 0.7f, 1.3f, 10};
    PictureRequest by_rays = request_of(REFLECTIONS_RAYS, 96, 0), by_map = request_of(REFLECTIONS_MIXED, 96, radii[i]);
    Picture rays = picture_render(&scene, &camera, &by_rays), map = picture_render(&scene, &camera, &by_map);
    size_t even, wrong = mirrors_even_wrong(&rays, &map, 1, 2e-3, &even);
    if (wrong) fail_msg("radius %g: %zu of %zu pixels are wrong", (double)radii[i], wrong, even);
    NearTotals totals = mirrors_near(&scene, &camera, &by_map.settings);
    assert_true(i == 0 ? totals.listed == 0 : totals.listed > listed);
    listed = totals.listed;
    picture_free(&rays);
    picture_free(&map);
  }
  scene_free(&scene);
}

// A card before a flat mirror's middle, whose back is another card: the mirror's edges show that, its middle does not.
static void a_hidden_side_is_left_to_rays(void **state)
{
  Scene scene = mirrors_room();
  scene_add_quad(&scene, mirrors_material(&scene, false), vec3(-1, -0.8, -1), vec3(2, 0, 0), vec3(0, 1.6, 0));
  scene_add_box(&scene, glow(&scene, 0.1, 0.8, 0.2), vec3(0.3, -0.3, -0.6), vec3(0.34, 0.3, 0));
  scene_add_box(&scene, glow(&scene, 0.8, 0.1, 0.2), vec3(0.341, -0.3, -0.6), vec3(0.38, 0.3, 0));
  scene_join_last(&scene);
  Camera camera = camera_perspective(vec3(1.6, 0.3, 1.4), vec3(0.3, 0, -1), 0.8);
  assert_right(&scene, &camera, 128, 0.9f);
  NearTotals totals = totals_of(&scene, &camera, REFLECTIONS_SNAPSHOT, 128, 0.9f);
  assert_int_equal(totals.snapshots, 1);
  assert_true(totals.counts[NEAR_FAILED_SNAPSHOT] > 100);
  scene_free(&scene);
}

// A card that is open to the cube's centre: from the right it shows itself, from the left what is behind it.
static void an_open_side_is_no_hole(void **state)
{
  Scene scene = mirrors_room();
  scene_add_quad(&scene, mirrors_material(&scene, false), vec3(-1, -0.8, -1), vec3(2, 0, 0), vec3(0, 1.6, 0));
  scene_add_quad(&scene, glow(&scene, 0.1, 0.8, 0.2), vec3(0.3, -0.3, -0.2), vec3(0, 0, -0.5), vec3(0, 0.6, 0));
  for (int side = -1; side < 2; side += 2) {
    Camera camera = camera_perspective(vec3(1.6 * side, 0.3, 1.4), vec3(0.3 * side, 0, -1), 0.8);
    assert_right(&scene, &camera, 128, 0.9f);
    NearTotals totals = totals_of(&scene, &camera, REFLECTIONS_SNAPSHOT, 128, 0.9f);
    assert_int_equal(totals.snapshots, 1);
    assert_true(totals.counts[NEAR_FAILED_SNAPSHOT] > 100);
  }
  scene_free(&scene);
}

// A card stands before a ball, as part of the mirror sees them, though the ball is nearer to the mirror's middle: by
// and by both leave the cube.
static void the_nearest_wins(void **state)
{
  Scene scene = mirrors_room();
  scene_add_quad(&scene, mirrors_material(&scene, false), vec3(-0.5, -0.5, -1), vec3(1, 0, 0), vec3(0, 1, 0));
  scene_add_sphere(&scene, glow(&scene, 0.1, 0.8, 0.2), vec3(0, 0, -0.6), 0.2, 24);
  scene_add_quad(&scene, glow(&scene, 0.2, 0.1, 0.9), vec3(0.3, -0.1, -0.94), vec3(0, 0, 0.15), vec3(0, 0.2, 0));
  scene.materials[scene.material_count - 1].double_sided = true;
  Camera camera = camera_perspective(vec3(1.2, 0.3, -0.2), vec3(0.2, 0, -1), 0.6);
  static const float radii[] = {0.1f, 0.25f, 0.4f, 2};
  PictureRequest by_rays = request_of(REFLECTIONS_RAYS, 128, 0);
  Picture rays = picture_render(&scene, &camera, &by_rays);
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 4; k++) {
      PictureRequest by_map = request_of(methods[i], 128, radii[k]);
      Picture map = picture_render(&scene, &camera, &by_map);
      size_t even, wrong = mirrors_even_wrong(&rays, &map, 2, 2e-3, &even);
      if (wrong || even < 4000)
        fail_msg("%s, radius %g: %zu of %zu are wrong", reflections_name(methods[i]), (double)radii[k], wrong, even);
      picture_free(&map);
    }
  picture_free(&rays);
  scene_free(&scene);
}

// By rays alone, a list of all there is finds what rays find, bit for bit.
static void a_list_of_everything_is_rays(void **state)
{
  Scene scene = things_scene();
  scene_add_light(&scene, light_point(vec3(0, 1, 1), 3));
  int plain = scene_add_material(&scene, material_plain(vec3(0.5, 0.6, 0.7), 0, 0.6));
  scene_add_sphere(&scene, plain, vec3(0.2, -0.7, 0.6), 0.2, 16);
  Camera camera = things_camera();
  PictureRequest by_rays = request_of(REFLECTIONS_RAYS, 128, 0), by_list = request_of(REFLECTIONS_CANDIDATES, 128, 100);
  for (uint32_t lanes = 0; lanes < 2; lanes++) {
    by_rays.lanes = by_list.lanes = lanes;
    Picture rays = picture_render(&scene, &camera, &by_rays), list = picture_render(&scene, &camera, &by_list);
    picture_assert_same(&rays, &list);
    picture_free(&rays);
    picture_free(&list);
  }
  scene_free(&scene);
}

// Two mirrors that face each other and reflect everything, with something between; a mirror about the whole scene.
static void mirrors_without_end_come_to_an_end(void **state)
{
  for (int kind = 0; kind < 2; kind++) {
    Scene scene = kind ? scene_empty() : mirrors_room();
    Material all = material_plain(vec3(1, 1, 1), 1, 0);
    all.double_sided = true;
    int mirror = scene_add_material(&scene, all);
    if (kind) {
      scene_add_sphere(&scene, mirror, vec3(0, 0, 0), 3, 16);
    } else {
      scene_add_quad(&scene, mirror, vec3(-1, -1, -1), vec3(2, 0, 0), vec3(0, 2, 0));
      scene_add_quad(&scene, mirror, vec3(-1, -1, 1), vec3(0, 2, 0), vec3(2, 0, 0));
    }
    scene_add_box(&scene, glow(&scene, 0.1, 0.8, 0.2), vec3(-0.2, -0.2, -0.2), vec3(0.2, 0.2, 0.2));
    Camera camera = camera_perspective(vec3(0.6, 0.3, 0.9), vec3(0, 0, -1), 0.9);
    camera.znear_m = 1e-3;
    for (int i = 0; i < 3; i++) {
      PictureRequest by_rays = request_of(REFLECTIONS_RAYS, 64, 0), by_map = request_of(methods[i], 64, 0);
      by_rays.settings.max_depth = by_map.settings.max_depth = 12;
      Picture rays = picture_render(&scene, &camera, &by_rays), map = picture_render(&scene, &camera, &by_map);
      picture_assert_signal(&map, 0.5);
      size_t even, wrong = mirrors_even_wrong(&rays, &map, 1, 0.02, &even);
      if (100 * wrong > even) fail_msg("%s, %d: %zu of %zu are wrong", reflections_name(methods[i]), kind, wrong, even);
      picture_free(&rays);
      picture_free(&map);
    }
    scene_free(&scene);
  }
}

// Ten thousand things about a mirror: lists keep to the memory allowed, say what they leave out, and the picture is one
// of numbers.
static void ten_thousand_things_keep_to_the_budget(void **state)
{
  Scene scene = scene_empty();
  scene_set_constant(&scene, 0.3, 0.4, 0.5);
  scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0, 0, 0), 0.5, 16);
  int green = glow(&scene, 0.1, 0.8, 0.2);
  for (int i = 0; i < 10000; i++) {
    Vec3 at = vec3(0.02 * (i % 100) - 1, 0.6 + 0.3 * (i / 100 % 2), 0.02 * (i / 100) - 1);
    scene_add_box(&scene, green, at, vec3_add(at, vec3(0.01, 0.01, 0.01)));
  }
  Camera camera = camera_perspective(vec3(0.5, -0.5, 3), vec3(0, 0.2, 0), 0.7);
  PictureRequest request = request_of(REFLECTIONS_SNAPSHOT, 64, 0);
  request.settings.cubes.size_px = 64;
  NearTotals all = mirrors_near(&scene, &camera, &request.settings);
  assert_int_equal(all.listed, 10000);
  assert_int_equal(all.left_out, 0);
  assert_int_equal(all.snapshots, 32);
  request.settings.cubes.max_bytes = CUBE_TEXELS(64) * 20 + 2000000;
  NearTotals some = mirrors_near(&scene, &camera, &request.settings);
  assert_true(some.listed > 1000 && some.listed < 3000);
  assert_int_equal(some.listed + some.left_out, 10000);
  Picture picture = picture_render(&scene, &camera, &request);
  picture_assert_signal(&picture, 0.3);
  picture_free(&picture);
  // Not even the reflector fits: it is traced, whole.
  request.settings.cubes.max_bytes = CUBE_TEXELS(64) * 20 + 100;
  PictureRequest by_rays = request_of(REFLECTIONS_RAYS, 64, 0);
  Picture none = picture_render(&scene, &camera, &request), rays = picture_render(&scene, &camera, &by_rays);
  picture_assert_same(&none, &rays);
  picture_free(&none);
  picture_free(&rays);
  scene_free(&scene);
}

// First by rays, deeper by lists and the other way round; and cubes deeper than lists still know what is near.
static void bounces_may_go_by_different_methods(void **state)
{
  Scene scene = things_scene();
  scene_add_quad(&scene, mirrors_material(&scene, false), vec3(-1.5, -0.8, -0.7), vec3(3, 0, 0), vec3(0, 1.6, 0));
  Camera camera = things_camera();
  static const ReflectionMethod pairs[][2] = {{REFLECTIONS_RAYS, REFLECTIONS_MIXED},
                                              {REFLECTIONS_MIXED, REFLECTIONS_RAYS},
                                              {REFLECTIONS_CANDIDATES, REFLECTIONS_SNAPSHOT},
                                              {REFLECTIONS_MIXED, REFLECTIONS_IMPOSTOR}};
  PictureRequest by_rays = request_of(REFLECTIONS_RAYS, 96, 0), once = by_rays;
  once.settings.max_depth = 1;
  Picture rays = picture_render(&scene, &camera, &by_rays), first = picture_render(&scene, &camera, &once);
  size_t even, deep = mirrors_even_wrong(&rays, &first, 1, 0.02, &even);
  assert_true(deep > 100);
  for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
    PictureRequest by_map = request_of(pairs[i][0], 96, 0);
    by_map.settings.deep_reflections = pairs[i][1];
    Picture map = picture_render(&scene, &camera, &by_map);
    size_t wrong = mirrors_even_wrong(&rays, &map, 1, 0.02, &even);
    if (50 * wrong > even)
      fail_msg("%s, %s: %zu of %zu are wrong", reflections_name(pairs[i][0]), reflections_name(pairs[i][1]), wrong,
               even);
    picture_free(&map);
  }
  picture_free(&rays);
  picture_free(&first);
  scene_free(&scene);
}

// In phong, whose reflectance is the same at all angles.
static PictureRequest faint_request(ReflectionMethod method, uint32_t depth)
{
  PictureRequest request = request_of(method, 96, 1e-3f);
  request.settings.lighting = LIGHTING_PHONG;
  request.settings.max_depth = depth;
  return request;
}

// How many rays of the second bounce the cubes leave, and how many there are, between mirrors of a reflectance.
static void deep_rays(uint64_t *left, uint64_t *all, const Scene *scene)
{
  Camera camera = things_camera();
  NearTotals totals[2];
  for (uint32_t i = 0; i < 2; i++) {
    PictureRequest request = faint_request(REFLECTIONS_CANDIDATES, i + 1);
    totals[i] = mirrors_near(scene, &camera, &request.settings);
  }
  *left = totals[1].counts[NEAR_LEFT] - totals[0].counts[NEAR_LEFT];
  *all = totals[1].rays - totals[0].rays;
}

static Scene facing_scene(double reflectance)
{
  Scene scene = things_scene();
  int mirror = scene_add_material(&scene, material_plain(vec3(reflectance, reflectance, reflectance), 1, 0));
  scene_add_quad(&scene, mirror, vec3(-1.5, -0.8, -0.7), vec3(3, 0, 0), vec3(0, 1.6, 0));
  for (uint32_t i = 0; i < scene.material_count; i++)
    for (int c = 0; c < 3; c++) {
      scene.materials[i].emission[c] *= 0.1f;
      if (scene.materials[i].roughness == 0) scene.materials[i].base_color[c] = (float)reflectance;
    }
  return scene;
}

// Where what a second bounce adds is hardly seen, the cube answers it whole, without a ray; and that is hardly seen.
static void faint_bounces_end_in_the_cube(void **state)
{
  uint64_t left, all;
  Scene bright = facing_scene(0.9), faint = facing_scene(0.065);
  deep_rays(&left, &all, &bright);
  if (all < 200 || 20 * left < all) fail_msg("bright: %u of %u rays are left", (unsigned)left, (unsigned)all);
  deep_rays(&left, &all, &faint);
  if (all < 200 || 100 * left > all) fail_msg("faint: %u of %u rays are left", (unsigned)left, (unsigned)all);
  Camera camera = things_camera();
  PictureRequest by_rays = faint_request(REFLECTIONS_RAYS, 2), by_map = faint_request(REFLECTIONS_CANDIDATES, 2);
  Picture rays = picture_render(&faint, &camera, &by_rays), map = picture_render(&faint, &camera, &by_map);
  by_rays.settings.max_depth = by_map.settings.max_depth = 1;
  Picture rays_once = picture_render(&faint, &camera, &by_rays), map_once = picture_render(&faint, &camera, &by_map);
  double error = 0, added = 0;
  size_t shown = 0;
  for (size_t i = 0; i < 96 * 96; i++) {
    double deep = (double)rays.radiance[i][0] - (double)rays_once.radiance[i][0];
    if (deep == 0) continue;
    error += fabs((double)map.radiance[i][0] - (double)map_once.radiance[i][0] - deep);
    added += deep;
    shown++;
  }
  assert_true(shown > 200 && added > 0);
  if (!(error / (double)shown < 1.0 / 255))
    fail_msg("%g on average, of %g", error / (double)shown, added / (double)shown);
  picture_free(&rays);
  picture_free(&map);
  picture_free(&rays_once);
  picture_free(&map_once);
  scene_free(&bright);
  scene_free(&faint);
}

static void the_bytes_do_not_hang_on_the_waves(void **state)
{
  Scene scene = things_scene();
  scene_add_light(&scene, light_point(vec3(0, 1, 1), 3));
  scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0.5, 0.45, -0.2), 0.25, 32);
  Camera camera = things_camera();
  for (int i = 0; i < 3; i++) {
    PictureRequest request = request_of(methods[i], 64, 0);
    request.settings.cubes.size_px = 64;
    mirrors_assert_same_in_waves(&scene, &camera, &request);
  }
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(things_about_a_ball_are_where_rays_see_them),
      cmocka_unit_test(the_radius_may_cut_through_anything),
      cmocka_unit_test(a_hidden_side_is_left_to_rays),
      cmocka_unit_test(an_open_side_is_no_hole),
      cmocka_unit_test(the_nearest_wins),
      cmocka_unit_test(a_list_of_everything_is_rays),
      cmocka_unit_test(mirrors_without_end_come_to_an_end),
      cmocka_unit_test(ten_thousand_things_keep_to_the_budget),
      cmocka_unit_test(bounces_may_go_by_different_methods),
      cmocka_unit_test(faint_bounces_end_in_the_cube),
      cmocka_unit_test(the_bytes_do_not_hang_on_the_waves),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
