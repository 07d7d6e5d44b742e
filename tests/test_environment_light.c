// The environment's light by samples, in pictures: against integrals over the hemisphere, with and without something in
// the way.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "scene/scene_defaults.h"
#include "support/oracle_environment.h"
#include "support/picture_fixture.h"
#include "support/scene_build.h"

static PictureRequest sampled_request(uint32_t width, uint32_t height, uint32_t samples)
{
  PictureRequest request = picture_request(width, height, samples);
  request.settings.environment_light = ENVIRONMENT_LIGHT_SAMPLED;
  request.settings.max_roughness = 1;
  return request;
}

static double component(Vec3 v, int channel) { return channel == 0 ? v.x : channel == 1 ? v.y : v.z; }

// Mean of a rectangle of a picture, and the standard error of it as its pixels tell.
typedef struct Mean {
  double value, error;
} Mean;

static Mean mean_of(const Picture *picture, uint32_t x, uint32_t y, uint32_t width, uint32_t height, int channel)
{
  double sum = 0, squares = 0, count = (double)width * height;
  for (uint32_t i = 0; i < width * height; i++) {
    double value = picture_pixel(picture, x + i % width, y + i / width)[channel];
    sum += value;
    squares += value * value;
  }
  double mean = sum / count, variance = fmax(squares / count - mean * mean, 0);
  return (Mean){mean, sqrt(variance / (count - 1))};
}

// 4.5 standard errors, and what the oracle's own grid may be off by.
static void mean_check(Mean got, double wanted, double oracle_error, const char *what)
{
  if (!(fabs(got.value - wanted) <= 4.5 * got.error + oracle_error * wanted))
    fail_msg("%s: %.6f +- %.6f, not %.6f", what, got.value, got.error, wanted);
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
        double wanted = radiance * component(vec3_add(albedo.diffuse, albedo.specular), c);
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

// What stands over the point: nothing, a black ball, or a black sheet that covers the whole sky.
typedef enum Cover { COVER_NONE, COVER_BALL, COVER_SHEET } Cover;
static const Vec3 ball_center = {1.1, 1.2, 0.4};
static const double ball_radius = 0.9, view_cosine = 0.6;

static void image_set(Scene *scene)
{
  enum { WIDTH = 32, HEIGHT = 16 };
  float colors[WIDTH * HEIGHT][3];
  for (int i = 0; i < WIDTH * HEIGHT; i++)
    for (int c = 0; c < 3; c++) colors[i][c] = (float)(0.7 + 0.6 * sin(0.9 * (i % WIDTH) + c) * cos(0.5 * (i / WIDTH)));
  for (int c = 0; c < 3; c++) colors[4 * WIDTH + 9][c] = 300;  // 45 degrees high, not behind the ball
  scene_set_image(scene, WIDTH, HEIGHT, (const float(*)[3])colors);
  scene->environment.rotation_rad = 0.7;
  scene->environment.intensity = 1.5f;
}

static Scene plane_scene(Material material)
{
  Scene scene = scene_empty();
  scene_add_quad(&scene, scene_add_material(&scene, material), vec3(-0.01, 0, 0.01), vec3(0.02, 0, 0),
                 vec3(0, 0, -0.02));
  return scene;
}

static Material black_unlit(void)
{
  Material material = material_plain(vec3(0, 0, 0), 0, 1);
  material.unlit = true;
  return material;
}

static void cover_add(Scene *scene, Cover cover, Material material)
{
  if (cover == COVER_NONE) return;
  int at = scene_add_material(scene, material);
  if (cover == COVER_BALL) scene_add_sphere(scene, at, ball_center, ball_radius, 96);
  if (cover == COVER_SHEET)
    scene_add_quad(scene, at, vec3(-1e4, 1, 1e4), vec3(2e4, 0, 0), vec3(0, 0, -2e4));  // faces up
}

static Vec3 plane_view(void)
{
  double sine = sqrt(1 - view_cosine * view_cosine);
  return vec3(sine * cos(2.5), view_cosine, sine * sin(2.5));
}

static bool ball_blocks(Vec3 direction)
{
  double along = vec3_dot(ball_center, direction), across2 = vec3_dot(ball_center, ball_center) - along * along;
  return along > 0 && across2 < ball_radius * ball_radius;
}

// BRDF x radiance x visibility x n.l over the hemisphere above the plane, by midpoints in y and azimuth.
static Vec3 lobes_integral(const Environment *environment, const OracleSurface *surface, Cover cover, bool diffuse)
{
  enum { ROWS = 640, COLUMNS = 1280 };
  Vec3 sum = {0}, n = vec3(0, 1, 0), view = plane_view();
  for (int i = 0; i < ROWS * COLUMNS; i++) {
    double y = (i / COLUMNS + 0.5) / ROWS, phi = 2 * M_PI * (i % COLUMNS + 0.5) / COLUMNS, ring = sqrt(1 - y * y);
    Vec3 l = vec3(ring * cos(phi), y, ring * sin(phi));
    if (cover == COVER_BALL && ball_blocks(l)) continue;
    OracleBrdf f = oracle_brdf(ORACLE_PBR, surface, n, view, l);
    Vec3 sends = vec3_mul(diffuse ? vec3_add(f.diffuse, f.specular) : f.specular, oracle_environment(environment, l));
    sum = vec3_add(sum, vec3_scale(sends, y * 2 * M_PI / (ROWS * COLUMNS)));
  }
  return sum;
}

static Vec3 plane_integral(const Environment *environment, const OracleSurface *surface, Cover cover)
{
  return lobes_integral(environment, surface, cover, true);
}

enum { PATCH = 16 };

static Picture plane_picture(const Scene *scene, const PictureRequest *request)
{
  Camera camera = camera_orthographic(vec3_scale(plane_view(), 0.5), vec3(0, 0, 0), 1e-4);
  return picture_render(scene, &camera, request);
}

static void plane_check(const Scene *scene, const PictureRequest *request, Vec3 wanted, const char *what)
{
  Picture picture = plane_picture(scene, request);
  for (int c = 0; c < 3; c++) {
    Mean got = mean_of(&picture, 0, 0, PATCH, PATCH, c);
    if (c == 1)
      print_message("%s, LANES %u: %.5f +- %.5f for %.5f\n", what, request->lanes, got.value, got.error,
                    component(wanted, c));
    mean_check(got, component(wanted, c), 1e-3, what);
  }
  picture_free(&picture);
}

static const OracleSurface half_metal = {
    .base = {0.9, 0.6, 0.2}, .alpha = 1, .metallic = 0.5, .roughness = 0.4, .occlusion = 1};

// A million samples under the image, where lobes reflect the scene and where they do not: the ball is closed, so that
// it is all the same.
static void light_past_a_ball_is_the_integral(void **state)
{
  static const char *const names[] = {"constant", "sky", "image"};
  Scene scene = plane_scene(material_plain(half_metal.base, half_metal.metallic, half_metal.roughness));
  cover_add(&scene, COVER_BALL, black_unlit());
  for (int kind = 0; kind < 3; kind++) {
    if (kind == 0) scene_set_constant(&scene, 0.5, 1, 2);
    if (kind == 1) scene_set_sky(&scene);
    if (kind == 2) image_set(&scene);
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
  Material sheet = black_unlit();
  for (int image = 0; image < 2; image++) {
    Scene scene = plane_scene(material_plain(metal.base, 1, metal.roughness));
    cover_add(&scene, COVER_SHEET, sheet);
    scene_set_constant(&scene, 0.5, 1, 2);
    if (image) image_set(&scene);
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
  Material sheet = black_unlit();
  sheet.alpha_mode = ALPHA_BLEND;
  sheet.base_color[3] = 0.25f;
  sheet.double_sided = true;
  cover_add(&scene, COVER_SHEET, sheet);
  image_set(&scene);
  Vec3 wanted = vec3_scale(plane_integral(&scene.environment, &half_metal, COVER_NONE), 0.75);
  PictureRequest request = sampled_request(PATCH, PATCH, 1024);
  plane_check(&scene, &request, wanted, "lobes");
  request.settings.max_roughness = 0;
  plane_check(&scene, &request, wanted, "no lobes");
  scene_free(&scene);
}

// A ball that glows alike in all directions, in a black environment: the specular lobe sees it, the diffuse one does
// not.
static void a_lobe_reflects_the_scene(void **state)
{
  const Environment glow = {.kind = ENVIRONMENT_CONSTANT, .constant = {0.5f, 1, 2}, .intensity = 1};
  Scene scene = plane_scene(material_plain(half_metal.base, half_metal.metallic, half_metal.roughness));
  Material ball = black_unlit();
  ball.emission[0] = 7;  // which an unlit material does not have
  for (int c = 0; c < 3; c++) ball.base_color[c] = glow.constant[c];
  cover_add(&scene, COVER_BALL, ball);
  Vec3 wanted = vec3_sub(lobes_integral(&glow, &half_metal, COVER_NONE, false),
                         lobes_integral(&glow, &half_metal, COVER_BALL, false));
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
      cmocka_unit_test(a_lobe_reflects_the_scene),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
