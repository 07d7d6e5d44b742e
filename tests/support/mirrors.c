#include "support/mirrors.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "render/probe_render.h"
#include "scene/scene_build.h"

PictureRequest mirrors_request(uint32_t side, ReflectionMethod method, uint32_t cube_px)
{
  PictureRequest request = picture_request(side, side, 1);
  request.settings.reflections = method;
  request.settings.cubes.size_px = cube_px;
  return request;
}

int mirrors_material(Scene *scene, bool double_sided)
{
  Material mirror = material_plain(vec3(0.9, 0.9, 0.9), 1, 0);
  mirror.double_sided = double_sided;
  return scene_add_material(scene, mirror);
}

void mirrors_sky(Scene *scene)
{
  enum { WIDTH = 512, HEIGHT = 256 };
  float(*colors)[3] = calloc((size_t)WIDTH * HEIGHT, sizeof *colors);
  assert_non_null(colors);
  for (int i = 0; i < WIDTH * HEIGHT; i++) {
    double p = 2 * M_PI * ((i % WIDTH + 0.5) / WIDTH - 0.5), t = M_PI * (i / WIDTH + 0.5) / HEIGHT;
    colors[i][0] = (float)(2 + cos(p) * sin(t));
    colors[i][1] = (float)(2 + cos(t));
    colors[i][2] = (float)(2 + sin(p) * sin(t));
  }
  scene_set_image(scene, WIDTH, HEIGHT, (const float(*)[3])colors);
  free(colors);
}

double mirrors_difference(const Picture *a, const Picture *b, size_t i)
{
  double most = 0;
  for (int c = 0; c < 4; c++) most = fmax(most, fabs((double)a->radiance[i][c] - (double)b->radiance[i][c]));
  return most;
}

// Does the picture show one thing there: does no neighbour within `reach` differ?
static bool is_even(const Picture *picture, size_t i, int reach)
{
  int x = (int)(i % picture->width), y = (int)(i / picture->width);
  for (int dy = -reach; dy <= reach; dy++)
    for (int dx = -reach; dx <= reach; dx++) {
      int column = x + dx, row = y + dy;
      if (column < 0 || row < 0 || column >= (int)picture->width || row >= (int)picture->height) continue;
      const float *there = picture->radiance[(size_t)row * picture->width + (size_t)column];
      // Schlick's weight changes from pixel to pixel; surfaces here differ by far more.
      for (int c = 0; c < 3; c++)
        if (fabs((double)there[c] - (double)picture->radiance[i][c]) > 0.15) return false;
    }
  return true;
}

size_t mirrors_even_wrong(const Picture *rays, const Picture *maps, int reach, double most, size_t *even)
{
  size_t wrong = 0;
  *even = 0;
  for (size_t i = 0; i < (size_t)rays->width * rays->height; i++) {
    if (!is_even(rays, i, reach)) continue;
    ++*even;
    wrong += mirrors_difference(rays, maps, i) > most;
  }
  return wrong;
}

static const Vec3 room_low = {-1.9, -1.2, -2.3}, room_high = {2.4, 1.6, 1.7};

Scene mirrors_room(void)
{
  enum { TILES = 4 };
  static const double colors[6][3] = {{3, 1, 1}, {1, 3, 1}, {1, 1, 3}, {3, 3, 1}, {1, 3, 3}, {3, 1, 3}};
  Scene scene = scene_empty();
  Vec3 low = room_low, size = vec3_sub(room_high, room_low);
  const Vec3 x = {size.x, 0, 0}, y = {0, size.y, 0}, z = {0, 0, size.z};
  const Vec3 walls[6][3] = {{low, y, z}, {vec3_add(low, x), z, y}, {low, z, x}, {vec3_add(low, y), x, z},
                            {low, x, y}, {vec3_add(low, z), y, x}};
  for (int i = 0; i < 6 * TILES * TILES; i++) {
    const Vec3 *wall = walls[i / (TILES * TILES)];
    const double *color = colors[i / (TILES * TILES)];
    int column = i % TILES, row = i / TILES % TILES;
    double share = (column + row) % 2 ? 0.5 : 1;
    Vec3 u = vec3_scale(wall[1], 1.0 / TILES), v = vec3_scale(wall[2], 1.0 / TILES);
    Vec3 corner = vec3_add(wall[0], vec3_add(vec3_scale(u, column), vec3_scale(v, row)));
    int glow = scene_add_material(&scene, material_glowing(vec3_scale(vec3(color[0], color[1], color[2]), share)));
    scene_add_quad(&scene, glow, corner, u, v);
  }
  return scene;
}

// Makes a frame of the picture, and renders it where that is wanted.
static void frame_of(Frame *frame, DeviceScene *device_scene, const Scene *scene, const Camera *camera,
                     const RenderSettings *settings, bool rendered)
{
  Device *device = picture_device(0);
  Log log = {0};
  picture_assert_ok(device_scene_make(device_scene, device, scene, NULL, &log));
  SceneFacts facts = {.has_mirrors = device_scene->has_mirrors,
                      .least_roughness = device_scene->least_roughness,
                      .light_count = device_scene->light_count};
  FrameRequest request = {.camera = camera,
                          .area = {settings->width, settings->height, 0, 0, settings->width, settings->height},
                          .samples = 1,
                          .plan = plan_make(settings, &facts)};
  picture_assert_ok(frame_make(frame, device, device_scene, &request, &log));
  if (rendered) picture_assert_ok(frame_render(frame, &log));
}

ReflectorSummary mirrors_summary(const Scene *scene, const Camera *camera, const RenderSettings *settings)
{
  DeviceScene device_scene = {0};
  Frame frame = {0};
  frame_of(&frame, &device_scene, scene, camera, settings, false);
  ReflectorSummary summary = frame.reflectors;
  frame_free(&frame);
  device_scene_free(&device_scene);
  return summary;
}

NearTotals mirrors_near(const Scene *scene, const Camera *camera, const RenderSettings *settings)
{
  DeviceScene device_scene = {0};
  Frame frame = {0};
  frame_of(&frame, &device_scene, scene, camera, settings, true);
  const NearObjects *near = &frame.near_objects;
  NearTotals totals = {.cubes = near->cube_count,
                       .left_out = near->left_out,
                       .snapshots = near->snapshot_count,
                       .rays = frame.near_reflect.looked_up};
  for (uint32_t i = 0; i < near->cube_count; i++) totals.listed += near->lists[i].count;
  memcpy(totals.counts, frame.near_reflect.totals, sizeof totals.counts);
  frame_free(&frame);
  device_scene_free(&device_scene);
  return totals;
}

void mirrors_assert_same_in_waves(const Scene *scene, const Camera *camera, const PictureRequest *request)
{
  PictureRequest few = *request;
  few.wave_rays = 2048;
  Picture whole = picture_render(scene, camera, request), again = picture_render(scene, camera, request);
  Picture parts = picture_render(scene, camera, &few);
  picture_assert_same(&whole, &again);
  picture_assert_same(&whole, &parts);
  picture_free(&whole);
  picture_free(&again);
  picture_free(&parts);
}

MirrorsShown *mirrors_shown(const Scene *scene, const Camera *camera, ReflectionMethod method, uint32_t cube_px,
                            uint32_t lanes, uint32_t samples)
{
  enum { SIDE = MIRRORS_SIDE };
  Device *device = picture_device(lanes);
  DeviceScene device_scene = {0};
  Frame frame = {0};
  MirrorsShown *out = calloc(1, sizeof *out);
  RenderSettings settings = mirrors_request(SIDE, method, cube_px).settings;
  assert_non_null(out);
  picture_assert_ok(device_scene_make(&device_scene, device, scene, NULL, &picture_log));
  SceneFacts facts = {.triangle_count = device_scene.triangle_count,
                      .light_count = device_scene.light_count,
                      .has_mirrors = device_scene.has_mirrors,
                      .has_blends = device_scene.has_blends,
                      .least_roughness = device_scene.least_roughness};
  FrameRequest request = {.camera = camera,
                          .area = {SIDE, SIDE, 0, 0, SIDE, SIDE},
                          .samples = samples,
                          .plan = plan_make(&settings, &facts)};
  picture_assert_ok(frame_make(&frame, device, &device_scene, &request, &picture_log));
  picture_assert_ok(frame_render(&frame, &picture_log));
  picture_assert_ok(picture_shown(out->pixels[0], &frame, &(PictureOptions){.opaque = true}, &picture_log));
  const CubeReflect *maps = &frame.cube_reflect;
  out->rays = (double)(maps->looked_up + frame.planar.looked_up);
  out->traced = (double)(maps->left + frame.planar.left);
  out->shaded = (double)frame.hybrid_reflect.shaded;
  out->reflectors = frame.reflectors;
  out->planes = frame.planar.count;
  out->planes_left_out = frame.planar.left_out;
  frame_free(&frame);
  device_scene_free(&device_scene);
  return out;
}

size_t mirrors_off(const MirrorsShown *a, const MirrorsShown *b)
{
  size_t off = 0;
  for (size_t i = 0; i < MIRRORS_SIDE * MIRRORS_SIDE; i++) {
    float most = 0;
    for (int c = 0; c < 3; c++) most = fmaxf(most, fabsf(a->pixels[i][c] - b->pixels[i][c]));
    off += most > 2.0f / 255;
  }
  return off;
}
