// --verify: probes that stand for the whole picture, intervals that hold what they say, and errors counted as
// image_compare counts them.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "app/verify.h"
#include "report/image_compare.h"
#include "scene/scene_build.h"
#include "support/picture_fixture.h"

enum { WIDTH = 250, HEIGHT = 141 };

static ProbeSet probes(uint32_t width, uint32_t height, uint64_t pixels, uint32_t seed)
{
  ProbeSet set;
  picture_assert_ok(probes_choose(&set, width, height, pixels, seed, &picture_log));
  return set;
}

static void probes_lie_in_the_picture_and_stand_for_all_of_it(void **state)
{
  static const uint64_t wanted[] = {1, 64, 65, 1000, 10000, 35000, 36864, 1u << 30};
  for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++) {
    ProbeSet set = probes(WIDTH, HEIGHT, wanted[k], 3), again = probes(WIDTH, HEIGHT, wanted[k], 3);
    double weight = 0;
    uint64_t pixels = 0;
    for (uint32_t i = 0; i < set.count; i++) {
      const Probe *probe = &set.probes[i];
      assert_true(probe->width > 0 && probe->height > 0 && probe->x % PROBE_SIDE == 0 && probe->y % PROBE_SIDE == 0);
      assert_true(probe->x + probe->width <= WIDTH && probe->y + probe->height <= HEIGHT);
      weight += probe->weight;
      pixels += probe->width * probe->height;
    }
    assert_true(fabs(weight - 1) < 1e-9);
    assert_true(set.count * 64 >= wanted[k] || set.all);
    assert_true(!set.all || pixels == WIDTH * HEIGHT);
    assert_int_equal(set.all, wanted[k] > 35000);
    assert_memory_equal(set.probes, again.probes, set.count * sizeof *set.probes);
    probes_free(&set);
    probes_free(&again);
  }
}

static void another_seed_probes_elsewhere(void **state)
{
  ProbeSet a = probes(WIDTH, HEIGHT, 4096, 1), b = probes(WIDTH, HEIGHT, 4096, 2);
  uint32_t same = 0;
  for (uint32_t i = 0; i < a.count; i++) same += a.probes[i].x == b.probes[i].x && a.probes[i].y == b.probes[i].y;
  assert_true(same < a.count / 2);
  probes_free(&a);
  probes_free(&b);
}

static void expect_interval(double hits, double trials, double low, double high)
{
  Proportion p = proportion_of_trials(hits, trials);
  if (fabs(p.low - low) > 1e-4 || fabs(p.high - high) > 1e-4)
    fail_msg("%g of %g: %g to %g, expected %g to %g", hits, trials, p.low, p.high, low, high);
}

// Of none of n the upper end is 1 - 0.025^(1 / n); the others are from tables of exact binomial limits (Diem, Lentner,
// "Documenta Geigy: Scientific Tables", 7th edition, 1970).
static void intervals_are_those_of_clopper_and_pearson(void **state)
{
  expect_interval(0, 10, 0, 1 - pow(0.025, 0.1));
  expect_interval(10, 10, pow(0.025, 0.1), 1);
  expect_interval(0, 100000, 0, 1 - pow(0.025, 1e-5));
  expect_interval(1, 10, 0.0025, 0.4450);
  expect_interval(5, 10, 0.1871, 0.8129);
  expect_interval(10, 100, 0.0490, 0.1762);
}

// A picture that is wrong along lines of `band` pixels, as shadow maps are. Returns the share.
static double lines_draw(float *picture, double band)
{
  size_t wrong = 0;
  for (int i = 0; i < WIDTH * HEIGHT; i++) {
    double x = i % WIDTH, y = (double)(i / WIDTH), ring = fabs(hypot(x - 120, y - 60) - 50),
           line = fabs(x - 2 * y + 90);
    bool off = ring < band / 2 || line < band;
    for (int c = 0; c < 4; c++) picture[4 * i + c] = off && c < 3 ? 0.5f : 1;
    wrong += off;
  }
  return (double)wrong / (WIDTH * HEIGHT);
}

// 95 % of the intervals must hold the true share; of 400 draws no fewer than 365 do with a probability of 0.999.
static void intervals_hold_the_true_share_as_often_as_they_say(void **state)
{
  static const double bands[] = {1, 4, 20};
  static const uint64_t pixels[] = {1024, 6400};
  static float picture[WIDTH * HEIGHT * 4], reference[WIDTH * HEIGHT * 4];
  for (int i = 0; i < WIDTH * HEIGHT * 4; i++) reference[i] = 1;
  for (int b = 0; b < 3; b++)
    for (int p = 0; p < 2; p++) {
      double share = lines_draw(picture, bands[b]), mean = 0;
      int held = 0, draws = 400;
      for (int seed = 0; seed < draws; seed++) {
        ProbeError error;
        ProbeSet set = probes(WIDTH, HEIGHT, pixels[p], (uint32_t)seed);
        picture_assert_ok(probe_error_make(&error, picture, reference, NULL, WIDTH, &set, &picture_log));
        held += error.off.low <= share && share <= error.off.high;
        mean += error.off.share / draws;
        assert_true(error.off.share <= error.dark.share && error.light.share <= 0);
        probes_free(&set);
      }
      if (held < 365) fail_msg("band %g, %d pixels: %d of %d hold", bands[b], (int)pixels[p], held, draws);
      // Without bias: off by no more than four standard errors of the mean of 400, each of which is off by less than
      // half of the share.
      if (fabs(mean - share) > 0.1 * share) fail_msg("band %g: mean %g, expected %g", bands[b], mean, share);
    }
}

// A step, a slope that is too flat and a tile of its own beyond a tile's rim.
static void edges_of_shadows_are_where_light_changes(void **state)
{
  enum { SIDE = 16 };
  float lit[SIDE * SIDE];
  bool edges[SIDE * SIDE];
  ProbeSet set = probes(SIDE, SIDE, SIDE * SIDE, 0);
  for (int i = 0; i < SIDE * SIDE; i++) {
    int x = i % SIDE, y = i / SIDE;
    lit[i] = y >= 8 ? 0.5f + 0.019f * (float)x : x < 3 ? 0 : 1;
  }
  probe_edges(edges, lit, SIDE, &set);
  for (int i = 0; i < SIDE * SIDE; i++)
    if (edges[i] != (i / SIDE < 8 && (i % SIDE == 2 || i % SIDE == 3))) fail_msg("pixel %d", i);
  probes_free(&set);
}

// Boxes on a floor in the sun.
static Scene scene_boxes(void)
{
  Scene scene = scene_empty();
  int white = scene_add_material(&scene, material_plain(vec3(0.8, 0.8, 0.8), 0, 1));
  scene_add_quad(&scene, white, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8));
  for (int i = 0; i < 9; i++) {
    Vec3 low = vec3(i % 3 * 1.5 - 2, 0, i / 3 * 1.6 - 2 + 0.2 * (i % 3));
    scene_add_box(&scene, white, low, vec3_add(low, vec3(0.3 + 0.03 * i, 0.4 + 0.1 * i, 0.4)));
  }
  scene_add_light(&scene, light_directional(vec3(-0.4, -0.7, -0.3), 3));
  return scene;
}

static const ShadowOptions coarse = {.map_size_px = 32, .kernel_px = 3};

// Renders as `frugal render` does, with these settings, and verifies.
static VerifyResult verified(const Scene *scene, const RenderSettings *settings, VerifyChoice choice, uint32_t seed)
{
  Device *device = picture_device(0);
  DeviceScene on_device = {0};
  Frame frame = {0};
  VerifyResult result;
  Camera camera = camera_perspective(vec3(0, 6, 5), vec3(0, 0, 0), 0.8);
  picture_assert_ok(device_scene_make(&on_device, device, scene, NULL, &picture_log));
  SceneFacts facts = {.light_count = on_device.light_count,
                      .triangle_count = on_device.triangle_count,
                      .has_mirrors = on_device.has_mirrors,
                      .least_roughness = on_device.least_roughness};
  FrameRequest request = {.camera = &camera,
                          .area = {settings->width, settings->height, 0, 0, settings->width, settings->height},
                          .samples = settings->samples,
                          .plan = plan_make(settings, &facts)};
  picture_assert_ok(frame_make(&frame, device, &on_device, &request, &picture_log));
  picture_assert_ok(frame_render(&frame, &picture_log));
  RenderOptions options = {.settings = *settings, .seed = seed, .verify = choice};
  PictureOptions picture = {.opaque = true};
  picture_assert_ok(verify_picture(&result, &(VerifySources){&options, &facts, &frame, &picture}, &picture_log));
  frame_free(&frame);
  device_scene_free(&on_device);
  return result;
}

static RenderSettings settings_of(ShadowMethod shadows)
{
  PictureRequest request = picture_request(WIDTH, HEIGHT, 2);
  request.settings.shadows = shadows;
  request.settings.shadow_options = coarse;
  return request.settings;
}

static void an_exact_picture_has_no_wrong_pixels(void **state)
{
  static const ShadowMethod exact[] = {SHADOWS_RAYS, SHADOWS_HYBRID};
  Scene scene = scene_boxes();
  for (int i = 0; i < 2; i++)
    for (int primary = PRIMARY_RASTER; primary <= PRIMARY_RAYS; primary++) {
      RenderSettings settings = settings_of(exact[i]);
      settings.primary = (PrimaryMethod)primary;
      VerifyResult result = verified(&scene, &settings, (VerifyChoice){.all = true}, 0);
      assert_true(result.error.off.share <= 0 && result.error.off.high <= 0 && result.error.pixels == WIDTH * HEIGHT);
      assert_true(result.edges.pixels > 100 && result.edges.off.high <= 0);
      result = verified(&scene, &settings, (VerifyChoice){.pixels = 1000}, 0);
      assert_true(result.error.off.share <= 0 && result.error.off.high > 0);
    }
  scene_free(&scene);
}

// The count of `frugal compare` for two whole pictures, and what probes say of it.
static void what_is_measured_is_what_a_comparison_counts(void **state)
{
  Scene scene = scene_boxes();
  Camera camera = camera_perspective(vec3(0, 6, 5), vec3(0, 0, 0), 0.8);
  PictureRequest request = {.settings = settings_of(SHADOWS_MAP)};
  Picture mapped = picture_render(&scene, &camera, &request);
  request.settings.shadows = SHADOWS_RAYS;
  Picture traced = picture_render(&scene, &camera, &request);
  // Alpha is a channel of an .exr and none of a display.
  for (int i = 0; i < WIDTH * HEIGHT; i++) mapped.radiance[i][3] = traced.radiance[i][3] = 1;
  Image a = {.width = WIDTH, .height = HEIGHT, .pixels = (float *)traced.radiance};
  Image b = {.width = WIDTH, .height = HEIGHT, .pixels = (float *)mapped.radiance};
  ImageError error;
  picture_assert_ok(image_compare(&error, &a, &b, NULL, &picture_log));
  assert_true(error.over_share > 0.005);
  RenderSettings settings = settings_of(SHADOWS_MAP);
  VerifyResult result = verified(&scene, &settings, (VerifyChoice){.all = true}, 0);
  assert_true(result.all && result.has_shadows && result.reference_samples == 2 && result.noise <= 0);
  // The device's sRGB curve and the host's round apart: one pixel in 10 000 may be at the threshold.
  assert_true(fabs(result.error.off.share - error.over_share) < 1e-4);
  assert_true(fabs(result.shadows.off.share - result.error.off.share) < 1e-9);
  double dark = result.shadows.dark.share, light = result.shadows.light.share;
  assert_true(dark > 0 && light > 0 && fabs(dark + light - result.shadows.off.share) < 1e-9);
  // What a map gets wrong is near edges: a larger share of few pixels, and no more of them.
  const ProbeError edges = result.edges;
  double edge_pixels = (double)edges.pixels, all_pixels = (double)result.shadows.pixels;
  assert_true(edge_pixels > 0.005 * all_pixels && edge_pixels < 0.3 * all_pixels);
  assert_true(edges.off.share > 3 * error.over_share && edges.off.share * edge_pixels <= error.over_share * all_pixels);
  assert_true(edges.dark.share > 0 && edges.light.share > 0);
  int held = 0, edges_held = 0;
  for (uint32_t seed = 0; seed < 8; seed++) {
    result = verified(&scene, &settings, (VerifyChoice){.pixels = 4096}, seed);
    assert_true(result.edges.pixels < result.shadows.pixels);
    edges_held += result.edges.off.low <= edges.off.share && edges.off.share <= result.edges.off.high;
    assert_true(!result.all && result.error.pixels > 3500 && result.error.off.high < 10 * error.over_share);
    held += result.error.off.low <= error.over_share && error.over_share <= result.error.off.high;
  }
  assert_true(held >= 7);  // of 8 at 95 %: fewer in 6 of 100 sets of seeds
  assert_true(edges_held >= 6);
  picture_free(&mapped);
  picture_free(&traced);
  scene_free(&scene);
}

// Without shadows everything that lies in one is too light, and nothing too dark.
static void shadows_left_out_are_all_too_light(void **state)
{
  Scene scene = scene_boxes();
  RenderSettings settings = settings_of(SHADOWS_NONE);
  VerifyResult result = verified(&scene, &settings, (VerifyChoice){.all = true}, 0);
  assert_true(result.has_shadows && result.shadows.light.share > 0.01 && result.shadows.dark.share <= 0);
  // On one side of each edge.
  assert_true(result.edges.light.share > 0.3 && result.edges.light.share < 0.7 && result.edges.dark.share <= 0);
  scene_free(&scene);
}

// A light with a size: the reference is the mean of many samples, and how far it is off is told.
static void a_soft_reference_is_averaged(void **state)
{
  Scene scene = scene_boxes();
  RenderSettings settings = settings_of(SHADOWS_RAYS);
  settings.shadow_options.light_angle_rad = 0.05;
  VerifyResult hard = verified(&scene, &settings, (VerifyChoice){.pixels = 2000}, 0);
  assert_int_equal(hard.reference_samples, VERIFY_SAMPLES);
  settings.shadows = SHADOWS_AREA;
  settings.samples = 64;
  VerifyResult soft = verified(&scene, &settings, (VerifyChoice){.pixels = 2000}, 0);
  assert_true(hard.noise > 0 && hard.noise < hard.error.off.share && soft.error.off.share < hard.error.off.share);
  scene_free(&scene);
}

// A light that is asked to be hard is measured as such, whatever size others are given.
static void a_light_is_measured_as_its_method_has_it(void **state)
{
  Scene scene = scene_boxes();
  int mirror = scene_add_material(&scene, material_plain(vec3(0.8, 0.8, 0.8), 1, 0));
  scene_add_quad(&scene, mirror, vec3(-4, 0, -3), vec3(8, 0, 0), vec3(0, 2, 0));
  scene_add_light(&scene, light_point(vec3(1, 3, 1), 20));
  RenderSettings settings = settings_of(SHADOWS_NONE);
  uint8_t methods[2] = {SHADOWS_RAYS, SHADOWS_RAYS};
  settings.light_shadows = methods;
  settings.shadow_options.light_angle_rad = 0.05;
  settings.reflections = REFLECTIONS_NONE;  // another fault, that is none of shadows
  VerifyResult hard = verified(&scene, &settings, (VerifyChoice){.pixels = 2000}, 0);
  assert_true(hard.reference_samples == 2 && hard.has_shadows && hard.shadows.off.share <= 0);
  assert_true(hard.error.off.share > 0);
  methods[1] = SHADOWS_NONE;
  VerifyResult open = verified(&scene, &settings, (VerifyChoice){.pixels = 2000}, 0);
  assert_true(open.shadows.light.share > 0.01 && open.shadows.dark.share <= 0);
  methods[0] = SHADOWS_AREA;
  VerifyResult soft = verified(&scene, &settings, (VerifyChoice){.pixels = 500}, 0);
  assert_int_equal(soft.reference_samples, VERIFY_SAMPLES);
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(probes_lie_in_the_picture_and_stand_for_all_of_it),
      cmocka_unit_test(another_seed_probes_elsewhere),
      cmocka_unit_test(intervals_are_those_of_clopper_and_pearson),
      cmocka_unit_test(intervals_hold_the_true_share_as_often_as_they_say),
      cmocka_unit_test(edges_of_shadows_are_where_light_changes),
      cmocka_unit_test(an_exact_picture_has_no_wrong_pixels),
      cmocka_unit_test(what_is_measured_is_what_a_comparison_counts),
      cmocka_unit_test(shadows_left_out_are_all_too_light),
      cmocka_unit_test(a_soft_reference_is_averaged),
      cmocka_unit_test(a_light_is_measured_as_its_method_has_it),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
