// The error of cube maps in closed form (plan/cube_error.h) against pictures.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "plan/cube_error.h"
#include "scene/scene_build.h"
#include "support/mirrors.h"
#include "support/oracle_camera.h"

// Where a glowing thing is seen, in pixels from the top left.
static void glow_center(double at[2], const Picture *picture)
{
  double sum = 0;
  at[0] = at[1] = 0;
  for (size_t i = 0; i < (size_t)picture->width * picture->height; i++) {
    double weight = (double)picture->radiance[i][1];
    sum += weight;
    at[0] += weight * ((double)(i % picture->width) + 0.5);
    at[1] += weight * ((double)(i / picture->width) + 0.5);
  }
  if (!(sum > 50)) fail_msg("%g pixels glow", sum);
  at[0] /= sum;
  at[1] /= sum;
}

static double angle_between(Vec3 a, Vec3 b) { return atan2(vec3_length(vec3_cross(a, b)), vec3_dot(a, b)); }

// A ball that comes towards a flat mirror: by rays it is seen in one direction, by the cube in another, and the angle
// between both is that of plan/cube_error.h. Far away it falls as 1 / D. A tenth of a pixel is what a centre is found
// by.
static void parallax_is_that_of_the_closed_form(void **state)
{
  enum { SIDE = 160, STEPS = 5 };
  double measured[STEPS], distance = 1.5, slack = 0.1 * 0.9 / SIDE;
  const Vec3 towards = vec3_unit_or(vec3(0.3, 0.2, 1), vec3(0, 0, 1));
  for (int i = 0; i < STEPS; i++, distance *= 2) {
    Scene scene = scene_empty();
    Vec3 target = vec3_scale(towards, distance);
    scene_add_quad(&scene, mirrors_material(&scene, false), vec3(-3, -3, 0), vec3(6, 0, 0), vec3(0, 6, 0));
    scene_add_sphere(&scene, scene_add_material(&scene, material_glowing(vec3(1, 1, 1))), target, 0.08 * distance, 16);
    Camera camera = camera_perspective(vec3(-1.2, -0.8, 1.2), vec3(-0.6, -0.4, 0), 0.9);
    Vec3 directions[2], at = {0}, sight = {0};
    for (int map = 0; map < 2; map++) {
      double center[2];
      PictureRequest request = mirrors_request(SIDE, map ? REFLECTIONS_CUBE : REFLECTIONS_RAYS, 256);
      request.settings.lighting = LIGHTING_PHONG;  // a mirror's share is the same everywhere
      request.settings.ambient = 0;
      Picture picture = picture_render(&scene, &camera, &request);
      glow_center(center, &picture);
      OracleRay ray = oracle_camera_ray(&camera, SIDE, SIDE, center[0], center[1]);
      directions[map] = ray.direction;
      if (!map) at = vec3_sub(ray.origin, vec3_scale(ray.direction, ray.origin.z / ray.direction.z));
      if (!map) sight = vec3(ray.direction.x, ray.direction.y, -ray.direction.z);
      picture_free(&picture);
    }
    measured[i] = angle_between(directions[0], directions[1]);
    double bound = cube_parallax_rad(&(CubeSight){vec3_length(at), distance, angle_between(at, sight)});
    if (!(fabs(measured[i] - bound) < slack + 0.02 * bound))
      fail_msg("%g at %g m, not %g", measured[i], distance, bound);
    assert_true(bound <= cube_parallax_most_rad(vec3_length(at), distance));
    scene_free(&scene);
  }
  double slope = log(measured[STEPS - 1] / measured[STEPS - 2]) / log(2);
  if (fabs(slope + 1) > 0.1) fail_msg("the slope is %g", slope);
}

// A glowing ball in a mirror ball, over distances and directions of both: by how many pixels the cube shows it
// elsewhere, from 4 of its radii on. To the first order: the change of the reflected ray is taken where rays show it,
// and grows from there to the rim.
static void a_ball_shifts_what_it_shows_as_predicted(void **state)
{
  enum { SIDE = 128, CASES = 36 };
  static const double radius = 0.5, reaches[3] = {2.5, 4, 9};
  for (int i = 0; i < CASES; i++) {
    double reach = reaches[i % 3], view_rad = 2 / reach, turn = 1 + 0.5 * (i / 12);
    double distance = radius * 4 * pow(2, i / 3 % 4);
    Vec3 target = vec3_scale(vec3(sin(turn), 0.3 * sin(turn), cos(turn)), distance),
         eye = vec3(0, 0, reach * radius);  // which does not see it directly
    Scene scene = scene_empty();
    scene_add_sphere(&scene, mirrors_material(&scene, false), vec3(0, 0, 0), radius, 64);
    scene_add_sphere(&scene, scene_add_material(&scene, material_glowing(vec3(1, 1, 1))), target, 0.2 * distance, 16);
    Camera camera = camera_perspective(eye, vec3(0, 0, 0), view_rad);
    camera.znear_m = 0.01;
    double centers[2][2];
    for (int map = 0; map < 2; map++) {
      PictureRequest request = mirrors_request(SIDE, map ? REFLECTIONS_CUBE : REFLECTIONS_RAYS, 256);
      request.settings.lighting = LIGHTING_PHONG;
      request.settings.ambient = 0;
      Picture picture = picture_render(&scene, &camera, &request);
      glow_center(centers[map], &picture);
      picture_free(&picture);
    }
    Vec3 d = vec3_unit_or(oracle_camera_ray(&camera, SIDE, SIDE, centers[0][0], centers[0][1]).direction, eye);
    double b = vec3_dot(eye, d), t = -b - sqrt(b * b - vec3_dot(eye, eye) + radius * radius);
    Vec3 at = vec3_add(eye, vec3_scale(d, t)), n = vec3_scale(at, 1 / radius);
    Vec3 sight = vec3_sub(d, vec3_scale(n, 2 * vec3_dot(d, n)));
    ReflectorView view = {view_rad / SIDE, t, radius, acos(-vec3_dot(d, n)), 1, INFINITY};
    CubeSight ray = {radius, distance, angle_between(at, sight)};
    double predicted = cube_wrong_px(&view, cube_parallax_rad(&ray));
    double measured = hypot(centers[1][0] - centers[0][0], centers[1][1] - centers[0][1]);
    if (!(fabs(predicted - measured) < 0.15 + 0.15 * measured))
      fail_msg("%g m from the centre, %g radii away: %g pixels, not %g", distance, reach, measured, predicted);
    scene_free(&scene);
  }
}

// In the plane of incidence, two rays a small angle apart off a sphere, reflected exactly.
static void a_reflected_rays_change_is_that_of_two_rays(void **state)
{
  static const double radius = 0.5, distance = 3, step = 1e-6;
  for (double slant = 0; slant < 1.3; slant += 0.25) {
    Vec3 hit = {radius, 0, 0}, eye = vec3_add(hit, vec3(distance * cos(slant), distance * sin(slant), 0)), out[2];
    double middle = atan2(-sin(slant), -cos(slant));
    for (int i = 0; i < 2; i++) {
      Vec3 d = vec3(cos(middle + (i - 0.5) * step), sin(middle + (i - 0.5) * step), 0);
      double b = vec3_dot(eye, d), t = -b - sqrt(b * b - vec3_dot(eye, eye) + radius * radius);
      Vec3 n = vec3_scale(vec3_add(eye, vec3_scale(d, t)), 1 / radius);
      out[i] = vec3_sub(d, vec3_scale(n, 2 * vec3_dot(d, n)));
    }
    ReflectorView view = {step, distance, radius, slant, 100, 50};
    assert_true(fabs(angle_between(out[0], out[1]) / reflected_change_rad(&view) - 1) < 1e-4);
    assert_true(fabs(cube_wrong_px(&view, 0.1 * reflected_change_rad(&view)) - 10) < 1e-9);
    assert_true(cube_wrong_px(&view, 1) == 50);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(parallax_is_that_of_the_closed_form),
      cmocka_unit_test(a_ball_shifts_what_it_shows_as_predicted),
      cmocka_unit_test(a_reflected_rays_change_is_that_of_two_rays),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
