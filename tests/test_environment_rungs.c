// The environment's light by less than samples, and what more samples are worth.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "device_scene/environment_levels.h"
#include "scene/scene_build.h"
#include "scene/scene_defaults.h"
#include "shared/scene.h"
#include "support/gltf_build.h"
#include "support/oracle_environment.h"
#include "support/plane_lab.h"

// ---- prefiltered levels ---------------------------------------------------------------------------------------------

static Vec3 level_direction(int level, int row, int column)
{
  double width = ENVIRONMENT_LEVEL_WIDTH(level), phi = 2 * M_PI * ((column + 0.5) / width - 0.5);
  double theta = M_PI * (row + 0.5) / (width / 2);
  return vec3(cos(phi) * sin(theta), cos(theta), sin(phi) * sin(theta));
}

// The mean of what the level is to hold about n, by midpoints of half vectors.
static Vec3 level_wanted(const Environment *environment, int level, Vec3 n)
{
  enum { CELLS = 160 };
  Vec3 sum = {0}, across = vec3_unit_or(vec3_cross(n, fabs(n.x) < 0.5 ? vec3(1, 0, 0) : vec3(0, 1, 0)), n);
  Vec3 along = vec3_cross(n, across);
  double alpha2 = pow(4, -level), weights = 0;
  for (int i = 0; i < CELLS * CELLS; i++) {
    double share = (i / CELLS + 0.5) / CELLS, phi = 2 * M_PI * (i % CELLS + 0.5) / CELLS;
    double cosine2 = (1 - share) / (1 + (alpha2 - 1) * share), sine = sqrt(1 - cosine2), up = 2 * cosine2 - 1;
    if (up <= 0) continue;
    Vec3 side = vec3_add(vec3_scale(across, cos(phi)), vec3_scale(along, sin(phi)));
    Vec3 l = vec3_add(vec3_scale(n, up), vec3_scale(side, 2 * sqrt(cosine2) * sine));
    sum = vec3_add(sum, vec3_scale(oracle_environment(environment, l), up));
    weights += up;
  }
  return vec3_scale(sum, 1 / weights);
}

// Steps between two colours, 64 pixels wide.
static Scene steps_scene(void)
{
  enum { WIDTH = 64, HEIGHT = 32 };
  float colors[WIDTH * HEIGHT][3];
  Scene scene = scene_empty();
  for (int i = 0; i < WIDTH * HEIGHT; i++)
    for (int c = 0; c < 3; c++) colors[i][c] = (float)(0.5 + ((i % WIDTH / (9 + c) + i / WIDTH / 11) & 1));
  scene_set_image(&scene, WIDTH, HEIGHT, (const float(*)[3])colors);
  return scene;
}

// Between 0.5 and 1.5: a few hundredths come from samples that are few, and from edges that the finest image blurs.
static void levels_hold_the_mean_over_their_lobe(void **state)
{
  Log log = {0};
  Scene scene = steps_scene();
  EnvironmentLevels levels;
  assert_int_equal(environment_levels_make(&levels, &scene.environment, 0, &log), STATUS_OK);
  assert_int_equal(levels.count, 4 * ENVIRONMENT_LEVEL_FIRST(ENVIRONMENT_LEVELS));
  for (int level = 0; level < ENVIRONMENT_LEVELS; level++) {
    int width = ENVIRONMENT_LEVEL_WIDTH(level);
    double worst = 0, mean = 0;
    enum { PLACES = 60 };
    for (int i = 0; i < PLACES; i++) {
      int row = i * (width / 2 - 1) / (PLACES - 1), column = i * 37 % width;
      const float *pixel = levels.pixels + 4 * (ENVIRONMENT_LEVEL_FIRST(level) + row * width + column);
      Vec3 wanted = level_wanted(&scene.environment, level, level_direction(level, row, column));
      for (int c = 0; c < 3; c++) {
        double error = fabs(pixel[c] - plane_component(wanted, c));
        mean += error / (3 * PLACES);
        worst = fmax(worst, error);
      }
    }
    print_message("level %d: %.4f in the mean, %.3f at worst\n", level, mean, worst);
    assert_true(mean < 0.02 && worst < 0.12);
  }
  environment_levels_free(&levels);
  scene_free(&scene);
}

// White stays white, whatever the weights; levels that no surface reads are not made.
static void levels_lose_no_light_and_are_no_more_than_needed(void **state)
{
  Log log = {0};
  float white[6][3];
  Scene scene = scene_empty();
  for (int i = 0; i < 6; i++) white[i][0] = white[i][1] = white[i][2] = 2;
  scene_set_image(&scene, 3, 2, (const float(*)[3])white);
  static const struct {
    float least_roughness;
    int levels;
  } needs[] = {{0, 7}, {0.1f, 7}, {0.125f, 7}, {0.2f, 6}, {0.5f, 4}, {0.6f, 3}, {1, 2}};
  for (size_t i = 0; i < sizeof needs / sizeof *needs; i++) {
    EnvironmentLevels levels;
    assert_int_equal(environment_levels_make(&levels, &scene.environment, needs[i].least_roughness, &log), STATUS_OK);
    assert_int_equal(levels.count, 4 * ENVIRONMENT_LEVEL_FIRST(needs[i].levels));
    for (size_t k = 0; k < levels.count; k++)
      if (k % 4 < 3 && !(fabs(levels.pixels[k] - 2) < 1e-4)) fail_msg("value %zu: %g", k, levels.pixels[k]);
    environment_levels_free(&levels);
  }
  scene_free(&scene);
}

// ---- pictures -------------------------------------------------------------------------------------------------------

static const OracleSurface rough = {
    .base = {0.8, 0.6, 0.4}, .alpha = 1, .metallic = 0.25, .roughness = 0.5, .occlusion = 1};

static Scene rough_plane(void) { return plane_scene(material_plain(rough.base, rough.metallic, rough.roughness)); }

static Vec3 picture_mean(const Scene *scene, EnvironmentLightMethod method, uint32_t lanes)
{
  PictureRequest request = picture_request(PATCH, PATCH, 64);
  request.settings.environment_light = method;
  request.lanes = lanes;
  Picture picture = plane_picture(scene, &request);
  Vec3 mean = vec3(mean_of(&picture, 0, 0, PATCH, PATCH, 0).value, mean_of(&picture, 0, 0, PATCH, PATCH, 1).value,
                   mean_of(&picture, 0, 0, PATCH, PATCH, 2).value);
  picture_free(&picture);
  return mean;
}

static void assert_means_near(Vec3 got, Vec3 wanted, double relative, const char *what)
{
  for (int c = 0; c < 3; c++)
    if (!(fabs(plane_component(got, c) - plane_component(wanted, c)) <= relative * plane_component(wanted, c)))
      fail_msg("%s, channel %d: %g, not %g", what, c, plane_component(got, c), plane_component(wanted, c));
}

// As a constant environment of the image's mean radiance would.
static void ambient_light_is_the_mean_from_everywhere(void **state)
{
  Scene scene = rough_plane();
  plane_set_image(&scene);
  OracleDome dome = oracle_dome_make(&scene.environment, 64, 4);
  Vec3 mean = {0};
  for (uint32_t i = 0; i < dome.cell_count; i++) mean = vec3_add(mean, vec3_scale(dome.cells[i][1], 1 / (4 * M_PI)));
  oracle_dome_free(&dome);
  for (uint32_t lanes = 1; lanes <= 16; lanes += lanes == 1 ? 7 : 8) {
    Vec3 got = picture_mean(&scene, ENVIRONMENT_LIGHT_AMBIENT, lanes);
    Scene even = rough_plane();
    scene_set_constant(&even, mean.x, mean.y, mean.z);
    assert_means_near(got, picture_mean(&even, ENVIRONMENT_LIGHT_SH, lanes), 5e-3, "ambient");
    scene_free(&even);
  }
  scene_free(&scene);
}

static void none_of_the_environment_lights_surfaces_then(void **state)
{
  Scene scene = rough_plane();
  plane_set_image(&scene);
  Vec3 got = picture_mean(&scene, ENVIRONMENT_LIGHT_NONE, 0);
  assert_true(got.x == 0 && got.y == 0 && got.z == 0);
  scene_free(&scene);
}

// Share of the cosine-weighted hemisphere that the ball leaves open.
static double open_share(void)
{
  const Environment white = {.kind = ENVIRONMENT_CONSTANT, .constant = {1, 1, 1}, .intensity = 1};
  const OracleSurface diffuse = {.base = {1, 1, 1}, .alpha = 1, .metallic = 0, .roughness = 0, .occlusion = 1};
  return plane_integral(&white, &diffuse, COVER_BALL).x / plane_integral(&white, &diffuse, COVER_NONE).x;
}

// The ball stands within a tenth of the scene's size or not, by what lies far away. 16 x 16 pixels of 64 samples of 4
// rays are good to half a percent; the diffuse term's Fresnel factor, which the share has and occlusion has not, to
// another.
static void occlusion_is_the_share_that_near_things_leave(void **state)
{
  double share = open_share();
  assert_true(share < 0.95);
  for (int far = 0; far < 2; far++) {
    Scene scene = rough_plane();
    scene_set_sky(&scene);
    Vec3 open = picture_mean(&scene, ENVIRONMENT_LIGHT_SH, 0);
    plane_add_cover(&scene, COVER_BALL, plane_black_unlit());
    if (far) scene_add_quad(&scene, 0, vec3(0, -100, 0), vec3(0.1, 0, 0), vec3(0, 0, -0.1));
    assert_means_near(picture_mean(&scene, ENVIRONMENT_LIGHT_SH, 0), open, 1e-5, "harmonics");
    for (uint32_t lanes = 1; lanes <= 16; lanes += lanes == 1 ? 7 : 8)
      assert_means_near(picture_mean(&scene, ENVIRONMENT_LIGHT_SH_AO, lanes), vec3_scale(open, far ? share : 1),
                        far ? 0.01 : 1e-5, far ? "near ball" : "ball out of reach");
    scene_free(&scene);
  }
}

// ---- samples --------------------------------------------------------------------------------------------------------

static double rmse(const Picture *a, const Picture *b)
{
  double sum = 0;
  size_t pixels = (size_t)a->width * a->height;
  for (size_t i = 0; i < pixels; i++)
    for (int c = 0; c < 3; c++) sum += pow((double)a->radiance[i][c] - b->radiance[i][c], 2);
  return sqrt(sum / (3 * (double)pixels));
}

// A ball of metal and one of plastic on a table, under a bare sun of 83 000 among grass of 0.3. Random samples would
// give a slope of -1/2.
static void noise_falls_at_least_as_the_root_of_the_samples(void **state)
{
  const char *assets = gltf_assets();
  if (!assets) skip();
  char path[1024];
  snprintf(path, sizeof path, "%s/Environments/kloppenheim_05_1k.hdr", assets);
  Scene scene = scene_empty();
  picture_assert_ok(picture_read_image(&scene.environment.image, path));
  scene.environment.kind = ENVIRONMENT_IMAGE;
  scene_add_quad(&scene, scene_add_material(&scene, material_plain(vec3(0.6, 0.55, 0.5), 0, 0.7)), vec3(-4, 0, 4),
                 vec3(8, 0, 0), vec3(0, 0, -8));
  scene_add_sphere(&scene, scene_add_material(&scene, material_plain(vec3(0.9, 0.6, 0.3), 1, 0.45)), vec3(0, 0.6, 0),
                   0.6, 32);
  scene_add_sphere(&scene, scene_add_material(&scene, material_plain(vec3(0.2, 0.4, 0.8), 0, 0.3)),
                   vec3(1.1, 0.35, 0.5), 0.35, 32);
  Camera camera = camera_perspective(vec3(1, 1.6, 4), vec3(0.3, 0.3, 0), 0.6);
  PictureRequest request = picture_request(48, 32, 4096);
  request.settings.environment_light = ENVIRONMENT_LIGHT_SAMPLED;
  request.settings.max_roughness = 1;
  Picture truth = picture_render(&scene, &camera, &request);
  enum { STEPS = 4 };
  double sum = 0, slope = 0;  // of the line through the logarithms, in steps of 4
  for (int step = 0; step < STEPS; step++) {
    request.settings.samples = 4u << (2 * step);
    request.seed = (uint32_t)step + 1;
    Picture picture = picture_render(&scene, &camera, &request);
    double error = rmse(&picture, &truth), place = step - 0.5 * (STEPS - 1);
    print_message("%u samples: RMSE %.4f\n", request.settings.samples, error);
    slope += place * log(error) / log(4);
    sum += place * place;
    picture_free(&picture);
  }
  slope /= sum;
  print_message("slope %.3f\n", slope);
  assert_true(slope < -0.45 && slope > -1.2);
  picture_free(&truth);
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(levels_hold_the_mean_over_their_lobe),
      cmocka_unit_test(levels_lose_no_light_and_are_no_more_than_needed),
      cmocka_unit_test(ambient_light_is_the_mean_from_everywhere),
      cmocka_unit_test(none_of_the_environment_lights_surfaces_then),
      cmocka_unit_test(occlusion_is_the_share_that_near_things_leave),
      cmocka_unit_test(noise_falls_at_least_as_the_root_of_the_samples),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
