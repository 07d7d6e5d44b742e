// The environment in pictures: which way round it is, and what it does to what stands in it.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/gltf_build.h"
#include "support/oracle_camera.h"
#include "support/picture_fixture.h"

// The sides of the world and the colours that the shared sides_256x128.hdr gives them: in the picture's middle red, a
// quarter to the right green, a quarter to the left blue, behind yellow, above white, below grey.
static const struct Side {
  Vec3 direction, color;
} sides[] = {
    {{1, 0, 0}, {1, 0, 0}},  {{0, 0, 1}, {0, 1, 0}}, {{0, 0, -1}, {0, 0, 1}},
    {{-1, 0, 0}, {1, 1, 0}}, {{0, 1, 0}, {2, 2, 2}}, {{0, -1, 0}, {0.125, 0.125, 0.125}},
};
enum { SIDES = 6 };

static int side_of(Vec3 direction)
{
  int best = 0;
  for (int i = 1; i < SIDES; i++)
    if (vec3_dot(direction, sides[i].direction) > vec3_dot(direction, sides[best].direction)) best = i;
  return best;
}

// How far a direction is from another side, as a difference of cosines.
static double side_margin(Vec3 direction)
{
  double best = -2, next = -2;
  for (int i = 0; i < SIDES; i++) {
    double cosine = vec3_dot(direction, sides[i].direction);
    next = fmax(next, fmin(best, cosine));
    best = fmax(best, cosine);
  }
  return best - next;
}

// The same picture made here: column u and row v show (cos p sin t, cos t, sin p sin t), p = 2 pi (u - 1/2), t = pi v.
static void sides_paint(Scene *scene)
{
  enum { WIDTH = 256, HEIGHT = 128 };
  static float colors[WIDTH * HEIGHT][3];
  for (int i = 0; i < WIDTH * HEIGHT; i++) {
    double p = 2 * M_PI * ((i % WIDTH + 0.5) / WIDTH - 0.5), t = M_PI * (i / WIDTH + 0.5) / HEIGHT;
    Vec3 color = sides[side_of(vec3(cos(p) * sin(t), cos(t), sin(p) * sin(t)))].color;
    colors[i][0] = (float)color.x;
    colors[i][1] = (float)color.y;
    colors[i][2] = (float)color.z;
  }
  scene_set_image(scene, WIDTH, HEIGHT, (const float(*)[3])colors);
}

// Turned back about +Y, so that what is seen there is what the unturned environment shows here.
static Vec3 turned_back(Vec3 d, double angle_rad)
{
  double c = cos(angle_rad), s = sin(angle_rad);
  return vec3(c * d.x - s * d.z, d.y, s * d.x + c * d.z);
}

static void side_check(const float *got, Vec3 direction, const Environment *environment, double tolerance)
{
  Vec3 unit = turned_back(vec3_unit_or(direction, vec3(1, 0, 0)), environment->rotation_rad);
  if (side_margin(unit) < 0.1) return;
  Vec3 wanted = vec3_scale(sides[side_of(unit)].color, environment->intensity);
  const double want[3] = {wanted.x, wanted.y, wanted.z};
  for (int c = 0; c < 3; c++)
    if (!(fabs(got[c] - want[c]) <= tolerance))
      fail_msg("towards (%g, %g, %g), channel %d: %g, not %g", direction.x, direction.y, direction.z, c, got[c],
               want[c]);
}

// The background in six views of 100 degrees, turned and not.
static void six_views_check(Scene *scene, double tolerance)
{
  enum { PIXELS = 24 };
  for (int turn = 0; turn < 2; turn++) {
    scene->environment.rotation_rad = turn ? 40 * M_PI / 180 : 0;
    scene->environment.intensity = turn ? 0.5f : 1;
    for (int view = 0; view < SIDES; view++) {
      Camera camera = camera_perspective(vec3(3, 2, 1), vec3_add(vec3(3, 2, 1), sides[view].direction), 1.75);
      PictureRequest request = picture_request(PIXELS, PIXELS, 1);
      Picture picture = picture_render(scene, &camera, &request);
      picture_assert_signal(&picture, 0.1);
      for (uint32_t i = 0; i < PIXELS * PIXELS; i++) {
        OracleRay ray = oracle_camera_ray(&camera, PIXELS, PIXELS, i % PIXELS + 0.5, i / PIXELS + 0.5);
        side_check(picture.radiance[i], ray.direction, &scene->environment, tolerance);
        assert_true(picture.radiance[i][3] == 0);
      }
      picture_free(&picture);
    }
  }
}

static void the_middle_of_the_image_is_x_and_to_its_right_is_z(void **state)
{
  Scene scene = scene_empty();
  sides_paint(&scene);
  six_views_check(&scene, 1e-5);
  scene_free(&scene);
}

// By 90 degrees about +Y, counter-clockwise seen from above: what was +X is now -Z.
static void rotation_turns_it_about_y(void **state)
{
  Scene scene = scene_empty();
  sides_paint(&scene);
  scene.environment.rotation_rad = M_PI / 2;
  Camera camera = camera_perspective(vec3(0, 0, 0), vec3(0, 0, -1), 0.5);
  PictureRequest request = picture_request(9, 9, 1);
  Picture picture = picture_render(&scene, &camera, &request);
  for (uint32_t i = 0; i < 81; i++)
    assert_true(picture.radiance[i][0] == 1 && picture.radiance[i][1] == 0 && picture.radiance[i][2] == 0);
  picture_free(&picture);
  scene_free(&scene);
}

static void a_mirror_shows_the_environment_it_faces(void **state)
{
  Scene scene = scene_empty();
  sides_paint(&scene);
  int mirror = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 1, 0));
  scene_add_quad(&scene, mirror, vec3(-9, -9, 0), vec3(18, 0, 0), vec3(0, 18, 0));
  Camera camera = camera_perspective(vec3(0, 0, 3), vec3(0.5, 0.2, 0), 1.8);
  PictureRequest request = picture_request(32, 32, 1);
  Picture picture = picture_render(&scene, &camera, &request);
  picture_assert_signal(&picture, 0.5);
  for (uint32_t i = 0; i < 32 * 32; i++) {
    Vec3 d = oracle_camera_ray(&camera, 32, 32, i % 32 + 0.5, i / 32 + 0.5).direction;
    if (picture.radiance[i][3] == 1) side_check(picture.radiance[i], vec3(d.x, d.y, -d.z), &scene.environment, 1e-5);
  }
  picture_free(&picture);
  scene_free(&scene);
}

// A matt white ball shows on each side the irradiance of that side's half of the world.
static void a_matt_ball_is_lit_from_the_right_sides(void **state)
{
  Scene scene = scene_empty();
  sides_paint(&scene);
  int white = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 0, 1));
  scene_add_sphere(&scene, white, vec3(0, 0, 0), 1, 32);
  float seen[SIDES][3];
  for (int i = 0; i < SIDES; i++) {
    Camera camera = camera_orthographic(vec3_scale(sides[i].direction, 3), vec3(0, 0, 0), 0.1);
    PictureRequest request = picture_request(1, 1, 1);
    Picture picture = picture_render(&scene, &camera, &request);
    for (int c = 0; c < 3; c++) seen[i][c] = picture.radiance[0][c];
    picture_free(&picture);
  }
  const float *x = seen[0], *z = seen[1], *minus_z = seen[2], *minus_x = seen[3], *y = seen[4], *minus_y = seen[5];
  assert_true(x[0] > 1.3f * x[1] && x[0] > 1.3f * x[2]);
  assert_true(z[1] > 1.3f * z[2] && minus_z[2] > 1.3f * minus_z[1]);
  assert_true(minus_x[1] > 1.5f * x[1]);
  for (int c = 0; c < 3; c++) assert_true(y[c] > 2 * minus_y[c] && y[c] < 2 && minus_y[c] > 0.05f);
  scene_free(&scene);
}

// ---- shared files ---------------------------------------------------------------------------------------------------

static bool asset_environment_read(Scene *scene, const char *name)
{
  const char *assets = gltf_assets();
  if (!assets) return false;
  char path[512];
  snprintf(path, sizeof path, "%s/Environments/%s", assets, name);
  *scene = scene_empty();
  scene->environment.kind = ENVIRONMENT_IMAGE;
  picture_assert_ok(picture_read_image(&scene->environment.image, path));
  return true;
}

static void the_sides_asset_is_the_right_way_round(void **state)
{
  Scene scene;
  if (!asset_environment_read(&scene, "sides_256x128.hdr")) return;
  six_views_check(&scene, 0.06);  // its colours have 0.05 of the others in them
  scene_free(&scene);
}

// In front of radiance 0.5 everywhere, what reflects all light vanishes; what absorbs some does not.
static void a_perfect_mirror_vanishes_in_the_furnace(void **state)
{
  Scene scene;
  if (!asset_environment_read(&scene, "furnace_64x32.hdr")) return;
  int material = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 1, 0));
  scene_add_sphere(&scene, material, vec3(0, 0, 0), 1, 32);
  Camera camera = camera_perspective(vec3(0, 1, 3), vec3(0, 0, 0), 1);
  for (int model = LIGHTING_PBR; model <= LIGHTING_PHONG; model++) {
    PictureRequest request = picture_request(48, 48, 4);
    request.settings.lighting = (LightingModel)model;
    request.settings.ambient = 0;
    Picture picture = picture_render(&scene, &camera, &request);
    double covered = 0;
    for (uint32_t i = 0; i < 48 * 48; i++) {
      covered += picture.radiance[i][3];
      for (int c = 0; c < 3; c++) assert_true(fabs(picture.radiance[i][c] - 0.5) <= 1e-5);
    }
    assert_true(covered > 500 && covered < 1500);
    picture_free(&picture);
  }
  for (int c = 0; c < 3; c++) scene.materials[material].base_color[c] = 0.5f;
  PictureRequest request = picture_request(48, 48, 4);
  Picture picture = picture_render(&scene, &camera, &request);
  picture_assert_signal(&picture, 0.2);
  picture_free(&picture);
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_middle_of_the_image_is_x_and_to_its_right_is_z),
      cmocka_unit_test(rotation_turns_it_about_y),
      cmocka_unit_test(a_mirror_shows_the_environment_it_faces),
      cmocka_unit_test(a_matt_ball_is_lit_from_the_right_sides),
      cmocka_unit_test(the_sides_asset_is_the_right_way_round),
      cmocka_unit_test(a_perfect_mirror_vanishes_in_the_furnace),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
