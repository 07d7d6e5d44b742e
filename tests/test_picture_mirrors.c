// Mirrors: where a reflection is, how bright after many, and what the camera's range does not cut.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/oracle_camera.h"
#include "support/picture_fixture.h"

static PictureRequest mirror_request(uint32_t width, uint32_t height, LightingModel model)
{
  PictureRequest request = picture_request(width, height, 1);
  request.settings.lighting = model;
  request.settings.ambient = 0;
  return request;
}

static int mirror_add(Scene *scene, Vec3 base) { return scene_add_material(scene, material_plain(base, 1, 0)); }

static void assert_radiance(const float *got, Vec3 wanted, double relative)
{
  const double want[3] = {wanted.x, wanted.y, wanted.z};
  for (int c = 0; c < 3; c++)
    if (!(fabs(got[c] - want[c]) <= relative * want[c])) fail_msg("channel %d: %.9g, not %.9g", c, got[c], want[c]);
}

// ---- at a known angle -----------------------------------------------------------------------------------------------

// Four glowing tiles on the ceiling, by the signs of x and z.
static Vec3 tile_emission(bool right, bool front) { return vec3(right ? 3 : 0.5, front ? 2 : 0.25, 1); }

// A mirror at 45 degrees turns a level view straight up: the point (x, y) of the view shows (x, -y) of the ceiling.
static Scene periscope_scene(Vec3 base)
{
  Scene scene = scene_empty();
  scene_add_quad(&scene, mirror_add(&scene, base), vec3(-2, -2, 2), vec3(4, 0, 0), vec3(0, 4, -4));
  for (int i = 0; i < 4; i++) {
    bool right = i & 1, front = i & 2;
    int glow = scene_add_material(&scene, material_glowing(tile_emission(right, front)));
    scene_add_quad(&scene, glow, vec3(right ? 0 : -3, 5, front ? 0 : -3), vec3(3, 0, 0), vec3(0, 0, 3));
  }
  return scene;
}

// Level views of 45 degrees off the mirror: F is F0 + (1 - F0) (1 - cos 45)^5 in pbr, ks in phong.
static void periscope_check(LightingModel model, bool perspective)
{
  enum { SIDE = 64 };
  const Vec3 base = vec3(0.9, 0.5, 0.2);
  Scene scene = periscope_scene(base);
  Camera camera = camera_orthographic(vec3(0, 0, 6), vec3(0, 0, 0), 1.5);
  if (perspective) camera = camera_perspective(vec3(0, 0, 6), vec3(0, 0, 0), 0.4);
  PictureRequest request = mirror_request(SIDE, SIDE, model);
  Picture picture = picture_render(&scene, &camera, &request);
  uint32_t seen[4] = {0};
  for (uint32_t y = 0; y < SIDE; y++) {
    for (uint32_t x = 0; x < SIDE; x++) {
      OracleRay ray = oracle_camera_ray(&camera, SIDE, SIDE, x + 0.5, y + 0.5);
      // Where the ray meets y + z = 0, and then, (a, b, c) turned to (a, -c, -b), the ceiling.
      double t = -(ray.origin.y + ray.origin.z) / (ray.direction.y + ray.direction.z);
      Vec3 at = vec3_add(ray.origin, vec3_scale(ray.direction, t));
      Vec3 up = vec3(ray.direction.x, -ray.direction.z, -ray.direction.y);
      Vec3 ceiling = vec3_add(at, vec3_scale(up, (5 - at.y) / up.y));
      bool right = ceiling.x > 0, front = ceiling.z > 0;
      if (fmin(fabs(ceiling.x), fabs(ceiling.z)) < 1e-4) continue;
      double cosine = -(ray.direction.y + ray.direction.z) / sqrt(2) / vec3_length(ray.direction);
      double schlick = model == LIGHTING_PBR ? pow(1 - cosine, 5) : 0;
      Vec3 share =
          vec3(base.x + (1 - base.x) * schlick, base.y + (1 - base.y) * schlick, base.z + (1 - base.z) * schlick);
      assert_radiance(picture_pixel(&picture, x, y), vec3_mul(share, tile_emission(right, front)), 1e-5);
      seen[right + 2 * front]++;
    }
  }
  for (int i = 0; i < 4; i++) assert_true(seen[i] > SIDE * SIDE / 8);
  picture_free(&picture);
  scene_free(&scene);
}

static void a_mirror_at_45_degrees_shows_the_ceiling(void **state)
{
  for (int perspective = 0; perspective < 2; perspective++) {
    periscope_check(LIGHTING_PBR, perspective);
    periscope_check(LIGHTING_PHONG, perspective);
  }
}

// ---- facing mirrors -------------------------------------------------------------------------------------------------

// Between two mirrors that glow with radiance 1 and reflect rho, a ray that runs to and fro adds up 1 + rho + rho^2 ...
// until rho^k is not above 1/255 or k is over the limit.
static double facing_sum(double rho, uint32_t max_depth)
{
  double sum = 1, power = rho;
  for (uint32_t k = 1; k <= max_depth && power > 1.0 / 255; k++, power *= rho) sum += power;
  return sum;
}

static void facing_check(double rho, uint32_t max_depth, LightingModel model, uint32_t lanes)
{
  Scene scene = scene_empty();
  Material mirror = material_plain(vec3(rho, rho, rho), 1, 0);
  for (int c = 0; c < 3; c++) mirror.emission[c] = 1;
  int material = scene_add_material(&scene, mirror);
  scene_add_quad(&scene, material, vec3(-5, -5, -1), vec3(10, 0, 0), vec3(0, 10, 0));
  scene_add_quad(&scene, material, vec3(-5, -5, 1), vec3(0, 10, 0), vec3(10, 0, 0));
  Camera camera = camera_orthographic(vec3(0.1, 0.2, 0), vec3(0.1, 0.2, -1), 1);
  PictureRequest request = mirror_request(8, 8, model);
  request.settings.max_depth = max_depth;
  request.lanes = lanes;
  Picture picture = picture_render(&scene, &camera, &request);
  double wanted = facing_sum((float)rho, max_depth);
  for (uint32_t i = 0; i < 64; i++) {
    double got = picture.radiance[i][1];
    if (!(fabs(got - wanted) <= 1e-5 * wanted))
      fail_msg("rho %g, depth %u: %.8g, not %.8g", rho, max_depth, got, wanted);
  }
  picture_free(&picture);
  scene_free(&scene);
}

static void facing_mirrors_add_up_the_powers_of_their_reflectance(void **state)
{
  static const struct {
    double rho;
    uint32_t max_depth;
  } cases[] = {{0.003, 8}, {0.5, 0}, {0.5, 1}, {0.5, 8}, {0.5, 1000}, {0.9, 8}, {0.9, 1000}, {0.99, 100}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    facing_check(cases[i].rho, cases[i].max_depth, LIGHTING_PHONG, 0);
    facing_check(cases[i].rho, cases[i].max_depth, LIGHTING_PBR, 0);
  }
  assert_true(facing_sum(0.5, 1000) == 2 - 0x1p-7);  // 0.5^8 = 1/256 is cut
  facing_check(0.9, 1000, LIGHTING_PBR, 8);
  facing_check(0.9, 1000, LIGHTING_PBR, 1);
}

static void without_reflections_mirrors_stay_dark(void **state)
{
  Scene scene = periscope_scene(vec3(1, 1, 1));
  Camera camera = camera_orthographic(vec3(0, 0, 6), vec3(0, 0, 0), 1.5);
  PictureRequest request = mirror_request(16, 16, LIGHTING_PBR);
  request.settings.reflections = REFLECTIONS_NONE;
  Picture picture = picture_render(&scene, &camera, &request);
  for (uint32_t i = 0; i < 256; i++) assert_true(picture.radiance[i][0] == 0 && picture.radiance[i][3] == 1);
  picture_free(&picture);
  scene_free(&scene);
}

// ---- the camera's range ---------------------------------------------------------------------------------------------

// A red screen nearer than znear that shades a floor, a green wall farther than zfar, a blue one as far behind the
// camera, and a mirror on the left with a yellow sign before it, nearer than znear, which faces the mirror alone.
static Scene range_scene(void)
{
  Scene scene = scene_empty();
  Material red = material_glowing(vec3(4, 0, 0));
  red.double_sided = true;
  int screen = scene_add_material(&scene, red), wall = scene_add_material(&scene, material_glowing(vec3(0, 2, 0)));
  int behind = scene_add_material(&scene, material_glowing(vec3(0, 0, 3)));
  int sign = scene_add_material(&scene, material_glowing(vec3(2, 2, 0)));
  int floor = scene_add_material(&scene, material_plain(vec3(0.5, 0.5, 0.5), 0, 1));
  scene_add_quad(&scene, sign, vec3(-4, 2.8, 0.8), vec3(0, 0.8, 0), vec3(1, 0, 0));
  scene_add_quad(&scene, screen, vec3(-0.5, 1, 9), vec3(1, 0, 0), vec3(0, 1, 0));
  scene_add_quad(&scene, wall, vec3(-20, -20, -20), vec3(40, 0, 0), vec3(0, 40, 0));
  scene_add_quad(&scene, behind, vec3(-40, -3, 60), vec3(0, 15, 0), vec3(80, 0, 0));
  scene_add_quad(&scene, floor, vec3(-5, 0, 8), vec3(10, 0, 0), vec3(0, 0, -10));
  scene_add_quad(&scene, mirror_add(&scene, vec3(1, 1, 1)), vec3(-5.4, 0, 0), vec3(5.35, 0, 0), vec3(0, 4, 0));
  scene_add_light(&scene, light_directional(vec3(0, -1, -2), 2));
  return scene;
}

// Radiance at the pixel where the camera sees a point.
static const float *seen_at(const Picture *picture, const Camera *camera, Vec3 point)
{
  Vec3 away = vec3_sub(
      point, vec3(camera->world_from_camera.m[12], camera->world_from_camera.m[13], camera->world_from_camera.m[14]));
  const double *m = camera->world_from_camera.m;
  double depth = -vec3_dot(away, vec3(m[8], m[9], m[10])), half = tan(camera->yfov_rad / 2) * depth;
  double x = vec3_dot(away, vec3(m[0], m[1], m[2])) / half, y = vec3_dot(away, vec3(m[4], m[5], m[6])) / half;
  return picture_pixel(picture, (uint32_t)((x + 1) / 2 * picture->width), (uint32_t)((1 - y) / 2 * picture->height));
}

static void znear_and_zfar_bound_what_the_camera_sees_and_nothing_else(void **state)
{
  const Vec3 black = {0}, red = vec3(4, 0, 0), green = vec3(0, 2, 0), blue = vec3(0, 0, 3);
  Scene scene = range_scene();
  Camera camera = camera_perspective(vec3(0, 1.5, 10), vec3(0, 1.5, 0), 1);
  PictureRequest request = mirror_request(201, 201, LIGHTING_PHONG);
  for (int bounded = 0; bounded < 2; bounded++) {
    camera.znear_m = bounded ? 2 : 0.1;
    camera.zfar_m = bounded ? 20 : INFINITY;
    Picture picture = picture_render(&scene, &camera, &request);
    picture_assert_signal(&picture, 0.05);
    // The camera's own rays: screen and wall are cut.
    assert_radiance(seen_at(&picture, &camera, vec3(0.2, 1.6, 9)), bounded ? black : red, 1e-6);
    assert_radiance(seen_at(&picture, &camera, vec3(5.3, 3, 0)), bounded ? black : green, 1e-6);
    assert_true(seen_at(&picture, &camera, vec3(5.3, 3, 0))[3] == (bounded ? 0 : 1));
    // In the mirror both are seen: the screen's back, at -0.25 x 10 / 19, and the wall behind the camera.
    assert_radiance(seen_at(&picture, &camera, vec3(-0.132, 1.5, 0)), red, 1e-6);
    assert_radiance(seen_at(&picture, &camera, vec3(-5.2, 2.5, 0)), blue, 1e-6);
    if (bounded) assert_radiance(seen_at(&picture, &camera, vec3(-3.24, 3.07, 0)), vec3(2, 2, 0), 1e-6);
    // The screen's shadow lies at z = 9 - 2 y, and its own edge beside it.
    if (bounded) assert_radiance(seen_at(&picture, &camera, vec3(0.3, 0, 6)), black, 0);
    if (bounded) assert_true(seen_at(&picture, &camera, vec3(0.7, 0, 6))[0] > 0.05);
    assert_true(seen_at(&picture, &camera, vec3(3.2, 0, 4))[0] > 0.05);
    picture_free(&picture);
  }
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_mirror_at_45_degrees_shows_the_ceiling),
      cmocka_unit_test(facing_mirrors_add_up_the_powers_of_their_reflectance),
      cmocka_unit_test(without_reflections_mirrors_stay_dark),
      cmocka_unit_test(znear_and_zfar_bound_what_the_camera_sees_and_nothing_else),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
