// Raster of camera visibility against rays: the same triangle at the same t, u and v on every sample, bit for bit, by
// each way and at each width.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "shared/bvh.h"
#include "shared/stream.h"
#include "support/oracle_scene.h"
#include "support/raster_fixture.h"

// Six faces about a point, of which every other one is mirrored.
static void cube_views(RasterShot *shot, uint32_t size)
{
  shot->view_count = 6;
  for (uint32_t face = 0; face < 6; face++) {
    float axes[3][3] = {{0}};
    for (uint32_t i = 0; i < 3; i++) axes[i][(face / 2 + i) % 3] = 1;
    float s = face % 2 ? -1 : 1, scale = 2 / (float)size;
    shot->views[face] = (CameraInfo){.position = {0.21f, -0.13f, 0.17f},
                                     .forward = {s * axes[0][0], s * axes[0][1], s * axes[0][2]},
                                     .right = {axes[1][0], axes[1][1], axes[1][2]},
                                     .down = {axes[2][0], axes[2][1], axes[2][2]},
                                     .scale = scale,
                                     .center_x = 1,
                                     .center_y = 1,
                                     .far_m = INFINITY,
                                     .width = size,
                                     .height = size,
                                     .tiles_per_row = size / TILE_SIZE};
  }
}

// All views at once, in one wave and in several that end within a view, in one pass and in several.
static void views_of_a_table_are_seen_as_rays_see_them(void **state)
{
  RasterFixture fixture;
  Camera camera = raster_camera(vec3(0, 0, 0), vec3(0, 0, -1), 1);
  RasterShot shot = raster_shot(&camera, 8, 8, 1);
  const RasterOptions narrow = {.pass_chunks = 7, .pass_tiles = 40};
  Soup soup = {0};
  soup_random(&soup, 50000, 1.5f, 0.08f, 8);  // more than 256 chunks times views
  for (uint32_t i = 0; i < soup.triangle_count; i++) soup.flags[i] = i / 50 % 4;
  raster_fixture_of_soup(&fixture, &soup);
  static const uint32_t sizes[] = {32, 128, 136};
  for (int i = 0; i < 3; i++) {
    for (uint32_t wave_tiles = 0; wave_tiles <= 150; wave_tiles += 150) {
      uint32_t size = sizes[i];
      cube_views(&shot, size);
      shot.wave_tiles = wave_tiles;
      RasterHits rays = raster_assert_same(&fixture, &shot, "cube");
      assert_true(raster_hits_count(&rays) > 6 * size * size / 2);
      for (int variant = 0; variant < raster_variant_count(); variant++) {
        RasterHits hits = raster_hits(&fixture, &shot, (RasterVariant)variant, &narrow);
        assert_int_equal(raster_hits_differ(&rays, &hits, raster_variant_names[variant]), 0);
        raster_hits_free(&hits);
      }
      raster_hits_free(&rays);
    }
  }
  raster_fixture_free(&fixture);
}

// What is hidden is as if it were not there.
static void hidden_triangles_are_not_seen(void **state)
{
  enum { ALL = 3000, LEFT = 2100 };
  RasterFixture all, left;
  Camera camera = raster_camera(vec3(2.1, 1.3, 3.2), vec3(0, 0, 0), 0.9);
  RasterShot shot = raster_shot(&camera, 120, 90, 1);
  Soup soup = {0};
  soup_random(&soup, ALL, 1, 0.2f, 9);
  raster_fixture_of_soup(&all, &soup);
  soup_random(&soup, ALL, 1, 0.2f, 9);
  soup.triangle_count = LEFT;
  raster_fixture_of_soup(&left, &soup);
  RasterHits rays = raster_hits_by_rays(&left, &shot), rays_of_all = raster_hits_by_rays(&all, &shot);
  uint32_t behind = 0;
  for (uint32_t i = 0; i < rays.count; i++) behind += rays_of_all.ids[i] >= LEFT && rays_of_all.ids[i] != HIT_NONE;
  assert_true(behind > 500);
  shot.hidden[0] = LEFT;
  shot.hidden[1] = ALL;
  for (int variant = 0; variant < raster_variant_count(); variant++) {
    RasterHits hits = raster_hits(&all, &shot, (RasterVariant)variant, NULL);
    assert_int_equal(raster_hits_differ(&rays, &hits, raster_variant_names[variant]), 0);
    raster_hits_free(&hits);
  }
  raster_hits_free(&rays);
  raster_hits_free(&rays_of_all);
  raster_fixture_free(&left);
  raster_fixture_free(&all);
}

static void soups_are_seen_as_rays_see_them(void **state)
{
  static const float center[3] = {0.3f, -0.2f, 0.1f};
  Camera camera = raster_camera(vec3(2.1, 1.3, 3.2), vec3(0, 0, 0), 0.9);
  Soup soup = {0};
  soup_random(&soup, 3000, 1, 0.2f, 1);
  for (uint32_t i = 0; i < soup.triangle_count; i++) soup.flags[i] = i / 50 % 4;
  assert_true(raster_check_soup("random, single-sided and masked", &soup, &camera, 150, 100) > 3000);
  soup_random(&soup, 30000, 1.5f, 0.01f, 2);
  assert_true(raster_check_soup("small", &soup, &camera, 150, 100) > 500);
  soup_sphere(&soup, 40, 1, center, 0.2f);
  assert_true(raster_check_soup("sphere", &soup, &camera, 150, 100) > 1500);
  soup_slivers(&soup, 20000, 3);
  assert_true(raster_check_soup("slivers", &soup, &camera, 150, 100) > 500);
  soup_axis(&soup, 3);
  assert_true(raster_check_soup("axis-aligned", &soup, &camera, 150, 100) > 1000);
}

// Coplanar triangles tie in depth: the lower id wins, in whatever order they are drawn.
static void coplanar_triangles_have_the_same_winner(void **state)
{
  Camera camera = raster_camera(vec3(0.1, 0.2, 4), vec3(0, 0, 1.5), 0.7);
  Soup soup = {0};
  soup_coplanar(&soup, 400, 1.5f, 5);
  assert_true(raster_check_soup("coplanar", &soup, &camera, 120, 80) > 1000);
}

// Every sample within a fan of triangles is covered: none is lost between two of them, at their common edges and
// corner.
static void fan_covers_every_sample(void **state)
{
  enum { BLADES = 37, SIZE = 96 };
  Soup soup = {0};
  Camera camera = camera_orthographic(vec3(0, 0, 5), vec3(0, 0, 0), 1);
  camera.znear_m = 0.1;
  camera.zfar_m = 10;
  uint32_t middle = soup_vertex(&soup, 0, 0, 0), first = soup.vertex_count;
  for (int i = 0; i < BLADES; i++) {
    double angle = 2 * M_PI * i / BLADES;
    soup_vertex(&soup, (float)(0.9 * cos(angle)), (float)(0.9 * sin(angle)), 0);
  }
  for (uint32_t i = 0; i < BLADES; i++) soup_triangle(&soup, middle, first + i, first + (i + 1) % BLADES);
  RasterFixture fixture;
  raster_fixture_of_soup(&fixture, &soup);
  RasterShot shot = raster_shot(&camera, SIZE, SIZE, 1);
  RasterHits hits = raster_assert_same(&fixture, &shot, "fan");
  uint32_t inside = 0;
  for (uint32_t slot = 0; slot < hits.count; slot++) {
    uint32_t x, y;
    raster_slot_pixel(&x, &y, slot, SIZE, SIZE);
    double px = (x + 0.5) / SIZE * 2 - 1, py = (y + 0.5) / SIZE * 2 - 1;
    double apothem = 0.9 * cos(M_PI / BLADES);
    if (sqrt(px * px + py * py) < apothem - 1e-5) {
      assert_int_not_equal(hits.ids[slot], HIT_NONE);
      inside++;
    }
    if (sqrt(px * px + py * py) > 0.9 + 1e-5) assert_int_equal(hits.ids[slot], HIT_NONE);
  }
  assert_true(inside > 5000);
  raster_hits_free(&hits);
  raster_fixture_free(&fixture);
}

// No ray leaves a closed mesh: from inside every sample sees it, edges and corners included.
static void camera_within_a_mesh_sees_no_crack(void **state)
{
  static const float center[3] = {0, 0, 0};
  Camera camera = raster_camera(vec3(0.2, 0.1, -0.1), vec3(1, 0.5, 0.3), 1.9);
  Soup soup = {0};
  soup_sphere(&soup, 30, 1, center, 0.3f);
  assert_int_equal(raster_check_soup("inside a sphere", &soup, &camera, 160, 120), 160 * 120);
  static const float low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
  soup_grid(&soup, 20, low, high);
  assert_int_equal(raster_check_soup("inside a box", &soup, &camera, 160, 120), 160 * 120);
}

// The near plane cuts triangles; what is before it is not there.
static void near_plane_through_a_mesh_cuts_it(void **state)
{
  static const float center[3] = {0, 0, 0};
  Camera camera = raster_camera(vec3(0, 0, 1.2), vec3(0, 0, 0), 1.2);
  Soup soup = {0};
  camera.znear_m = 0.5;
  soup_sphere(&soup, 25, 1, center, 0.2f);
  soup_random(&soup, 500, 1, 0.6f, 3);
  assert_true(raster_check_soup("near plane", &soup, &camera, 150, 110) > 8000);
  camera.znear_m = 1.3;
  camera.zfar_m = 1.9;
  soup_sphere(&soup, 25, 1, center, 0.2f);
  assert_true(raster_check_soup("between near and far", &soup, &camera, 150, 110) > 200);
}

static void triangles_of_any_size_and_place_are_drawn_right(void **state)
{
  Camera camera = raster_camera(vec3(0, 1, 0), vec3(0.3, 0.7, -1), 1);
  Soup soup = {0};
  // A floor to the horizon whose corners are behind the eye, beside it and far out, and one as large overhead.
  for (int i = 0; i < 2; i++) {
    float y = i ? 3 : 0, far_off = i ? 1e6f : 1e4f;
    uint32_t a = soup_vertex(&soup, -far_off, y, -far_off), b = soup_vertex(&soup, far_off, y, -far_off);
    uint32_t c = soup_vertex(&soup, far_off, y, far_off), d = soup_vertex(&soup, -far_off, y, far_off);
    soup_triangle(&soup, a, b, c);
    soup_triangle(&soup, a, c, d);
  }
  assert_true(raster_check_soup("floor and sky", &soup, &camera, 160, 120) > 160 * 110);

  // Wholly behind the eye.
  soup_triangle(&soup, soup_vertex(&soup, -5, 1, 5), soup_vertex(&soup, 5, 1, 5), soup_vertex(&soup, 0, 9, 7));
  assert_int_equal(raster_check_soup("behind", &soup, &camera, 160, 120), 0);

  // Through the eye, and through the eye plane beside it.
  soup_triangle(&soup, soup_vertex(&soup, -1, 1, 1), soup_vertex(&soup, 1, 1, 1), soup_vertex(&soup, 0, 1, -3));
  soup_triangle(&soup, soup_vertex(&soup, 1, 0, 4), soup_vertex(&soup, 1, 3, 4), soup_vertex(&soup, 1, 1, -8));
  raster_check_soup("through the eye", &soup, &camera, 160, 120);

  // Without area: a point, a segment, three corners in a line.
  soup_triangle(&soup, soup_vertex(&soup, 0, 0.5f, -2), soup_vertex(&soup, 0, 0.5f, -2),
                soup_vertex(&soup, 0, 0.5f, -2));
  soup_triangle(&soup, soup_vertex(&soup, -1, 0.5f, -2), soup_vertex(&soup, 1, 0.5f, -2),
                soup_vertex(&soup, 1, 0.5f, -2));
  soup_triangle(&soup, soup_vertex(&soup, -1, 0.6f, -2), soup_vertex(&soup, 0, 0.6f, -2),
                soup_vertex(&soup, 1, 0.6f, -2));
  assert_int_equal(raster_check_soup("no area", &soup, &camera, 160, 120), 0);
}

static void a_hundred_thousand_triangles_in_one_tile_are_drawn_right(void **state)
{
  Camera camera = raster_camera(vec3(0.01, 0.02, 20), vec3(0, 0, 0), 0.6);
  Soup soup = {0};
  soup_random(&soup, 100000, 0.8f, 0.1f, 7);
  assert_true(raster_check_soup("one tile", &soup, &camera, 64, 64) > 20);
}

static void triangles_that_are_not_numbers_touch_nothing(void **state)
{
  Camera camera = raster_camera(vec3(0, 0, 4), vec3(0, 0, 0), 0.8);
  const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f};
  uint32_t expected = 0;
  for (int poisoned = 0; poisoned < 2; poisoned++) {
    Soup soup = {0};
    soup_random(&soup, 200, 1, 0.5f, 9);
    for (int i = 0; poisoned && i < 4; i++)
      soup_triangle(&soup, soup_vertex(&soup, 0, bad[i], 0), soup_vertex(&soup, -1, 0.1f, i == 3 ? bad[i] : 0),
                    soup_vertex(&soup, 1, 0, 0));
    uint32_t count = raster_check_soup(poisoned ? "poisoned" : "sound", &soup, &camera, 120, 90);
    if (poisoned) assert_int_equal(count, expected);
    expected = count;
  }
}

static void orthographic_cameras_see_what_their_rays_see(void **state)
{
  Camera camera = camera_orthographic(vec3(3, 2, 4), vec3(0, 0, 0), 1.3);
  camera.znear_m = 0;
  camera.zfar_m = 6;
  Soup soup = {0};
  soup_random(&soup, 4000, 1, 0.1f, 11);
  soup_axis(&soup, 2);
  assert_true(raster_check_soup("orthographic", &soup, &camera, 140, 100) > 4000);
  // Far from the origin of the world, where rays have rounded origins.
  soup_far(&soup, 2000, 4);
  camera = camera_orthographic(vec3(1e5 + 3, 1e5 + 2, 1e5 + 4), vec3(1e5, 1e5, 1e5), 1.3);
  camera.znear_m = 0;
  camera.zfar_m = 20;
  assert_true(raster_check_soup("orthographic, far", &soup, &camera, 140, 100) > 100);
  soup_far(&soup, 2000, 4);
  camera = raster_camera(vec3(1e5 + 3, 1e5 + 2, 1e5 + 4), vec3(1e5, 1e5, 1e5), 0.6);
  assert_true(raster_check_soup("perspective, far", &soup, &camera, 140, 100) > 100);
}

// Waves that begin and end within a row of bins, several passes over the triangles, several over the picture, tiles
// that find no place in the list: the same.
static void waves_and_passes_change_nothing(void **state)
{
  Camera camera = raster_camera(vec3(2.1, 1.3, 3.2), vec3(0, 0, 0), 0.9);
  Soup soup = {0};
  soup_random(&soup, 5000, 1.5f, 0.2f, 13);
  RasterFixture fixture;
  raster_fixture_of_soup(&fixture, &soup);
  RasterShot shot = raster_shot(&camera, 203, 171, 3);
  RasterHits whole = raster_hits_by_rays(&fixture, &shot);
  const struct {
    uint32_t wave_tiles;
    RasterOptions options;
  } ways[] = {{7, {0}},
              {61, {.pass_chunks = 2}},
              {0, {.pass_chunks = 1}},
              {0, {.pass_tiles = 1}},
              {100, {.pass_bins = 1}},
              {300, {.pass_chunks = 3, .pass_bins = 1}}};
  for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
    for (int variant = 0; variant < raster_variant_count(); variant++) {
      shot.wave_tiles = ways[i].wave_tiles;
      RasterHits hits = raster_hits(&fixture, &shot, (RasterVariant)variant, &ways[i].options);
      assert_int_equal(raster_hits_differ(&whole, &hits, "in waves and passes"), 0);
      raster_hits_free(&hits);
    }
  }
  raster_hits_free(&whole);
  raster_fixture_free(&fixture);
}

static void crop_shows_its_part_of_the_picture(void **state)
{
  enum { WIDTH = 128, HEIGHT = 96, X = 24, Y = 40 };
  Camera camera = raster_camera(vec3(2.1, 1.3, 3.2), vec3(0, 0, 0), 0.9);
  Soup soup = {0};
  soup_random(&soup, 2000, 1.5f, 0.3f, 17);
  RasterFixture fixture;
  raster_fixture_of_soup(&fixture, &soup);
  RasterShot shot = raster_shot(&camera, WIDTH, HEIGHT, 1);
  RasterHits whole = raster_hits(&fixture, &shot, RASTER_BINS_16, NULL);
  shot.area = (PictureArea){WIDTH, HEIGHT, X, Y, 64, 48};
  RasterHits part = raster_assert_same(&fixture, &shot, "crop");
  uint32_t ids[HEIGHT][WIDTH], x, y;
  for (uint32_t slot = 0; slot < whole.count; slot++) {
    raster_slot_pixel(&x, &y, slot, WIDTH, HEIGHT);
    ids[y][x] = whole.ids[slot];
  }
  for (uint32_t slot = 0; slot < part.count; slot++) {
    raster_slot_pixel(&x, &y, slot, shot.area.width, shot.area.height);
    assert_int_equal(part.ids[slot], ids[Y + y][X + x]);
  }
  assert_true(raster_hits_count(&part) > 1000);
  raster_hits_free(&whole);
  raster_hits_free(&part);
  raster_fixture_free(&fixture);
}

static void picture_of_16384_pixels_across_is_drawn_right(void **state)
{
  Camera camera = raster_camera(vec3(0.2, 0.1, 3), vec3(0, 0, 0), 0.003);
  Soup soup = {0};
  soup_random(&soup, 3000, 2, 0.3f, 19);
  assert_true(raster_check_soup("wide", &soup, &camera, 16384, 9) > 10000);
}

static void every_pattern_of_samples_is_seen_as_rays_see_it(void **state)
{
  static const uint32_t samples[] = {2, 3, 8, 16, 17};
  Camera camera = raster_camera(vec3(2.1, 1.3, 3.2), vec3(0, 0, 0), 0.9);
  Soup soup = {0};
  soup_random(&soup, 20000, 1.5f, 0.02f, 23);
  RasterFixture fixture;
  raster_fixture_of_soup(&fixture, &soup);
  for (size_t i = 0; i < sizeof samples / sizeof *samples; i++) {
    RasterShot shot = raster_shot(&camera, 70, 50, samples[i]);
    RasterHits hits = raster_assert_same(&fixture, &shot, "samples");
    raster_hits_free(&hits);
  }
  raster_fixture_free(&fixture);
}

// Small triangles with more samples than a work-group lists (RASTER_LISTED_SAMPLES).
static void triangles_of_a_few_pixels_are_drawn_right(void **state)
{
  enum { CELLS = 20, CELL_PX = 6, SAMPLES = 2 };
  Camera camera = camera_orthographic(vec3(0, 0, 5), vec3(0, 0, 0), 1);
  camera.znear_m = 0.1;
  camera.zfar_m = 10;
  Soup soup = {0};
  for (int y = 0; y <= CELLS; y++)
    for (int x = 0; x <= CELLS; x++)
      soup_vertex(&soup, 2.0f * (float)x / CELLS - 1, 2.0f * (float)y / CELLS - 1, 0.1f * (float)(x * y % 7));
  for (uint32_t y = 0; y < CELLS; y++) {
    for (uint32_t x = 0; x < CELLS; x++) {
      uint32_t corner = y * (CELLS + 1) + x;
      soup_triangle(&soup, corner, corner + 1, corner + CELLS + 1);
      soup_triangle(&soup, corner + 1, corner + CELLS + 2, corner + CELLS + 1);
    }
  }
  RasterFixture fixture;
  raster_fixture_of_soup(&fixture, &soup);
  RasterShot shot = raster_shot(&camera, CELLS * CELL_PX, CELLS * CELL_PX, SAMPLES);
  RasterHits hits = raster_assert_same(&fixture, &shot, "few pixels");
  assert_int_equal(raster_hits_count(&hits), CELLS * CELL_PX * CELLS * CELL_PX * SAMPLES);
  raster_hits_free(&hits);
  raster_fixture_free(&fixture);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(views_of_a_table_are_seen_as_rays_see_them),
      cmocka_unit_test(hidden_triangles_are_not_seen),
      cmocka_unit_test(soups_are_seen_as_rays_see_them),
      cmocka_unit_test(coplanar_triangles_have_the_same_winner),
      cmocka_unit_test(fan_covers_every_sample),
      cmocka_unit_test(camera_within_a_mesh_sees_no_crack),
      cmocka_unit_test(near_plane_through_a_mesh_cuts_it),
      cmocka_unit_test(triangles_of_any_size_and_place_are_drawn_right),
      cmocka_unit_test(triangles_of_a_few_pixels_are_drawn_right),
      cmocka_unit_test(a_hundred_thousand_triangles_in_one_tile_are_drawn_right),
      cmocka_unit_test(triangles_that_are_not_numbers_touch_nothing),
      cmocka_unit_test(orthographic_cameras_see_what_their_rays_see),
      cmocka_unit_test(waves_and_passes_change_nothing),
      cmocka_unit_test(crop_shows_its_part_of_the_picture),
      cmocka_unit_test(picture_of_16384_pixels_across_is_drawn_right),
      cmocka_unit_test(every_pattern_of_samples_is_seen_as_rays_see_it),
  };
  return cmocka_run_group_tests(tests, raster_tests_begin, raster_tests_end);
}
