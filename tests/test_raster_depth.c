// Depth maps against plain C: coverage by exact integers and the top-left rule, depth in double precision; by each way
// of drawing them and at each width.

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
#include "support/map_fixture.h"
#include "support/oracle_scene.h"

// Does a triangle with corners in 1/256 of a texel have the centre of texel (x, y)? The top-left rule, y downwards.
static bool covers(const int64_t corners[3][2], int64_t x, int64_t y)
{
  const int64_t px = 256 * x + 128, py = 256 * y + 128;
  int64_t area = (corners[1][0] - corners[0][0]) * (corners[2][1] - corners[0][1]) -
                 (corners[2][0] - corners[0][0]) * (corners[1][1] - corners[0][1]);
  if (area == 0) return false;
  for (int i = 0; i < 3; i++) {
    const int64_t *a = corners[area > 0 ? i : (3 - i) % 3], *b = corners[area > 0 ? (i + 1) % 3 : (5 - i) % 3];
    int64_t dx = b[0] - a[0], dy = b[1] - a[1], edge = dx * (py - a[1]) - dy * (px - a[0]);
    bool top = dy == 0 && dx > 0, left = dy < 0;
    if (edge < 0 || (edge == 0 && !top && !left)) return false;
  }
  return true;
}

enum { SIZE = 128 };  // texels of the exact tests: 1/256 of one is 2^-15 of the map

typedef struct Exact {
  int64_t corners[3][2];
  float depth[3];
} Exact;

static float world_of(int64_t part) { return (float)part / (256 * SIZE); }

static void exact_add(Soup *soup, const Exact *t)
{
  uint32_t v[3];
  for (int i = 0; i < 3; i++)
    v[i] = soup_vertex(soup, world_of(t->corners[i][0]), world_of(t->corners[i][1]), t->depth[i]);
  soup_triangle(soup, v[0], v[1], v[2]);
}

static int64_t random_part(Random *random, int64_t low, int64_t high)
{
  return low + random_next(random) % (uint32_t)(high - low + 1);
}

// Triangles of all sizes, some of which begin or end at centres of texels, in lines of texels, or outside the map.
static void exact_random(Exact *out, Random *random, bool flat)
{
  int64_t reach = 1 << random_part(random, 4, 16), x = random_part(random, -8000, 40000),
          y = random_part(random, -8000, 40000);
  for (int i = 0; i < 3; i++) {
    out->corners[i][0] = x + random_part(random, -reach, reach);
    out->corners[i][1] = y + random_part(random, -reach, reach);
    if (random_next(random) % 3 == 0) out->corners[i][0] = out->corners[i][0] / 256 * 256 + 128;
    if (random_next(random) % 3 == 0) out->corners[i][1] = out->corners[i][1] / 256 * 256 + 128;
    out->depth[i] = i && flat ? out->depth[0] : (float)(1 + random_next(random) % 65535) / 65536;
  }
}

// Less than a texel wide, with the left edge through centres of texels, or the same with the top edge; before all
// others.
static void exact_thin(Exact *out, Random *random, int i)
{
  int64_t at = 256 * random_part(random, 2, SIZE - 8) + 128, along = 256 * random_part(random, 2, SIZE - 8) + 100;
  const int64_t corners[3][2] = {{at, along}, {at, along + 1000}, {at + 100, along + 500}};
  for (int k = 0; k < 3; k++) {
    out->corners[k][i % 2] = corners[k][0];
    out->corners[k][1 - i % 2] = corners[k][1];
    out->depth[k] = (float)(i + 1) / (1 << 20);
  }
}

// Triangles that face the map show by their depth which of them a texel belongs to.
static void coverage_is_exact(void **state)
{
  enum { TRIANGLES = 400, THIN = 40 };
  static Exact triangles[TRIANGLES];
  Random random = random_make(1);
  Soup soup = {0};
  for (int i = 0; i < TRIANGLES; i++) {
    if (i < THIN)
      exact_thin(&triangles[i], &random, i);
    else
      exact_random(&triangles[i], &random, true);
    exact_add(&soup, &triangles[i]);
  }
  RasterView view = map_view_flat(SIZE);
  float *map = maps_of_soup(&soup, &view, 1);
  uint32_t wrong = 0, covered = 0;
  for (int y = 0; y < SIZE; y++) {
    for (int x = 0; x < SIZE; x++) {
      float expected = 1;
      for (int i = 0; i < TRIANGLES; i++)
        if (covers(triangles[i].corners, x, y) && triangles[i].depth[0] < expected) expected = triangles[i].depth[0];
      covered += expected < 1;
      if (map[y * SIZE + x] != expected && wrong++ < 5)
        printf("(%d, %d): %g, not %g\n", x, y, map[y * SIZE + x], expected);
    }
  }
  assert_int_equal(wrong, 0);
  assert_true(covered > SIZE * SIZE / 2);
  free(map);
}

// One sloped triangle a view: its plane, to the rounding of a float plane through its corners.
static void depth_is_the_planes(void **state)
{
  Random random = random_make(2);
  double worst = 0;
  uint32_t covered = 0;
  for (int i = 0; i < 40; i++) {
    Exact t;
    Soup soup = {0};
    exact_random(&t, &random, false);
    exact_add(&soup, &t);
    RasterView view = map_view_flat(SIZE);
    float *map = maps_of_soup(&soup, &view, 1);
    const double dx1 = (double)(t.corners[1][0] - t.corners[0][0]), dy1 = (double)(t.corners[1][1] - t.corners[0][1]);
    const double dx2 = (double)(t.corners[2][0] - t.corners[0][0]), dy2 = (double)(t.corners[2][1] - t.corners[0][1]);
    const double rise1 = (double)t.depth[1] - t.depth[0], rise2 = (double)t.depth[2] - t.depth[0],
                 area = dx1 * dy2 - dx2 * dy1;
    const double slope_x = (rise1 * dy2 - rise2 * dy1) / area, slope_y = (rise2 * dx1 - rise1 * dx2) / area;
    for (int y = 0; y < SIZE; y++) {
      for (int x = 0; x < SIZE; x++) {
        assert_int_equal(map[y * SIZE + x] < 1, covers(t.corners, x, y));
        if (map[y * SIZE + x] == 1) continue;
        const double right = 256 * x + 128 - (double)t.corners[0][0], down = 256 * y + 128 - (double)t.corners[0][1];
        const double depth = t.depth[0] + slope_x * right + slope_y * down;
        // Slopes are off by 4 roundings of the products they are made of, terms and sums by 4 more.
        const double products = (fabs(rise1 * dy2) + fabs(rise2 * dy1)) / fabs(area) * fabs(right) +
                                (fabs(rise2 * dx1) + fabs(rise1 * dx2)) / fabs(area) * fabs(down);
        const double bound = 0x1p-24 * (8 * products + 4);
        worst = fmax(worst, fabs(map[y * SIZE + x] - depth) / bound);
        covered++;
      }
    }
    free(map);
  }
  printf("depth: worst error %.2f of the bound, %u texels\n", worst, covered);
  assert_true(covered > 10000);
  assert_true(worst <= 1);
}

// Each texel of a fan belongs to one blade: the nearest and the farthest that cover it are the same.
static void texels_of_a_fan_belong_to_one_blade_each(void **state)
{
  enum { BLADES = 48 };
  float *maps[2];
  RasterView view = map_view_flat(SIZE);
  for (int order = 0; order < 2; order++) {
    Soup soup = {0};
    for (int i = 0; i < BLADES; i++) {
      // Corners at centres of texels and on lines between them, and a middle at a centre.
      Exact t = {.corners = {{64 * 256 + 128, 64 * 256 + 128}}};
      for (int k = 0; k < 2; k++) {
        double angle = 2 * M_PI * ((i + k) % BLADES) / BLADES;
        t.corners[1 + k][0] = 128 * (int64_t)floor(64 * 2 + 1 + 100 * cos(angle));
        t.corners[1 + k][1] = 128 * (int64_t)floor(64 * 2 + 1 + 100 * sin(angle));
      }
      for (int k = 0; k < 3; k++) t.depth[k] = (float)(order ? BLADES - i : i + 1) / 64;
      exact_add(&soup, &t);
    }
    maps[order] = maps_of_soup(&soup, &view, 1);
  }
  uint32_t covered = 0;
  for (int i = 0; i < SIZE * SIZE; i++) {
    assert_int_equal(maps[0][i] < 1, maps[1][i] < 1);
    if (maps[0][i] == 1) continue;
    assert_int_equal((int)(maps[0][i] * 64) + (int)(maps[1][i] * 64), BLADES + 1);
    covered++;
  }
  assert_true(covered > 7000);
  free(maps[0]);
  free(maps[1]);
}

// From within a closed mesh every texel of the six faces shows it: no cracks where triangles cross an eye plane or a
// face's edge. The faces drawn together are those drawn alone, and in several passes.
static void cube_within_a_mesh_has_no_crack(void **state)
{
  enum { CUBE = 64 };
  static const float center[3] = {0, 0, 0}, low[3] = {-1, -1, -1}, high[3] = {1, 1, 1};
  const Vec3 eye = vec3(0.31, -0.22, 0.13);
  RasterView views[6];
  for (int face = 0; face < 6; face++) views[face] = map_view_of_face(face, eye, CUBE, 0.05);
  for (int mesh = 0; mesh < 3; mesh++) {
    Soup soup = {0};
    if (mesh == 0) soup_sphere(&soup, 110, 1, center, 0.2f);
    if (mesh == 1) soup_grid(&soup, 15, low, high);
    if (mesh == 2) soup_grid(&soup, 1, low, high);
    RasterFixture fixture;
    raster_fixture_of_soup(&fixture, &soup);
    float *maps = maps_by_all(&fixture, views, 6);
    for (int i = 0; i < 6 * CUBE * CUBE; i++)
      if (!(maps[i] < 1)) fail_msg("mesh %d: texel %d shows nothing", mesh, i);
    for (int face = 0; face < 6; face++) {
      float *alone = maps_draw(&fixture, &views[face], 1, RASTER_BINS_16, NULL);
      assert_memory_equal(alone, maps + face * CUBE * CUBE, CUBE * CUBE * sizeof *alone);
      free(alone);
    }
    for (int variant = 0; variant < raster_variant_count(); variant++) {
      const RasterOptions tight = {.pass_chunks = 1, .pass_tiles = 1};
      float *passes = maps_draw(&fixture, views, 6, (RasterVariant)variant, &tight);
      assert_memory_equal(passes, maps, 6 * CUBE * CUBE * sizeof *passes);
      free(passes);
    }
    raster_fixture_free(&fixture);
    free(maps);
  }
}

// A plane that passes under the eye and far behind it is seen up to the horizon, at the depth of its rays.
static void plane_under_the_eye_is_drawn_to_the_horizon(void **state)
{
  const Vec3 eye = vec3(0.3, 1, -0.2);
  const double near_m = 0.01;
  RasterView view = map_view_of_face(5, eye, SIZE, near_m);  // along -z; x to the right, y downwards in the map
  Soup soup = {0};
  uint32_t a = soup_vertex(&soup, -1e4f, 0, -1e4f), b = soup_vertex(&soup, 1e4f, 0, -1e4f);
  uint32_t c = soup_vertex(&soup, 1e4f, 0, 1e4f), d = soup_vertex(&soup, -1e4f, 0, 1e4f);
  soup_triangle(&soup, a, b, c);
  soup_triangle(&soup, a, c, d);
  float *map = maps_of_soup(&soup, &view, 1);
  for (int y = 0; y < SIZE; y++) {
    for (int x = 0; x < SIZE; x++) {
      // map y = (y / w + 1) / 2 with y along +y: the lower half of the world is the upper half of the map
      double slope = 2 * (y + 0.5) / SIZE - 1, w = -eye.y / slope;
      // The corners are 1.4e4 m away, where a rounding is 8e-4 m: the plane is held to a few of them at a height of 1
      // m.
      if (y < SIZE / 2) assert_true(fabs(map[y * SIZE + x] - (1 - near_m / w)) < 2e-3 * near_m / w + 1e-6);
      if (y >= SIZE / 2) assert_true(map[y * SIZE + x] == 1);
    }
  }
  free(map);
}

static void caster_before_the_near_plane_is_drawn_at_0(void **state)
{
  Soup soup = {0};
  soup_triangle(&soup, soup_vertex(&soup, -1, -1, -0.5f), soup_vertex(&soup, 3, -1, -0.5f),
                soup_vertex(&soup, -1, 3, -0.5f));
  soup_triangle(&soup, soup_vertex(&soup, -1, -1, 1.5f), soup_vertex(&soup, 3, -1, 1.5f),
                soup_vertex(&soup, -1, 3, 1.5f));
  RasterView view = map_view_flat(64);
  float *map = maps_of_soup(&soup, &view, 1);
  for (int i = 0; i < 64 * 64; i++) assert_true(map[i] == 0);
  free(map);
  soup_triangle(&soup, soup_vertex(&soup, -1, -1, 1.5f), soup_vertex(&soup, 3, -1, 1.5f),
                soup_vertex(&soup, -1, 3, 1.5f));
  map = maps_of_soup(&soup, &view, 1);
  for (int i = 0; i < 64 * 64; i++) assert_true(map[i] == 1);  // beyond the far plane
  free(map);
}

// Corners beyond the range of the integers, thousands of maps away.
static void triangles_larger_than_the_range_are_clipped(void **state)
{
  Soup soup = {0};
  soup_triangle(&soup, soup_vertex(&soup, -1e6f, -1e6f, 0.25f), soup_vertex(&soup, 2e6f, 0.5f, 0.25f),
                soup_vertex(&soup, -1e6f, 0.5f, 0.25f));
  RasterView view = map_view_flat(64);
  float *map = maps_of_soup(&soup, &view, 1);
  for (int y = 0; y < 64; y++)
    for (int x = 0; x < 64; x++) assert_true(map[64 * y + x] == (y < 32 ? 0.25f : 1));
  free(map);
}

// The same view as an orthographic camera: what its rays hit is what the map shows, but for texels that an edge passes
// within the 1/512 that snapping moves it. Masked triangles are cut alike.
static void map_shows_what_rays_hit(void **state)
{
  enum { TEXELS = 160 };
  const double half = 1.25, far_m = 4;
  Camera camera = camera_orthographic(vec3(0, 0, 2), vec3(0, 0, 0), half);
  camera.znear_m = 0;
  camera.zfar_m = far_m;
  const double rows[4][4] = {
      {0.5 / half, 0, 0, 0.5}, {0, -0.5 / half, 0, 0.5}, {0, 0, -1 / far_m, 2 / far_m}, {0, 0, 0, 1}};
  RasterView view = map_view_of_rows(rows, vec3(0, 0, 2), TEXELS, 0);
  for (int masked = 0; masked < 2; masked++) {
    Soup soup = {0};
    soup_random(&soup, 600, 1, 0.6f, 29);
    for (uint32_t i = 0; masked && i < soup.triangle_count; i++) soup.flags[i] = TRIANGLE_MASKED;
    RasterFixture fixture;
    raster_fixture_of_soup(&fixture, &soup);
    float *map = maps_by_all(&fixture, &view, 1);
    RasterShot shot = raster_shot(&camera, TEXELS, TEXELS, 1);
    RasterHits hits = raster_hits_by_rays(&fixture, &shot);
    uint32_t differ = 0, covered = raster_hits_count(&hits);
    for (uint32_t slot = 0; slot < hits.count; slot++) {
      uint32_t x, y;
      raster_slot_pixel(&x, &y, slot, TEXELS, TEXELS);
      double expected = hits.ids[slot] == HIT_NONE ? 1 : hits.t[slot] / far_m;
      differ +=
          fabs(map[y * TEXELS + x] - expected) > 2e-3;  // the steepest of these planes rise by less in 1/256 texel
    }
    printf("%s: %u of %u texels differ, %u are covered\n", masked ? "masked" : "opaque", differ, TEXELS * TEXELS,
           covered);
    assert_true(covered > TEXELS * TEXELS / (masked ? 4 : 3));
    // About ten edges cross a texel's row here, each within 1/512 of a centre in 1/256 of the texels that it crosses.
    assert_true(differ < TEXELS * TEXELS / 100);
    raster_hits_free(&hits);
    free(map);
    raster_fixture_free(&fixture);
  }
}

// Every way leaves out what casts no shadow, and that alone.
static void what_casts_no_shadow_is_left_out(void **state)
{
  enum { TEXELS = 96 };
  RasterView view = map_view_flat(TEXELS);
  float *maps[3];
  for (int variant = 0; variant < 3; variant++) {  // with a sphere that casts, without it, with one that does not
    Scene scene = scene_empty();
    RasterFixture fixture;
    int grey = scene_add_material(&scene, material_plain(vec3(0.5, 0.5, 0.5), 0, 1));
    scene_add_quad(&scene, grey, vec3(0, 0, 0.9), vec3(1, 0, 0), vec3(0, 1, 0));
    scene_add_sphere(&scene, grey, vec3(0.3, 0.4, 0.5), 0.2, 9);
    if (variant != 1) scene_add_sphere(&scene, grey, vec3(0.5, 0.5, 0.4), 0.3, 12);
    scene.objects[scene.object_count - 1].shadowless = variant == 2;
    raster_fixture_make(&fixture, &scene);
    maps[variant] = maps_by_all(&fixture, &view, 1);
    raster_fixture_free(&fixture);
    scene_free(&scene);
  }
  size_t bytes = TEXELS * TEXELS * sizeof(float);
  assert_memory_not_equal(maps[0], maps[1], bytes);
  assert_memory_equal(maps[2], maps[1], bytes);
  for (int variant = 0; variant < 3; variant++) free(maps[variant]);
}

static void sizes_that_do_not_fit_are_refused(void **state)
{
  static const uint32_t sizes[] = {0, 6, 8196};
  Soup soup = {0};
  soup_random(&soup, 10, 1, 1, 1);
  RasterFixture fixture;
  raster_fixture_of_soup(&fixture, &soup);
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
    RasterDepth raster;
    Log log = {0};
    Device *device = raster_device(RASTER_BINS_16);
    const RasterView view = map_view_flat(sizes[i]);
    raster_assert_ok(raster_depth_make(&raster, device, &fixture.scene, &(RasterOptions){0}, &raster_log));
    assert_int_equal(raster_depth(&raster, device, &fixture.scene, &fixture.triangles, &view, 1, &log), STATUS_USAGE);
    assert_non_null(strstr(log.error, "multiple of 4"));
    raster_depth_free(&raster);
  }
  raster_fixture_free(&fixture);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(coverage_is_exact),
      cmocka_unit_test(depth_is_the_planes),
      cmocka_unit_test(texels_of_a_fan_belong_to_one_blade_each),
      cmocka_unit_test(cube_within_a_mesh_has_no_crack),
      cmocka_unit_test(plane_under_the_eye_is_drawn_to_the_horizon),
      cmocka_unit_test(caster_before_the_near_plane_is_drawn_at_0),
      cmocka_unit_test(triangles_larger_than_the_range_are_clipped),
      cmocka_unit_test(map_shows_what_rays_hit),
      cmocka_unit_test(what_casts_no_shadow_is_left_out),
      cmocka_unit_test(sizes_that_do_not_fit_are_refused),
  };
  return cmocka_run_group_tests(tests, raster_tests_begin, raster_tests_end);
}
