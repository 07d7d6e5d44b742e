// Reflections by maps against reflections by rays, which test_picture_mirrors.c holds to closed forms.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/mirrors.h"
#include "support/oracle_camera.h"

// ---- the environment ------------------------------------------------------------------------------------------------

static void a_mirror_in_the_sky_is_the_same_by_environment_and_by_rays(void **state)
{
  static const uint32_t widths[] = {0, 8, 1};
  Scene scene = scene_empty();
  mirrors_sky(&scene);
  scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0, 0, 0), 1, 24);
  Camera camera = camera_perspective(vec3(1, 2, 4), vec3(0, 0, 0), 0.6);
  for (int i = 0; i < 3; i++) {
    PictureRequest by_rays = mirrors_request(48, REFLECTIONS_RAYS, 0),
                   by_map = mirrors_request(48, REFLECTIONS_ENVIRONMENT, 0);
    by_rays.lanes = by_map.lanes = widths[i];
    Picture rays = picture_render(&scene, &camera, &by_rays), map = picture_render(&scene, &camera, &by_map);
    picture_assert_signal(&rays, 0.5);
    picture_assert_same(&rays, &map);
    picture_free(&rays);
    picture_free(&map);
  }
  scene_free(&scene);
}

// Bilinear interpolation is off by s^2 / 8 times the second derivative along each of two axes; a texel of n a face is
// at most 2 / (n - 1) radians wide. The sky's image is off by as much at its own, much smaller texels.
// Hybrid shadows look for receivers, in mirrors too, before there is any map.
static void shadows_may_be_hybrid_where_mirrors_show_the_environment(void **state)
{
  Scene scene = scene_empty();
  mirrors_sky(&scene);
  scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0, 0, 0), 1, 24);
  scene_add_quad(&scene, scene_add_material(&scene, material_plain(vec3(0.5, 0.5, 0.5), 0, 0.5)), vec3(-3, -1, -3),
                 vec3(0, 0, 6), vec3(6, 0, 0));
  scene_add_light(&scene, light_directional(vec3(-1, -2, -1), 3));
  Camera camera = camera_perspective(vec3(1, 2, 4), vec3(0, 0, 0), 0.6);
  PictureRequest request = mirrors_request(48, REFLECTIONS_ENVIRONMENT, 0);
  Picture rays = picture_render(&scene, &camera, &request);
  request.settings.shadows = SHADOWS_HYBRID;
  Picture hybrid = picture_render(&scene, &camera, &request);
  picture_assert_signal(&rays, 0.5);
  picture_assert_same(&rays, &hybrid);
  picture_free(&rays);
  picture_free(&hybrid);
  scene_free(&scene);
}

static void a_cube_of_the_sky_is_off_by_no_more_than_interpolation(void **state)
{
  Scene scene = scene_empty();
  mirrors_sky(&scene);
  scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0, 0, 0), 1, 24);
  Camera camera = camera_perspective(vec3(1, 2, 4), vec3(0, 0, 0), 0.6);
  static const ReflectionMethod methods[] = {REFLECTIONS_CUBE, REFLECTIONS_IMPOSTOR, REFLECTIONS_CANDIDATES};
  for (int i = 0; i < 3; i++)
    for (uint32_t size = 16; size <= 64; size *= 2) {
      const ReflectionMethod method = methods[i];
      PictureRequest by_rays = mirrors_request(48, REFLECTIONS_RAYS, 0), by_map = mirrors_request(48, method, size);
      Picture rays = picture_render(&scene, &camera, &by_rays), map = picture_render(&scene, &camera, &by_map);
      double texel = 2.0 / (size - 1), bound = 2 * texel * texel / 8 + 1e-4, most = 0;
      for (size_t k = 0; k < 48 * 48; k++) most = fmax(most, mirrors_difference(&rays, &map, k));
      if (!(most <= bound)) fail_msg("%s, %u texels: %g, over %g", reflections_name(method), size, most, bound);
      if (!(most > 0)) fail_msg("%s: no cube was asked", reflections_name(method));
      picture_free(&rays);
      picture_free(&map);
    }
  scene_free(&scene);
}

// ---- seams ----------------------------------------------------------------------------------------------------------

static int face_of(Vec3 d)
{
  double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
  if (x >= y && x >= z) return d.x < 0;
  if (y >= z) return 2 + (d.y < 0);
  return 4 + (d.z < 0);
}

// A flat mirror of which a wide view shows several faces of a coarse cube, turned by and by: from a pixel to the next
// the map's error changes no more over an edge than within a face.
static void faces_meet_without_a_seam(void **state)
{
  enum { SIDE = 96, TURNS = 5 };
  double across = 0, within = 0;
  size_t crossed = 0;
  for (int turn = 0; turn < TURNS; turn++) {
    Scene scene = scene_empty();
    mirrors_sky(&scene);
    double angle = 0.3 * turn, c = cos(angle), s = sin(angle);
    const Vec3 u = {c, 0, -s}, v = {0, 1, 0}, n = {s, 0, c};
    Vec3 corner = vec3_scale(vec3_add(u, v), -30);
    scene_add_quad(&scene, mirrors_material(&scene, false), corner, vec3_scale(u, 60), vec3_scale(v, 60));
    Camera camera = camera_perspective(vec3_scale(n, 2), vec3(0, 0, 0), 1.9);
    PictureRequest by_map = mirrors_request(SIDE, REFLECTIONS_CUBE, 16),
                   by_rays = mirrors_request(SIDE, REFLECTIONS_RAYS, 0);
    Picture rays = picture_render(&scene, &camera, &by_rays), map = picture_render(&scene, &camera, &by_map);
    for (size_t i = 0; i + 1 < SIDE * SIDE; i++) {
      if (i % SIDE + 1 == SIDE) continue;
      int faces[2];
      for (size_t k = 0; k < 2; k++) {
        Vec3 d = oracle_camera_ray(&camera, SIDE, SIDE, (i + k) % SIDE + 0.5, i / SIDE + 0.5).direction;
        faces[k] = face_of(vec3_sub(d, vec3_scale(n, 2 * vec3_dot(d, n))));
      }
      double jump = 0;
      for (int channel = 0; channel < 3; channel++) {
        double here = (double)map.radiance[i][channel] - (double)rays.radiance[i][channel];
        double next = (double)map.radiance[i + 1][channel] - (double)rays.radiance[i + 1][channel];
        jump = fmax(jump, fabs(next - here));
      }
      crossed += faces[0] != faces[1];
      if (faces[0] != faces[1]) across = fmax(across, jump);
      if (faces[0] == faces[1]) within = fmax(within, jump);
    }
    picture_free(&rays);
    picture_free(&map);
    scene_free(&scene);
  }
  assert_true(crossed > SIDE && within > 1e-4);
  if (!(across <= within)) fail_msg("%g across edges, %g within faces", across, within);
}

// ---- in a room ------------------------------------------------------------------------------------------------------

// A mirror ball of `radius` in the room, by a method and by rays: pixels that differ, of those that show one wall.
static void room_compare(size_t *wrong, size_t *even, ReflectionMethod method, uint32_t lanes, double radius,
                         bool double_sided, Vec3 center)
{
  Scene scene = mirrors_room();
  scene_add_sphere(&scene, mirrors_material(&scene, double_sided), center, radius, 64);
  Vec3 eye = vec3_add(center, vec3_scale(vec3(0.5, 0.4, 1), 4 * radius));
  Camera camera = camera_perspective(eye, center, 0.5);
  camera.znear_m = radius / 100;
  PictureRequest by_rays = mirrors_request(96, REFLECTIONS_RAYS, 0), by_map = mirrors_request(96, method, 256);
  by_rays.lanes = by_map.lanes = lanes;
  Picture rays = picture_render(&scene, &camera, &by_rays), map = picture_render(&scene, &camera, &by_map);
  picture_assert_signal(&rays, 0.5);
  *wrong = mirrors_even_wrong(&rays, &map, 1, 1e-4, even);
  picture_free(&rays);
  picture_free(&map);
  scene_free(&scene);
}

// Seen from its centre everything is where the cube shows it: away from edges not a pixel differs, whether the ball's
// own inside must be passed or not.
static void a_reflector_as_small_as_a_point_is_exact(void **state)
{
  size_t wrong, even;
  for (ReflectionMethod method = REFLECTIONS_CUBE; method <= REFLECTIONS_MIXED; method++)
    for (int double_sided = 0; double_sided < 2; double_sided++) {
      room_compare(&wrong, &even, method, 0, 1e-3, double_sided, vec3(0, 0, 0));
      if (wrong || even < 5000) fail_msg("%s: %zu of %zu pixels are wrong", reflections_name(method), wrong, even);
    }
}

// A large ball off the middle of the room: with the distances of the walls, or the box that they are, none differs;
// without, those do that show another wall.
static void the_box_and_the_impostor_know_where_the_walls_are(void **state)
{
  size_t wrong, even;
  const Vec3 center = vec3(0.7, 0.2, -0.5);
  for (uint32_t lanes = 0; lanes < 2; lanes++)
    for (ReflectionMethod method = REFLECTIONS_BOX; method <= REFLECTIONS_MIXED; method++) {
      room_compare(&wrong, &even, method, lanes, 0.6, false, center);
      if (wrong || even < 5000) fail_msg("%s: %zu of %zu pixels are wrong", reflections_name(method), wrong, even);
    }
  room_compare(&wrong, &even, REFLECTIONS_CUBE, 0, 0.6, false, center);
  if (wrong < 100) fail_msg("cube: only %zu of %zu pixels are wrong", wrong, even);
}

// ---- the impostor's hit point ---------------------------------------------------------------------------------------

static bool sphere_is_hit(OracleRay ray, Vec3 center, double radius)
{
  Vec3 to = vec3_sub(center, ray.origin), d = vec3_unit_or(ray.direction, vec3(0, 0, 1));
  double along = vec3_dot(to, d);
  return along > 0 && vec3_dot(to, to) - along * along < radius * radius;
}

// A ball over a flat mirror shows where its mirror image is, behind the mirror. The cube at infinity has it elsewhere.
static void the_impostor_shows_a_ball_where_its_mirror_image_is(void **state)
{
  enum { SIDE = 128 };
  static const double radius = 0.4, margin = 0.02;  // the ball is a polyhedron: 1 - cos(pi / 2 / 48) of the radius
  const Vec3 image = vec3(0.5, -0.3, -1.2);
  Scene scene = scene_empty();
  scene_add_quad(&scene, mirrors_material(&scene, false), vec3(-2, -2, 0), vec3(4, 0, 0), vec3(0, 4, 0));
  scene_add_sphere(&scene, scene_add_material(&scene, material_glowing(vec3(2, 2, 2))), vec3(0.5, -0.3, 1.2), radius,
                   48);
  Camera camera = camera_perspective(vec3(-2.5, 1, 3), vec3(0, 0, 0), 0.5);
  for (ReflectionMethod method = REFLECTIONS_CUBE; method <= REFLECTIONS_RAYS; method++) {
    PictureRequest request = mirrors_request(SIDE, method, 128);
    Picture picture = picture_render(&scene, &camera, &request);
    size_t wrong = 0, shown = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
      OracleRay ray = oracle_camera_ray(&camera, SIDE, SIDE, i % SIDE + 0.5, i / SIDE + 0.5);
      bool inside = sphere_is_hit(ray, image, radius - margin), near = sphere_is_hit(ray, image, radius + margin);
      if (picture.radiance[i][3] == 0 || inside != near || sphere_is_hit(ray, vec3(0.5, -0.3, 1.2), radius + margin))
        continue;
      shown += inside;
      wrong += inside != (picture.radiance[i][0] > 0.5f);
    }
    assert_true(shown > 300);
    bool exact = method >= REFLECTIONS_IMPOSTOR;
    if (exact != (wrong == 0)) fail_msg("%s: %zu pixels are wrong", reflections_name(method), wrong);
    picture_free(&picture);
  }
  scene_free(&scene);
}

// ---- what has no map ------------------------------------------------------------------------------------------------

static Scene balls_scene(int across, double radius)
{
  Scene scene = mirrors_room();
  int mirror = mirrors_material(&scene, false);
  for (int i = 0; i < across * across; i++)
    scene_add_sphere(&scene, mirror,
                     vec3((i % across + 0.5) * 2.0 / across - 1, (i / across + 0.5) * 2.0 / across - 1, 0), radius, 4);
  return scene;
}

// A thousand reflectors: as many maps as fit into the memory allowed, the largest on screen first; the others are
// traced.
static void a_thousand_reflectors_keep_to_the_budget(void **state)
{
  Scene scene = balls_scene(32, 0.02);
  Camera camera = camera_perspective(vec3(0, 0, 1.65), vec3(0, 0, 0), 1.5);
  RenderSettings settings = mirrors_request(256, REFLECTIONS_CUBE, 0).settings;
  settings.cubes.max_bytes = 10 * CUBE_TEXELS(32) * 16;
  ReflectorSummary summary = mirrors_summary(&scene, &camera, &settings);
  assert_int_equal(summary.visible, 1024);
  assert_int_equal(summary.left_out, 1014);
  assert_int_equal(summary.bytes, settings.cubes.max_bytes);
  assert_int_equal(summary.least_px, 32);
  scene_free(&scene);
}

// Without memory for maps the picture is that of rays.
static void what_has_no_map_is_traced(void **state)
{
  Scene scene = balls_scene(2, 0.4);
  Camera camera = camera_perspective(vec3(0.3, 0, 1.65), vec3(0, 0, 0), 1.5);
  PictureRequest by_rays = mirrors_request(64, REFLECTIONS_RAYS, 0), by_map = mirrors_request(64, REFLECTIONS_CUBE, 64);
  by_rays.settings.max_depth = by_map.settings.max_depth = 1;
  Picture rays = picture_render(&scene, &camera, &by_rays), some, none;
  by_map.settings.cubes.max_bytes = 1;
  none = picture_render(&scene, &camera, &by_map);
  picture_assert_same(&rays, &none);
  by_map.settings.cubes.max_bytes = CUBE_TEXELS(64) * 16;  // of four
  some = picture_render(&scene, &camera, &by_map);
  size_t different = 0;
  for (size_t i = 0; i < 64 * 64; i++) different += mirrors_difference(&rays, &some, i) > 0;
  if (different < 20 || different > 64 * 64 / 3) fail_msg("%zu pixels differ", different);
  picture_free(&rays);
  picture_free(&none);
  picture_free(&some);
  scene_free(&scene);
}

// The camera at the centre of a reflector, a reflector within another, one without area, one at which nobody looks, a
// scene in which all is a mirror: pictures come out, of numbers.
static void odd_reflectors_make_pictures(void **state)
{
  for (ReflectionMethod method = REFLECTIONS_ENVIRONMENT; method <= REFLECTIONS_MIXED; method++)
    for (int i = 0; i < 5; i++) {
      Scene scene = i == 4 ? scene_empty() : mirrors_room();
      int mirror = mirrors_material(&scene, true);
      if (i == 0 || i == 1) scene_add_sphere(&scene, mirror, vec3(0, 0, 0), 0.5, 8);
      if (i == 1) scene_add_sphere(&scene, mirror, vec3(0, 0, 0), 0.25, 8);
      if (i == 2) scene_add_quad(&scene, mirror, vec3(-1, 0, 0), vec3(2, 0, 0), vec3(0, 0, 0));
      if (i == 3) scene_add_quad(&scene, mirror, vec3(-1, -1, 1.5), vec3(2, 0, 0), vec3(0, 2, 0));
      if (i == 4) scene_add_box(&scene, mirror, vec3(-1, -1, -1), vec3(1, 1, 1));
      Camera camera = camera_perspective(vec3(0, 0, i == 2 ? 1.5 : 0), vec3(0, 0.1, -1), 1);
      camera.znear_m = 1e-3;
      PictureRequest request = mirrors_request(32, method, 16);
      Picture picture = picture_render(&scene, &camera, &request);
      for (size_t k = 0; k < 32 * 32; k++)
        for (int c = 0; c < 4; c++) assert_true(isfinite(picture.radiance[k][c]) && picture.radiance[k][c] >= 0);
      picture_free(&picture);
      scene_free(&scene);
    }
}

// With rays first and nothing deeper, one reflection is all there is.
static void deeper_bounces_may_be_left_out(void **state)
{
  Scene scene = balls_scene(2, 0.4);
  Camera camera = camera_perspective(vec3(0.3, 0, 1.65), vec3(0, 0, 0), 1.5);
  PictureRequest once = mirrors_request(64, REFLECTIONS_RAYS, 0), all = once, deep = once;
  once.settings.max_depth = 1;
  deep.settings.deep_reflections = REFLECTIONS_NONE;
  Picture by_depth = picture_render(&scene, &camera, &once), by_method = picture_render(&scene, &camera, &deep);
  Picture whole = picture_render(&scene, &camera, &all);
  picture_assert_same(&by_depth, &by_method);
  // The first bounce by rays, deeper ones by maps: no closer to the first alone than to all of them.
  deep.settings.deep_reflections = REFLECTIONS_IMPOSTOR;
  Picture mixed = picture_render(&scene, &camera, &deep);
  double from_once = 0, from_all = 0;
  for (size_t i = 0; i < 64 * 64; i++) {
    from_once += mirrors_difference(&mixed, &by_depth, i);
    from_all += mirrors_difference(&mixed, &whole, i);
  }
  if (!(from_all < 0.25 * from_once && from_all > 0)) fail_msg("%g from all, %g from one", from_all, from_once);
  picture_free(&by_depth);
  picture_free(&by_method);
  picture_free(&whole);
  picture_free(&mixed);
  scene_free(&scene);
}

// ---- how cubes see --------------------------------------------------------------------------------------------------

// By raster as by rays, whether a wave holds many bins or part of one: the least face is smaller than a bin. Rays that
// pass the reflector start anew behind it, so that what they carry is rounded otherwise.
static void cubes_seen_by_raster_are_those_seen_by_rays(void **state)
{
  static const uint32_t sizes[] = {32, 72, 128};
  Scene scene = balls_scene(5, 0.3);
  Camera camera = camera_perspective(vec3(0.3, 0, 1.65), vec3(0, 0, 0), 1.5);
  scene_add_light(&scene, light_point(vec3(0, 1, 1), 10));
  for (uint32_t lanes = 0; lanes < 2; lanes++)
    for (int i = 0; i < 3; i++) {
      PictureRequest request = mirrors_request(128, REFLECTIONS_IMPOSTOR, sizes[i]);
      request.lanes = lanes;
      request.wave_rays = i == 2 ? 3 * 64 : 0;
      request.settings.primary = PRIMARY_RAYS;
      Picture rays = picture_render(&scene, &camera, &request);
      request.settings.primary = PRIMARY_RASTER;
      Picture raster = picture_render(&scene, &camera, &request);
      double most = 0;
      picture_assert_signal(&rays, 0.05);
      for (size_t at = 0; at < 128 * 128; at++) most = fmax(most, mirrors_difference(&rays, &raster, at));
      if (!(most < 2e-5)) fail_msg("%u texels, %u lanes: %g apart", sizes[i], lanes, most);
      picture_free(&rays);
      picture_free(&raster);
    }
  scene_free(&scene);
}

// ---- always the same ------------------------------------------------------------------------------------------------

// However many rays are in flight, and on every run.
static void the_bytes_do_not_hang_on_the_waves(void **state)
{
  static const ReflectionMethod methods[] = {REFLECTIONS_IMPOSTOR, REFLECTIONS_HYBRID};
  Scene scene = balls_scene(3, 0.25);
  scene_add_light(&scene, light_point(vec3(0, 1, 1), 10));
  Camera camera = camera_perspective(vec3(0.3, 0, 1.65), vec3(0, 0, 0), 1.5);
  for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) {
    PictureRequest request = mirrors_request(64, methods[i], 64);
    mirrors_assert_same_in_waves(&scene, &camera, &request);
  }
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_mirror_in_the_sky_is_the_same_by_environment_and_by_rays),
      cmocka_unit_test(shadows_may_be_hybrid_where_mirrors_show_the_environment),
      cmocka_unit_test(a_cube_of_the_sky_is_off_by_no_more_than_interpolation),
      cmocka_unit_test(faces_meet_without_a_seam),
      cmocka_unit_test(a_reflector_as_small_as_a_point_is_exact),
      cmocka_unit_test(the_box_and_the_impostor_know_where_the_walls_are),
      cmocka_unit_test(the_impostor_shows_a_ball_where_its_mirror_image_is),
      cmocka_unit_test(a_thousand_reflectors_keep_to_the_budget),
      cmocka_unit_test(what_has_no_map_is_traced),
      cmocka_unit_test(deeper_bounces_may_be_left_out),
      cmocka_unit_test(odd_reflectors_make_pictures),
      cmocka_unit_test(cubes_seen_by_raster_are_those_seen_by_rays),
      cmocka_unit_test(the_bytes_do_not_hang_on_the_waves),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
