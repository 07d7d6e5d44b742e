#include "support/bound_sweep.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "app/verify.h"
#include "render/probe_render.h"
#include "render/reflection_bound.h"
#include "scene/scene_build.h"
#include "support/effort.h"
#include "support/mirrors.h"
#include "support/ratios.h"

enum { WIDTH = 160, HEIGHT = 120, CASES = 480, TILES = 4 };

static uint32_t random_state;

// Uniform in [low, high).
static double uniform(double low, double high)
{
  random_state = random_state * 1664525u + 1013904223u;
  uint32_t word = (random_state ^ random_state >> 16) * 2246822519u;
  return low + (high - low) * ((word ^ word >> 15) / 4294967296.0);
}

typedef enum Shape { BALL, SHEET, CAN, SHAPES } Shape;

// A mirror of any curvature in the middle of a room, which things stand about.
static Scene scene_random(Shape shape, double radius, double reach)
{
  Scene scene = scene_empty();
  int mirror = mirrors_material(&scene, false);
  double slant = uniform(-0.4, 0.4), width = uniform(0.5, 2), wall = uniform(2.5, 6);
  if (shape == BALL) scene_add_sphere(&scene, mirror, vec3(0, 0, 0), radius, 48);
  if (shape == SHEET)
    scene_add_quad(&scene, mirror, vec3(-radius, -radius, -slant * radius), vec3(2 * radius, 0, 0),
                   vec3(0, 2 * radius, 2 * slant * radius));
  if (shape == CAN) {
    uint32_t can = scene_add_sphere(&scene, mirror, vec3(0, 0, 0), radius, 48);
    scene.objects[can].world_from_object.m[0] *= width;
  }
  for (int i = 0; i < 6; i++) {
    Vec3 color = vec3(uniform(0.1, 0.9), uniform(0.1, 0.9), uniform(0.1, 0.9));
    int glow = scene_add_material(&scene, material_glowing(color));
    const Vec3 low = {-wall, -wall, -wall}, x = {2 * wall, 0, 0}, y = {0, 2 * wall, 0}, z = {0, 0, 2 * wall};
    const Vec3 sides[6][3] = {{low, y, z}, {vec3_add(low, x), z, y}, {low, z, x}, {vec3_add(low, y), x, z},
                              {low, x, y}, {vec3_add(low, z), y, x}};
    int dark = scene_add_material(&scene, material_glowing(vec3_scale(color, 0.5)));
    for (int tile = 0; tile < TILES * TILES; tile++) {
      int column = tile % TILES, row = tile / TILES;
      Vec3 u = vec3_scale(sides[i][1], 1.0 / TILES), v = vec3_scale(sides[i][2], 1.0 / TILES);
      Vec3 corner = vec3_add(sides[i][0], vec3_add(vec3_scale(u, column), vec3_scale(v, row)));
      scene_add_quad(&scene, (column + row) % 2 ? dark : glow, corner, u, v);
    }
  }
  for (int i = 0; i < 12; i++) {
    int glow =
        scene_add_material(&scene, material_glowing(vec3(uniform(0.05, 0.9), uniform(0.05, 0.9), uniform(0.05, 0.9))));
    double far = uniform(radius * 2, 0.95 * wall), turn = uniform(0, 2 * M_PI), size = uniform(0.05, 0.25) * far;
    Vec3 at = vec3(far * cos(turn), uniform(-0.8, 0.8) * far, far * sin(turn));
    if (at.z > 0 && at.z < 1.2 * reach + size && fabs(at.x) < 0.5 * at.z) continue;  // in the camera's way
    if (i % 2)
      scene_add_box(&scene, glow, vec3_sub(at, vec3(size, size, size)), vec3_add(at, vec3(size, 0.5 * size, size)));
    else
      scene_add_sphere(&scene, glow, at, size, 12);
  }
  return scene;
}

// Columns of slabs in turns of two colours, one object each, near the mirror.
static void columns_add(Scene *scene, double radius)
{
  enum { COLUMNS = 3, SLABS = 10 };
  for (int i = 0; i < COLUMNS; i++) {
    double far = uniform(2, 3.5) * radius, turn = uniform(0.9, 2 * M_PI - 0.9), half = 0.3 * radius,
           step = 0.2 * radius;
    Vec3 foot = vec3(far * sin(turn), uniform(-1.5, -0.5) * radius, far * cos(turn));
    int colors[2];
    for (int k = 0; k < 2; k++)
      colors[k] = scene_add_material(
          scene, material_glowing(vec3(uniform(0.05, 0.4) + 0.5 * k, uniform(0.05, 0.9), uniform(0.05, 0.9))));
    for (int k = 0; k < SLABS; k++) {
      Vec3 low = vec3_add(foot, vec3(-half, k * step, -half));
      scene_add_box(scene, colors[k % 2], low, vec3_add(low, vec3(2 * half, step, 2 * half)));
      if (k) scene_join_last(scene);
    }
  }
}

typedef struct Case {
  double measured, expected, bound;
} Case;

static Case case_measure(const Scene *scene, const Camera *camera, const RenderSettings *settings)
{
  Device *device = picture_device(0);
  DeviceScene on_device = {0};
  Frame frame = {0};
  VerifyResult result;
  ReflectionBound bound;
  const PictureOptions picture = {.opaque = true};
  const RenderOptions options = {.settings = *settings, .verify = {.all = true}};
  picture_assert_ok(device_scene_make(&on_device, device, scene, NULL, &picture_log));
  SceneFacts facts = {.triangle_count = on_device.triangle_count, .has_mirrors = true, .least_roughness = INFINITY};
  FrameRequest request = {.camera = camera,
                          .area = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT},
                          .samples = settings->samples,
                          .plan = plan_make(settings, &facts)};
  picture_assert_ok(frame_make(&frame, device, &on_device, &request, &picture_log));
  picture_assert_ok(reflection_bound_make(&bound, &frame, 1, &picture_log));
  picture_assert_ok(frame_render(&frame, &picture_log));
  picture_assert_ok(verify_picture(&result, &(VerifySources){&options, &facts, &frame, &picture}, &picture_log));
  // One reflector: what is said of it is said of the picture.
  const int rung = (int)(settings->reflections - REFLECTIONS_ENVIRONMENT);
  assert_int_equal(bound.count, 1);
  assert_true(fabs(bound.reflectors[0].rungs[rung].expected - bound.rungs[rung].expected) < 1e-9);
  Case out = {result.error.off.share, bound.rungs[rung].expected, bound.rungs[rung].bound};
  reflection_bound_free(&bound);
  frame_free(&frame);
  device_scene_free(&on_device);
  return out;
}

// One of the sweep's pictures: shape and curvature of the mirror, distance of the camera, what stands about it, and the
// map's size all vary.
static Case case_random(ReflectionMethod method, int number, uint32_t samples)
{
  random_state = (uint32_t)number * 7919 + 1;
  Shape shape = (Shape)(number % SHAPES);
  double radius = uniform(0.15, 0.9), reach = uniform(2.5, 5) * radius;
  PictureRequest request = mirrors_request(WIDTH, method, 32u << (uint32_t)uniform(0, 5));
  request.settings.height = HEIGHT;
  request.settings.samples = samples;
  Scene scene = scene_random(shape, radius, reach);
  Vec3 eye = vec3(uniform(-0.3, 0.3) * reach, uniform(-0.3, 0.3) * reach, reach);
  Camera camera = camera_perspective(eye, vec3(0, 0, 0), 2.2 * atan(radius / reach));
  camera.znear_m = 0.01;
  if (reflections_use_lists(method)) {
    columns_add(&scene, radius);
    request.settings.cubes.near_radius_m = (float)(uniform(2, 6) * radius);
    request.settings.cubes.complex_from = 100;  // columns and balls, not boxes
  }
  Case c = case_measure(&scene, &camera, &request.settings);
  if (getenv("FRUGAL_SHOW_CASES"))
    printf("%d: %s, shape %d, map %u: measured %.5f, expected %.5f, bound %.5f: %.2f\n", number,
           reflections_name(method), shape, request.settings.cubes.size_px, c.measured, c.expected, c.bound,
           c.bound / c.measured);
  scene_free(&scene);
  return c;
}

static int cases_of(int usual_count)
{
  return effort_is_full() ? CASES : effort_is_quick() ? usual_count / 4 : usual_count;
}

void bound_sweep(ReflectionMethod method, uint32_t samples, int usual_count)
{
  static double ratios[CASES];
  int missed = 0, some = 0, count = cases_of(usual_count);
  for (int i = 0; i < count; i++) {
    Case c = case_random(method, i, samples);
    missed += c.bound < c.measured;
    if (c.measured > 0) ratios[some++] = c.bound / c.measured;
  }
  ratios_report(reflections_name(method), ratios, some, missed, count, 0.01);
}

void bound_sweep_exact(ReflectionMethod method, double bound_most, int usual_count)
{
  int missed = 0, count = cases_of(usual_count);
  double worst = 0;
  for (int i = 0; i < count; i++) {
    Case c = case_random(method, i, 1);
    missed += c.bound < c.measured;
    worst = fmax(worst, c.measured);
    assert_true(c.expected == 0 && c.bound <= bound_most);
  }
  print_message("%s: %d of %d beyond the bound, worst %.6f\n", reflections_name(method), missed, count, worst);
  assert_true(missed <= 0.01 * count);
}

// ---- rough reflectors -----------------------------------------------------------------------------------------------

enum { ROUGH_WIDTH = 48, ROUGH_HEIGHT = 36, ROUGH_PIXELS = ROUGH_WIDTH * ROUGH_HEIGHT };
enum { ROUGH_RUNGS = BOUND_IMPOSTOR + 1 };  // rungs with lists answer as the impostor does

// A picture whose samples are all in the pixels' centres.
static void centre_picture(float pixels[ROUGH_PIXELS][4], const DeviceScene *scene, const SceneFacts *facts,
                           const Camera *camera, const RenderSettings *settings, uint32_t samples,
                           ReflectionBound *bound)
{
  Frame frame = {0};
  FrameRequest request = {.camera = camera,
                          .area = {ROUGH_WIDTH, ROUGH_HEIGHT, 0, 0, ROUGH_WIDTH, ROUGH_HEIGHT},
                          .samples = samples,
                          .plan = plan_make(settings, facts)};
  float(*centres)[2] = malloc(samples * sizeof *centres);
  assert_non_null(centres);
  for (uint32_t i = 0; i < samples; i++) centres[i][0] = centres[i][1] = 0.5f;
  picture_assert_ok(frame_make(&frame, picture_device(0), scene, &request, &picture_log));
  picture_assert_ok(
      buffer_write(picture_device(0), &frame.camera.offsets, centres, samples * sizeof *centres, &picture_log));
  if (bound) picture_assert_ok(reflection_bound_make(bound, &frame, 1, &picture_log));
  picture_assert_ok(frame_render(&frame, &picture_log));
  picture_assert_ok(picture_shown(pixels[0], &frame, &(PictureOptions){.opaque = true}, &picture_log));
  frame_free(&frame);
  free(centres);
}

static double share_off(float a[ROUGH_PIXELS][4], float b[ROUGH_PIXELS][4])
{
  int off = 0;
  for (int i = 0; i < ROUGH_PIXELS; i++) {
    float most = 0;
    for (int c = 0; c < 3; c++) most = fmaxf(most, fabsf(a[i][c] - b[i][c]));
    off += most > 2.0f / 255;
  }
  return off / (double)ROUGH_PIXELS;
}

// All rungs of one of the sweep's pictures, of which roughness and material vary besides.
static void rough_case(Case out[ROUGH_RUNGS], int number)
{
  static float reference[ROUGH_PIXELS][4], shown[ROUGH_PIXELS][4];
  DeviceScene scene = {0};
  ReflectionBound bound;
  random_state = (uint32_t)number * 7919 + 1;
  double radius = uniform(0.15, 0.9), reach = uniform(2.5, 5) * radius;
  Scene model = scene_random((Shape)(number % SHAPES), radius, reach);
  Vec3 eye = vec3(uniform(-0.3, 0.3) * reach, uniform(-0.3, 0.3) * reach, reach);
  Camera camera = camera_perspective(eye, vec3(0, 0, 0), 2.2 * atan(radius / reach));
  camera.znear_m = 0.01;
  Material *material = &model.materials[0];
  material->roughness = (float)uniform(0.05, 1);
  material->metallic = number % 4 ? 1 : 0;
  const SceneFacts facts = {.least_roughness = material->roughness};
  picture_assert_ok(device_scene_make(&scene, picture_device(0), &model, NULL, &picture_log));
  RenderSettings settings = mirrors_request(ROUGH_WIDTH, REFLECTIONS_RAYS, 32u << (uint32_t)uniform(0, 4)).settings;
  settings.height = ROUGH_HEIGHT;
  settings.max_roughness = 1;
  centre_picture(reference, &scene, &facts, &camera, &settings, effort_is_full() ? 8192 : 4096, NULL);
  for (int rung = ROUGH_RUNGS - 1; rung >= 0; rung--) {
    settings.reflections = REFLECTIONS_ENVIRONMENT + rung;
    settings.max_roughness = rung == BOUND_ENVIRONMENT ? 0 : 1;
    const bool first = rung == ROUGH_RUNGS - 1;
    centre_picture(shown, &scene, &facts, &camera, &settings, 1, first ? &bound : NULL);
    out[rung] = (Case){share_off(reference, shown), bound.rungs[rung].expected, bound.rungs[rung].bound};
    if (getenv("FRUGAL_SHOW_CASES"))
      printf("%d: %s, shape %d, roughness %.2f, metallic %g, map %u: measured %.5f, expected %.5f, bound %.5f: %.2f\n",
             number, reflections_name(settings.reflections), number % SHAPES, (double)material->roughness,
             (double)material->metallic, settings.cubes.size_px, out[rung].measured, out[rung].expected,
             out[rung].bound, out[rung].bound / out[rung].measured);
  }
  reflection_bound_free(&bound);
  device_scene_free(&scene);
  scene_free(&model);
}

void bound_sweep_rough(int usual_count)
{
  static Case cases[CASES][ROUGH_RUNGS];
  static double ratios[CASES];
  const int count = effort_is_full() ? CASES / 2 : effort_is_quick() ? usual_count / 4 : usual_count;
  for (int i = 0; i < count; i++) rough_case(cases[i], i);
  for (int rung = 0; rung < ROUGH_RUNGS; rung++) {
    int missed = 0, some = 0;
    for (int i = 0; i < count; i++) {
      const Case *c = &cases[i][rung];
      missed += c->bound < c->measured;
      if (c->measured > 0) ratios[some++] = c->bound / c->measured;
    }
    ratios_report(reflections_name(REFLECTIONS_ENVIRONMENT + rung), ratios, some, missed, count, 0.01);
  }
}
