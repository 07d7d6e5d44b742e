// Shadow maps, PCF, PCSS and area lights: where they must be right, how wrong they may be elsewhere.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/picture_fixture.h"
#include "support/test_device.h"

enum { WIDTH = 160, HEIGHT = 100 };

static const ShadowMethod by_maps[] = {SHADOWS_MAP, SHADOWS_PCF, SHADOWS_PCSS};

static PictureRequest request_of(ShadowMethod method)
{
  PictureRequest request = picture_request(WIDTH, HEIGHT, 1);
  request.settings.shadows = method;
  return request;
}

// A white floor, 8 m square, and what `box` puts on it.
static Scene scene_floor(bool box)
{
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(0.8, 0.8, 0.8), 0, 1));
  scene_add_quad(&scene, white, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8));
  if (box) scene_add_box(&scene, white, vec3(-0.5, 0, -0.5), vec3(0.5, 1, 0.5));
  return scene;
}

static Camera camera_above(void) { return camera_perspective(vec3(0, 6, 5), vec3(0, 0, 0), 0.8); }

// A directional light so many degrees off the floor's normal; or a spot light that shines from there.
static Light light_at(double degrees, bool spot)
{
  double angle = degrees * M_PI / 180;
  Vec3 to_light = vec3(sin(angle) * 0.8, cos(angle), -sin(angle) * 0.6);
  return spot ? light_spot(vec3_scale(to_light, 6), vec3(0, 0, 0), 100, 0.7, 0.9)
              : light_directional(vec3_neg(to_light), 3);
}

static void a_bare_plane_has_no_acne(void **state)
{
  static const double degrees[] = {0, 20, 45, 70, 80, 85};
  Camera camera = camera_above();
  for (int spot = 0; spot < 2; spot++)
    for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++) {
      Scene scene = scene_floor(false);
      scene_add_light(&scene, light_at(degrees[i], spot));
      PictureRequest request = request_of(SHADOWS_NONE);
      Picture none = picture_render(&scene, &camera, &request);
      picture_assert_signal(&none, 0.001);
      for (int m = 0; m < 3; m++) {
        request.settings.shadows = by_maps[m];
        Picture mapped = picture_render(&scene, &camera, &request);
        for (uint32_t p = 0; p < WIDTH * HEIGHT; p++)  // PCF sums 16 weights
          for (int c = 0; c < 3; c++) {
            float a = none.radiance[p][c], b = mapped.radiance[p][c];
            if (!(b >= a * 0.99999f))
              fail_msg("%g degrees, method %d: pixel %u: %g, not %g", degrees[i], m, p, (double)b, (double)a);
          }
        picture_free(&mapped);
      }
      picture_free(&none);
      scene_free(&scene);
    }
}

// Share of pixels that are off by more than 2 % of the unshadowed floor.
static double share_wrong(const Picture *a, const Picture *b)
{
  uint32_t wrong = 0;
  for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
    wrong += fabsf(a->radiance[i][1] - b->radiance[i][1]) > 0.02f * fmaxf(a->radiance[i][1], b->radiance[i][1]);
  return wrong / (double)(WIDTH * HEIGHT);
}

// Twice the map, half the error: it is at edges alone. (A texel wider than the picture's pixels each time.)
static void the_error_of_a_map_falls_with_its_size(void **state)
{
  Camera camera = camera_above();
  for (int spot = 0; spot < 2; spot++) {
    Scene scene = scene_floor(true);
    scene_add_light(&scene, light_at(50, spot));
    PictureRequest request = request_of(SHADOWS_RAYS);
    Picture rays = picture_render(&scene, &camera, &request);
    double shares[3];
    for (int i = 0; i < 3; i++) {
      request.settings.shadows = SHADOWS_MAP;
      request.settings.shadow_options.map_size_px = 32u << (2 * i);
      Picture mapped = picture_render(&scene, &camera, &request);
      shares[i] = share_wrong(&rays, &mapped);
      picture_free(&mapped);
    }
    request.settings.shadows = SHADOWS_NONE;
    Picture none = picture_render(&scene, &camera, &request);
    double all = share_wrong(&rays, &none);
    if (!(shares[0] < all && shares[1] < 0.6 * shares[0] && shares[2] < 0.6 * shares[1] && shares[2] < 0.01))
      fail_msg("wrong: %g without shadows, %g, %g, %g with maps", all, shares[0], shares[1], shares[2]);
    picture_free(&none);
    picture_free(&rays);
    scene_free(&scene);
  }
}

// What PCF darkens on one side of an edge it lights on the other: neither the amount of shadow nor its middle moves.
static void pcf_moves_no_edge(void **state)
{
  Scene scene = scene_floor(true);
  Camera camera = camera_perspective(vec3(0, 9, 0.01), vec3(0, 0, 0), 0.7);
  scene_add_light(&scene, light_directional(vec3(-1, -1, 0), 3));
  PictureRequest request = request_of(SHADOWS_NONE);
  Picture none = picture_render(&scene, &camera, &request);
  double dark[2] = {0}, middle_x[2] = {0}, middle_y[2] = {0};
  for (int m = 0; m < 2; m++) {
    request = request_of(m ? SHADOWS_PCF : SHADOWS_RAYS);
    request.settings.shadow_options = (ShadowOptions){.map_size_px = 256, .kernel_px = 3};
    Picture picture = picture_render(&scene, &camera, &request);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
      double lost = (double)(none.radiance[i][1] - picture.radiance[i][1]);
      dark[m] += lost;
      middle_x[m] += lost * (i % WIDTH);
      middle_y[m] += lost * (i / WIDTH);
    }
    picture_free(&picture);
  }
  assert_true(dark[0] > 0 && fabs(dark[1] - dark[0]) < 0.06 * dark[0]);
  // Pixels; a texel is 0.7 of one. Along the light the shadow begins a texel late (ShadowInfo.slope_px).
  double shift_x = middle_x[1] / dark[1] - middle_x[0] / dark[0],
         shift_y = middle_y[1] / dark[1] - middle_y[0] / dark[0];
  if (!(fabs(shift_x) < 0.6 && fabs(shift_y) < 0.2)) fail_msg("the shadow moves by %g, %g pixels", shift_x, shift_y);
  picture_free(&none);
  scene_free(&scene);
}

// A GPU's kernel asks texel by texel, a CPU's block by block: up to the rounding of texels that sit on the plane.
static void pcf_is_the_same_at_every_width(void **state)
{
  static const uint32_t kernels_px[] = {1, 3, 7};
  if (test_on_gpu()) return;
  Scene scene = scene_floor(true);
  Camera camera = camera_above();
  scene_add_light(&scene, light_at(45, true));
  scene_add_light(&scene, light_at(20, false));
  for (int k = 0; k < 3; k++) {
    PictureRequest request = request_of(SHADOWS_NONE);
    request.lanes = 16;
    Picture none = picture_render(&scene, &camera, &request);
    request.settings.shadows = SHADOWS_PCF;
    request.settings.shadow_options = (ShadowOptions){.map_size_px = 64, .kernel_px = kernels_px[k]};
    Picture wide = picture_render(&scene, &camera, &request);
    request.lanes = 1;
    Picture single = picture_render(&scene, &camera, &request);
    uint32_t shadowed = 0, apart = 0;
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
      float a = wide.radiance[i][1], b = single.radiance[i][1];
      shadowed += a < 0.99f * none.radiance[i][1];
      apart += !(fabsf(a - b) <= 1e-4f * fabsf(a));
    }
    assert_true(shadowed > WIDTH * HEIGHT / 50);
    if (apart > WIDTH * HEIGHT / 10000) fail_msg("kernel of %u: %u pixels apart", kernels_px[k], apart);
    picture_free(&single);
    picture_free(&wide);
    picture_free(&none);
  }
  scene_free(&scene);
}

// A light without size has hard shadows, by every method that knows of sizes.
static void soft_shadows_without_a_radius_are_hard(void **state)
{
  Camera camera = camera_above();
  for (int kind = 0; kind < 3; kind++) {
    Scene scene = scene_floor(true);
    scene_add_light(&scene, kind == 2 ? light_point(vec3(1.5, 3, 1), 40) : light_at(50, kind));
    PictureRequest request = request_of(SHADOWS_RAYS);
    Picture rays = picture_render(&scene, &camera, &request);
    request.settings.shadows = SHADOWS_AREA;
    Picture area = picture_render(&scene, &camera, &request);
    assert_true(share_wrong(&rays, &area) <= 3.0 / (WIDTH * HEIGHT));
    request.settings.shadows = SHADOWS_PCSS;
    Picture pcss = picture_render(&scene, &camera, &request);
    assert_true(share_wrong(&rays, &pcss) < 0.03);
    picture_free(&rays);
    picture_free(&area);
    picture_free(&pcss);
    scene_free(&scene);
  }
}

// Radiance of the floor's point at the picture's middle with a light over it that a sheet hides from x = `edge` on.
static double half_hidden(ShadowMethod method, double edge, double radius, bool directional)
{
  Scene scene = scene_floor(false);
  Material thin = material_plain(vec3(0.5, 0.5, 0.5), 0, 1);
  thin.double_sided = true;
  int sheet = scene_add_material(&scene, thin);
  scene_add_quad(&scene, sheet, vec3(edge, 2, 3), vec3(6, 0, 0), vec3(0, 0, -6));
  scene_add_light(&scene, directional ? light_directional(vec3(0, -1, 0), 3) : light_point(vec3(0, 4, 0), 50));
  Camera camera = camera_perspective(vec3(-6, 1.5, 0), vec3(0, 0, 0), 0.0005);
  PictureRequest request = picture_request(1, 1, 4096);
  request.settings.shadows = method;
  request.settings.shadow_options = (ShadowOptions){
      .map_size_px = 1024, .kernel_px = 3, .light_radius_m = (float)radius, .light_angle_rad = radius / 4};
  Picture picture = picture_render(&scene, &camera, &request);
  double value = (double)picture_pixel(&picture, 0, 0)[1];
  picture_free(&picture);
  scene_free(&scene);
  return value;
}

// A straight edge at an offset of h radii hides the part of a disc that closed form gives: acos(h) / pi - h sqrt(1 -
// h^2) / pi. The cone's solid angle is a disc's to 0.2 % for a sphere of 0.5 m at 4 m. 4096 stratified samples of an
// indicator: an error of about 0.5 %.
static void a_half_hidden_light_lights_by_its_visible_part(void **state)
{
  for (int directional = 0; directional < 2; directional++) {
    double open = half_hidden(SHADOWS_AREA, 5, 0.5, directional);
    for (int i = -1; i <= 1; i++) {
      double h = 0.5 * i, hidden = (acos(h) - h * sqrt(1 - h * h)) / M_PI;
      // The sheet is halfway to the point light, so that a radius is half as wide there; a directional light's cone is
      // 2 tan(1/8) wide.
      double edge = directional ? h * 2 * tan(0.125) : h * 0.25 / sqrt(1 - 1.0 / 64);
      double lit = half_hidden(SHADOWS_AREA, edge, 0.5, directional) / open;
      if (!(fabs(lit - (1 - hidden)) < 0.006)) fail_msg("h %g: %g is lit, not %g", h, lit, 1 - hidden);
    }
  }
}

// Lights that make no sense, or stand where none should, spoil nothing: what the others light stays. Hybrid shadows are
// those of rays.
static void odd_lights_spoil_nothing(void **state)
{
  Camera camera = camera_above();
  const double *to_world = camera.world_from_camera.m;
  Vec3 near_plane = vec3_sub(vec3(to_world[12], to_world[13], to_world[14]),
                             vec3_scale(vec3(to_world[8], to_world[9], to_world[10]), camera.znear_m));
  Light odd[] = {
      light_point(vec3(0, 6, 5), 0),  // without power
      light_point(vec3(0, 6, 5), 1),  // in the camera
      light_point(near_plane, 1),
      light_point(vec3(0, 0, 0.5), 1),                        // on the floor, on the box's wall
      light_point(vec3(0, 0.5, 0), 50),                       // within the box
      light_point(vec3(1e15, 1e15, 0), 1),                    // next to nowhere
      light_spot(vec3(2, 3, 0), vec3(2, 3, 0), 5, 0.2, 0.3),  // looks nowhere
      light_spot(vec3(2, 3, 0), vec3(0, 0, 0), 5, 0, 1e-6),   // through a slit
      light_point(vec3(1, 2, 0), NAN),
      light_point(vec3(NAN, 2, 0), 1),
  };
  for (size_t i = 0; i < sizeof odd / sizeof *odd; i++)
    for (int m = SHADOWS_MAP; m <= SHADOWS_AREA; m++) {
      Scene scene = scene_floor(true);
      scene_add_light(&scene, light_at(50, false));
      scene_add_light(&scene, odd[i]);
      PictureRequest request = request_of((ShadowMethod)m);
      request.settings.shadow_options = (ShadowOptions){.map_size_px = 64, .kernel_px = 3, .light_radius_m = 0.1f};
      Picture picture = picture_render(&scene, &camera, &request);
      bool sound = isfinite(odd[i].intensity) && vec3_is_finite(odd[i].position_world);
      if (sound) picture_assert_signal(&picture, 0.1);
      if (sound && m == SHADOWS_HYBRID) {
        request.settings.shadows = SHADOWS_RAYS;
        Picture rays = picture_render(&scene, &camera, &request);
        picture_assert_same(&rays, &picture);
        picture_free(&rays);
      }
      picture_free(&picture);
      scene_free(&scene);
    }
}

static void one_triangle_is_a_scene(void **state)
{
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(0.8, 0.8, 0.8), 0, 1));
  scene_add_triangle(&scene, white, (Vec3[]){{-3, 0, 3}, {3, 0, 3}, {0, 0, -3}},
                     (Vec3[]){{0, 1, 0}, {0, 1, 0}, {0, 1, 0}});
  scene_add_light(&scene, light_at(30, false));
  Camera camera = camera_above();
  PictureRequest request = request_of(SHADOWS_RAYS);
  Picture rays = picture_render(&scene, &camera, &request);
  for (int m = SHADOWS_MAP; m <= SHADOWS_HYBRID; m++) {
    request.settings.shadows = (ShadowMethod)m;
    Picture mapped = picture_render(&scene, &camera, &request);
    assert_true(share_wrong(&rays, &mapped) == 0);
    picture_free(&mapped);
  }
  picture_free(&rays);
  scene_free(&scene);
}

// Lights for whose maps there is no room are traced, and that is said.
static void lights_beyond_the_budget_are_traced(void **state)
{
  Camera camera = camera_above();
  Scene scene = scene_floor(true);
  for (int i = 0; i < 5; i++) scene_add_light(&scene, light_at(20 + 10 * i, true));
  PictureRequest request = request_of(SHADOWS_RAYS);
  Picture rays = picture_render(&scene, &camera, &request);
  for (int m = SHADOWS_MAP; m <= SHADOWS_HYBRID; m++) {
    request.settings.shadows = (ShadowMethod)m;
    request.settings.shadow_options = (ShadowOptions){.map_size_px = 256, .kernel_px = 3, .max_bytes = 1000};
    Picture mapped = picture_render(&scene, &camera, &request);
    picture_assert_same(&rays, &mapped);
    picture_free(&mapped);
  }
  picture_free(&rays);
  scene_free(&scene);
}

// Ten thousand lights: some have maps, and the picture is that of rays. (None in the plane of one of the box's walls:
// of such, hybrid shadows have been seen to tell one ray in 100 000 apart.)
static void ten_thousand_lights_are_lights(void **state)
{
  enum { LIGHTS = 10000 };
  Camera camera = camera_above();
  Scene scene = scene_floor(true);
  for (int i = 0; i < LIGHTS; i++)
    scene_add_light(&scene, light_point(vec3(i % 100 * 0.05 - 2.5, 1 + i / 100 * 0.02, 0.7), 0.01));
  PictureRequest request = picture_request(16, 9, 1);
  request.settings.shadows = SHADOWS_RAYS;
  Picture rays = picture_render(&scene, &camera, &request);
  picture_assert_signal(&rays, 0.1);
  request.settings.shadows = SHADOWS_HYBRID;
  request.settings.shadow_options = (ShadowOptions){.map_size_px = 32, .max_bytes = 50000000};
  Picture hybrid = picture_render(&scene, &camera, &request);
  picture_assert_same(&rays, &hybrid);
  picture_free(&hybrid);
  picture_free(&rays);
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_bare_plane_has_no_acne),
      cmocka_unit_test(the_error_of_a_map_falls_with_its_size),
      cmocka_unit_test(pcf_moves_no_edge),
      cmocka_unit_test(pcf_is_the_same_at_every_width),
      cmocka_unit_test(soft_shadows_without_a_radius_are_hard),
      cmocka_unit_test(odd_lights_spoil_nothing),
      cmocka_unit_test(one_triangle_is_a_scene),
      cmocka_unit_test(lights_beyond_the_budget_are_traced),
      cmocka_unit_test(ten_thousand_lights_are_lights),
      cmocka_unit_test(a_half_hidden_light_lights_by_its_visible_part),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
