// Raster where it is pushed: a million triangles in one tile, pictures and triangles of extreme shape, what is hidden,
// scales far from 1, and depth maps of what should leave no trace.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "shared/stream.h"
#include "support/effort.h"
#include "support/map_fixture.h"

static Camera camera_at(Vec3 eye, Vec3 target, double yfov_rad)
{
  Camera camera = camera_perspective(eye, target, yfov_rad);
  camera.znear_m = 0.01;
  camera.zfar_m = INFINITY;
  return camera;
}

// More triangles than a pass holds chunks for, nearly all of them in one bin: raster by bins sees what rays see, and
// both ways draw the same map.
static void a_million_triangles_in_one_tile_are_drawn_right(void **state)
{
  uint32_t count = effort_is_quick() ? 100000 : 1100000;
  Camera camera = camera_at(vec3(0.01, 0.02, 20), vec3(0, 0, 0), 0.6);
  Soup soup = {0};
  RasterFixture fixture;
  soup_random(&soup, count, 0.8f, 0.05f, 7);
  raster_fixture_of_soup(&fixture, &soup);
  RasterShot shot = raster_shot(&camera, 64, 64, 1);
  RasterHits rays = raster_hits_by_rays(&fixture, &shot);
  RasterHits bins = raster_hits(&fixture, &shot, RASTER_BINS_16, NULL);
  assert_int_equal(raster_hits_differ(&rays, &bins, "a million"), 0);
  assert_true(raster_hits_count(&rays) > 50);
  raster_hits_free(&rays);
  raster_hits_free(&bins);

  const double rows[4][4] = {{0.4, 0, 0, 0.5}, {0, 0.4, 0, 0.5}, {0, 0, 0.4, 0.5}, {0, 0, 0, 1}};
  RasterView view = map_view_of_rows(rows, vec3(0, 0, 0), 64, 0);
  float *map = maps_draw(&fixture, &view, 1, RASTER_BINS_16, NULL);
  float *direct = maps_draw(&fixture, &view, 1, (RasterVariant)(raster_variant_count() - 1), NULL);
  assert_memory_equal(map, direct, 64 * 64 * sizeof *map);
  assert_true(map[32 * 64 + 32] < 0.3f);
  free(map);
  free(direct);
  raster_fixture_free(&fixture);
}

static void picture_of_16384_pixels_down_is_drawn_right(void **state)
{
  Camera camera = camera_at(vec3(0.2, 0.1, 3), vec3(0, 0, 0), 0.9);
  Soup soup = {0};
  RasterFixture fixture;
  soup_random(&soup, 3000, 2, 0.3f, 19);
  raster_fixture_of_soup(&fixture, &soup);
  RasterShot shot = raster_shot(&camera, 9, 16384, 1);
  RasterHits hits = raster_assert_same(&fixture, &shot, "tall");
  assert_true(raster_hits_count(&hits) > 10000);
  raster_hits_free(&hits);
  raster_fixture_free(&fixture);
}

// A square of cells^2 cells of two triangles across (0, 0)..(1, 1) and a little beyond, its plane at z.
static void layer_add(Soup *soup, uint32_t cells, float z)
{
  uint32_t first = soup->vertex_count;
  for (uint32_t y = 0; y <= cells; y++)
    for (uint32_t x = 0; x <= cells; x++)
      soup_vertex(soup, 1.2f * (float)x / (float)cells - 0.1f, 1.2f * (float)y / (float)cells - 0.1f, z);
  for (uint32_t y = 0; y < cells; y++) {
    for (uint32_t x = 0; x < cells; x++) {
      uint32_t at = first + y * (cells + 1) + x, below = at + cells + 1;
      soup_triangle(soup, at, at + 1, below + 1);
      soup_triangle(soup, at, below + 1, below);
    }
  }
}

// Layers behind each other, of which the nearest hides whole chunks of the others: it alone is seen, wherever it comes
// in the file, and where a hole is in it the next.
static void layers_behind_the_nearest_are_not_seen(void **state)
{
  enum { CELLS = 40, LAYERS = 7, SIZE = 128 };
  static const float depth[LAYERS] = {0.75f, 0.5f, 0.875f, 0.25f, 0.625f, 0.375f, 0.9375f};
  Soup soup = {0};
  RasterFixture fixture;
  for (int i = 0; i < LAYERS; i++) layer_add(&soup, CELLS, depth[i]);
  uint32_t hole = 3 * 2 * CELLS * CELLS + 2 * (CELLS / 2 * CELLS + CELLS / 2);  // of the nearest layer's middle
  for (int k = 0; k < 2; k++) memcpy(soup.triangles[hole + k], (uint32_t[3]){0, 0, 0}, sizeof(uint32_t[3]));
  raster_fixture_of_soup(&fixture, &soup);
  RasterView view = map_view_flat(SIZE);
  float *map = maps_by_all(&fixture, &view, 1);
  uint32_t through = 0;
  for (int i = 0; i < SIZE * SIZE; i++) {
    assert_true(map[i] == 0.25f || map[i] == 0.375f);
    through += map[i] == 0.375f;
  }
  // The hole is 1.2 / 40 of the map wide: 3.84 texels.
  assert_in_range(through, 9, 16);
  free(map);

  Camera camera = camera_at(vec3(0.5, 0.5, -1), vec3(0.5, 0.5, 0), 0.7);
  RasterShot shot = raster_shot(&camera, SIZE, SIZE, 1);
  RasterHits hits = raster_assert_same(&fixture, &shot, "layers");
  uint32_t nearest = 0;
  for (uint32_t i = 0; i < hits.count; i++) nearest += fabsf(hits.t[i] - 1.25f) < 1e-5f;
  assert_in_range(hits.count - nearest, 4, 40);
  raster_hits_free(&hits);
  raster_fixture_free(&fixture);
}

// Scenes 2^-20 and 2^20 times as large are the same picture, at distances that are exactly so many times as large.
static void scale_changes_nothing(void **state)
{
  RasterHits unit = {0};
  for (int i = 0; i < 3; i++) {
    double scale = i == 0 ? 1 : i == 1 ? 0x1p-20 : 0x1p20;
    Soup soup = {0};
    RasterFixture fixture;
    Camera camera = camera_at(vec3(2 * scale, 1.25 * scale, 3 * scale), vec3(0, 0, 0), 0.9);
    camera.znear_m = 0.0078125 * scale;
    soup_random(&soup, 4000, 1, 0.2f, 31);
    for (uint32_t v = 0; v < soup.vertex_count; v++)
      for (int axis = 0; axis < 3; axis++) soup.positions[v][axis] *= (float)scale;
    raster_fixture_of_soup(&fixture, &soup);
    RasterShot shot = raster_shot(&camera, 120, 80, 1);
    RasterHits hits = raster_assert_same(&fixture, &shot, "scaled");
    assert_true(raster_hits_count(&hits) > 3000);
    for (uint32_t slot = 0; i && slot < hits.count; slot++) {
      assert_int_equal(hits.ids[slot], unit.ids[slot]);
      if (hits.ids[slot] != HIT_NONE) assert_true(hits.t[slot] == unit.t[slot] * (float)scale);
    }
    if (i)
      raster_hits_free(&hits);
    else
      unit = hits;
    raster_fixture_free(&fixture);
  }
  raster_hits_free(&unit);
}

// What has no area, is behind the eye, beyond the far plane or not a number leaves no trace in a map.
static void triangles_that_show_nothing_leave_no_trace_in_a_map(void **state)
{
  enum { SIZE = 64 };
  const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f};
  const Vec3 eye = vec3(0.1, 0.2, 4);
  RasterView view = map_view_of_face(5, eye, SIZE, 0.05);  // along -z
  float *maps[2];
  for (int poisoned = 0; poisoned < 2; poisoned++) {
    Soup soup = {0};
    soup_random(&soup, 300, 1, 0.5f, 9);
    for (int i = 0; poisoned && i < 4; i++)
      soup_triangle(&soup, soup_vertex(&soup, 0, bad[i], 0), soup_vertex(&soup, -1, 0.1f, bad[(i + 1) % 4]),
                    soup_vertex(&soup, 1, 0, 3));
    if (poisoned) {
      uint32_t a = soup_vertex(&soup, 0, 0.5f, 3), b = soup_vertex(&soup, 0.5f, 0.5f, 3);
      soup_triangle(&soup, a, a, a);                                   // a point
      soup_triangle(&soup, a, b, b);                                   // a segment
      soup_triangle(&soup, a, soup_vertex(&soup, 0.25f, 0.5f, 3), b);  // three corners in a line
      soup_triangle(&soup, soup_vertex(&soup, -9, -9, 5), soup_vertex(&soup, 9, -9, 5), soup_vertex(&soup, 0, 9, 5));
    }
    maps[poisoned] = maps_of_soup(&soup, &view, 1);
  }
  assert_memory_equal(maps[0], maps[1], SIZE * SIZE * sizeof *maps[0]);
  uint32_t covered = 0;
  for (int i = 0; i < SIZE * SIZE; i++) covered += maps[0][i] < 1;
  assert_true(covered > 200);
  free(maps[0]);
  free(maps[1]);
}

// A square cut into upright slivers of aspect 10^2 to 10^8 that share their long edges, some through centres of texels,
// has no hole, and no depth but its plane's.
static void slivers_side_by_side_leave_no_hole_in_a_map(void **state)
{
  enum { SIZE = 128, SLIVERS = 600 };
  Soup soup = {0};
  Random random = random_make(37);
  RasterView view = map_view_flat(SIZE);
  float left = -0.1f;
  for (int i = 0; i < SLIVERS; i++) {
    float right = left + powf(10, random_between(&random, -8, -2));
    if (i % 4 == 0) right = (floorf(left * SIZE) + 1.5f) / SIZE;
    uint32_t a = soup_vertex(&soup, left, -0.1f, 0.5f), b = soup_vertex(&soup, right, -0.1f, 0.5f);
    uint32_t c = soup_vertex(&soup, left, 1.1f, 0.5f), d = soup_vertex(&soup, right, 1.1f, 0.5f);
    soup_triangle(&soup, a, b, d);
    soup_triangle(&soup, a, d, c);
    left = right;
  }
  assert_true(left > 1);
  float *map = maps_of_soup(&soup, &view, 1);
  for (int i = 0; i < SIZE * SIZE; i++) assert_true(map[i] == 0.5f);
  free(map);
}

// Maps of all lights are drawn at once: more of them, of more sizes, than one launch takes.
static void maps_of_any_sizes_are_what_they_are_alone(void **state)
{
  enum { VIEWS = 40 };
  static const uint32_t sizes[] = {16, 16, 64, 4, 100};
  const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
  RasterView views[VIEWS];
  for (int i = 0; i < VIEWS; i++)
    views[i] = map_view_of_face(i % 6, vec3(0.3 - 0.02 * i, -0.2, 0.1), sizes[i % 5], 0.05);
  Soup soup = {0};
  RasterFixture fixture;
  soup_grid(&soup, 12, low, high);
  raster_fixture_of_soup(&fixture, &soup);
  float *maps = maps_by_all(&fixture, views, VIEWS), *at = maps;
  for (int i = 0; i < VIEWS; i++) {
    const size_t texels = (size_t)views[i].width * views[i].width;
    float *alone = maps_draw(&fixture, &views[i], 1, RASTER_BINS_16, NULL);
    if (memcmp(alone, at, texels * sizeof *alone)) fail_msg("map %d is another alone", i);
    for (size_t k = 0; k < texels; k++) assert_true(at[k] < 1);
    at += texels;
    free(alone);
  }
  free(maps);
  raster_fixture_free(&fixture);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_million_triangles_in_one_tile_are_drawn_right),
      cmocka_unit_test(picture_of_16384_pixels_down_is_drawn_right),
      cmocka_unit_test(layers_behind_the_nearest_are_not_seen),
      cmocka_unit_test(scale_changes_nothing),
      cmocka_unit_test(triangles_that_show_nothing_leave_no_trace_in_a_map),
      cmocka_unit_test(slivers_side_by_side_leave_no_hole_in_a_map),
      cmocka_unit_test(maps_of_any_sizes_are_what_they_are_alone),
  };
  return cmocka_run_group_tests(tests, raster_tests_begin, raster_tests_end);
}
