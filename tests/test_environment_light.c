// The environment's light by samples, in pictures: against integrals over the hemisphere, with and without something in
// the way.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "scene/scene_defaults.h"
#include "support/plane_lab.h"

static PictureRequest sampled_request(uint32_t width, uint32_t height, uint32_t samples)
{
  PictureRequest request = picture_request(width, height, samples);
  request.settings.environment_light = ENVIRONMENT_LIGHT_SAMPLED;
  request.settings.max_roughness = 1;
  return request;
}

// ---- the white furnace ----------------------------------------------------------------------------------------------

static const double metallics[] = {0, 0.5, 1}, roughnesses[] = {0, 0.05, 0.15, 0.3, 0.5, 0.75, 1};
static const Vec3 furnace_base = {1, 0.5, 0.02};
enum {
  METALLICS = 3,
  ROUGHNESSES = 7,
  TILE = 8,
  FURNACE_WIDTH = ROUGHNESSES * TILE,
  FURNACE_HEIGHT = METALLICS * TILE
};

// A quad in the plane y = 0 for each material; as seen by an orthographic camera at the cosine `n_dot_v`, TILE pixels
// wide and high.
static Scene furnace_scene(double n_dot_v)
{
  Scene scene = scene_empty();
  for (int m = 0; m < METALLICS; m++) {
    for (int r = 0; r < ROUGHNESSES; r++) {
      int material = scene_add_material(&scene, material_plain(furnace_base, metallics[m], roughnesses[r]));
      Vec3 corner = vec3(TILE * r - 0.5 * FURNACE_WIDTH, 0, (TILE * (m + 1) - 0.5 * FURNACE_HEIGHT) / n_dot_v);
      scene_add_quad(&scene, material, corner, vec3(TILE, 0, 0), vec3(0, 0, -TILE / n_dot_v));
    }
  }
  return scene;
}

// The oracle's midpoints miss what a narrow lobe sends below the horizon, about the fourth power of the roughness.
static void furnace_check(const Scene *scene, double n_dot_v, double radiance, uint32_t samples, uint32_t lanes)
{
  Camera camera = camera_orthographic(vec3(0, 100 * n_dot_v, 100 * sqrt(1 - n_dot_v * n_dot_v)), vec3(0, 0, 0),
                                      0.5 * FURNACE_HEIGHT);
  PictureRequest request = sampled_request(FURNACE_WIDTH, FURNACE_HEIGHT, samples);
  request.lanes = lanes;
  Picture picture = picture_render(scene, &camera, &request);
  double worst = 0;
  for (int m = 0; m < METALLICS; m++) {
    for (int r = 0; r < ROUGHNESSES; r++) {
      OracleSurface surface = {
          .base = furnace_base, .alpha = 1, .metallic = metallics[m], .roughness = roughnesses[r], .occlusion = 1};
      OracleBrdf albedo = oracle_albedo(ORACLE_PBR, &surface, n_dot_v, 256);
      for (int c = 0; c < 3; c++) {
        Mean got = mean_of(&picture, (uint32_t)(r * TILE), (uint32_t)(m * TILE), TILE, TILE, c);
        double wanted = radiance * plane_component(vec3_add(albedo.diffuse, albedo.specular), c);
        char what[128];
        snprintf(what, sizeof what, "metallic %g, roughness %g, n.v %g, channel %d", metallics[m], roughnesses[r],
                 n_dot_v, c);
        mean_check(got, wanted, 3e-4 + fmin(pow(roughnesses[r], 4), 1e-3), what);
        worst = fmax(worst, fabs(got.value / wanted - 1));
      }
    }
  }
  print_message("LANES %u, n.v %g, %u samples: albedos within %.4f\n", lanes, n_dot_v, samples * TILE * TILE, worst);
  picture_free(&picture);
}

static void a_white_furnace_shows_the_albedo_of_every_material(void **state)
{
  float white[8][3];
  for (int i = 0; i < 8; i++) white[i][0] = white[i][1] = white[i][2] = 0.5f;
  const double cosines[] = {0.95, 0.3};
  for (int i = 0; i < 2; i++) {
    Scene scene = furnace_scene(cosines[i]);
    scene_set_constant(&scene, 1.5, 1.5, 1.5);
    furnace_check(&scene, cosines[i], 1.5, 2048, 16);
    scene_set_image(&scene, 4, 2, (const float(*)[3])white);
    scene.environment.intensity = 3;
    furnace_check(&scene, cosines[i], 1.5, 2048, 16);
    furnace_check(&scene, cosines[i], 1.5, 128, 8);
    furnace_check(&scene, cosines[i], 1.5, 128, 1);
    scene_free(&scene);
  }
}

// ---- a point on a plane ---------------------------------------------------------------------------------------------

static const OracleSurface half_metal = {
    .base = {0.9, 0.6, 0.2}, .alpha = 1, .metallic = 0.5, .roughness = 0.4, .occlusion = 1};

// A million samples under the image, where lobes reflect the scene and where they do not: the ball is closed, so that
// it is all the same.
static void light_past_a_ball_is_the_integral(void **state)
{
  static const char *const names[] = {"constant", "sky", "image"};
  Scene scene = plane_scene(material_plain(half_metal.base, half_metal.metallic, half_metal.roughness));
  plane_add_cover(&scene, COVER_BALL, plane_black_unlit());
  for (int kind = 0; kind < 3; kind++) {
    if (kind == 0) scene_set_constant(&scene, 0.5, 1, 2);
    if (kind == 1) scene_set_sky(&scene);
    if (kind == 2) plane_set_image(&scene);
    Vec3 open = plane_integral(&scene.environment, &half_metal, COVER_NONE);
    Vec3 wanted = plane_integral(&scene.environment, &half_metal, COVER_BALL);
    assert_true(wanted.y < 0.97 * open.y);
    PictureRequest request = sampled_request(PATCH, PATCH, kind == 2 ? 4096 : 1024);
    request.lanes = 16;
    plane_check(&scene, &request, wanted, names[kind]);
    request.settings.max_roughness = 0.2f;
    plane_check(&scene, &request, wanted, names[kind]);
    request.settings.samples = 256;
    request.settings.max_roughness = 1;
    request.lanes = 8;
    plane_check(&scene, &request, wanted, names[kind]);
    request.lanes = 1;
    plane_check(&scene, &request, wanted, names[kind]);
  }
  scene_free(&scene);
}

// A single-sided sheet that turns its back to the plane: lobes that reflect the scene look through it, as camera rays
// do; to all other light it is closed. A metal has no other light, a rough dielectric under max_roughness nothing else.
static void back_faces_are_open_to_lobes_and_closed_to_light(void **state)
{
  const OracleSurface metal = {.base = {0.9, 0.6, 0.2}, .alpha = 1, .metallic = 1, .roughness = 0.4, .occlusion = 1};
  Material sheet = plane_black_unlit();
  for (int image = 0; image < 2; image++) {
    Scene scene = plane_scene(material_plain(metal.base, 1, metal.roughness));
    plane_add_cover(&scene, COVER_SHEET, sheet);
    scene_set_constant(&scene, 0.5, 1, 2);
    if (image) plane_set_image(&scene);
    PictureRequest request = sampled_request(PATCH, PATCH, 1024);
    plane_check(&scene, &request, plane_integral(&scene.environment, &metal, COVER_NONE), "a lobe");
    request.settings.max_roughness = 0;
    plane_check(&scene, &request, vec3(0, 0, 0), "no lobe");
    scene.materials[0].metallic = 0;
    scene.materials[0].roughness = 1;
    request.settings.max_roughness = 0.5f;
    plane_check(&scene, &request, vec3(0, 0, 0), "diffuse");
    scene.materials[1].double_sided = true;
    request.settings.max_roughness = 1;
    plane_check(&scene, &request, vec3(0, 0, 0), "closed");
    scene_free(&scene);
  }
}

// What BLEND lets through, it lets through to shadow rays and to reflected ones alike.
static void a_blend_sheet_weakens_the_environment(void **state)
{
  Scene scene = plane_scene(material_plain(half_metal.base, half_metal.metallic, half_metal.roughness));
  Material sheet = plane_black_unlit();
  sheet.alpha_mode = ALPHA_BLEND;
  sheet.base_color[3] = 0.25f;
  sheet.double_sided = true;
  plane_add_cover(&scene, COVER_SHEET, sheet);
  plane_set_image(&scene);
  Vec3 wanted = vec3_scale(plane_integral(&scene.environment, &half_metal, COVER_NONE), 0.75);
  PictureRequest request = sampled_request(PATCH, PATCH, 1024);
  plane_check(&scene, &request, wanted, "lobes");
  request.settings.max_roughness = 0;
  plane_check(&scene, &request, wanted, "no lobes");
  scene_free(&scene);
}

// Each of a hundred thin sheets of metal both lets through and reflects: more than there are streams to wait in.
static void many_blend_surfaces_may_reflect(void **state)
{
  Scene scene = scene_empty();
  Material sheet = material_plain(vec3(0.9, 0.9, 0.9), 1, 0.4);
  sheet.alpha_mode = ALPHA_BLEND;
  sheet.base_color[3] = 0.02f;
  sheet.double_sided = true;
  int at = scene_add_material(&scene, sheet);
  for (int i = 0; i < 100; i++) scene_add_quad(&scene, at, vec3(-2, -2, -0.02 * i), vec3(4, 0, 0), vec3(0, 4, 0));
  scene_set_sky(&scene);
  Camera camera = camera_perspective(vec3(0.5, 0.3, 3), vec3(0, 0, -1), 0.6);
  PictureRequest request = sampled_request(8, 8, 2);
  Picture picture = picture_render(&scene, &camera, &request);
  picture_assert_signal(&picture, 0.001);
  picture_free(&picture);
  scene_free(&scene);
}

// A ball that glows alike in all directions, in a black environment: the specular lobe sees it, the diffuse one does
// not.
static void a_lobe_reflects_the_scene(void **state)
{
  const Environment glow = {.kind = ENVIRONMENT_CONSTANT, .constant = {0.5f, 1, 2}, .intensity = 1};
  Scene scene = plane_scene(material_plain(half_metal.base, half_metal.metallic, half_metal.roughness));
  Material ball = plane_black_unlit();
  ball.emission[0] = 7;  // which an unlit material does not have
  for (int c = 0; c < 3; c++) ball.base_color[c] = glow.constant[c];
  plane_add_cover(&scene, COVER_BALL, ball);
  Vec3 wanted = vec3_sub(plane_lobes_integral(&glow, &half_metal, COVER_NONE, false),
                         plane_lobes_integral(&glow, &half_metal, COVER_BALL, false));
  PictureRequest request = sampled_request(PATCH, PATCH, 1024);
  for (int lanes = 16; lanes >= 1; lanes /= lanes == 16 ? 2 : 8) {
    request.lanes = (uint32_t)lanes;
    request.settings.max_roughness = 1;
    plane_check(&scene, &request, wanted, "the ball");
    request.settings.max_roughness = 0.3f;
    plane_check(&scene, &request, vec3(0, 0, 0), "nothing");
  }
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_white_furnace_shows_the_albedo_of_every_material),
      cmocka_unit_test(light_past_a_ball_is_the_integral),
      cmocka_unit_test(back_faces_are_open_to_lobes_and_closed_to_light),
      cmocka_unit_test(a_blend_sheet_weakens_the_environment),
      cmocka_unit_test(many_blend_surfaces_may_reflect),
      cmocka_unit_test(a_lobe_reflects_the_scene),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
