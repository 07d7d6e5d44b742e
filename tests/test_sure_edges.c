// Small triangles on large light maps: texels name those that touch them and no others, and are covered by those that
// hide them whole, to within a part of a texel.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "passes/sure_maps.h"
#include "support/raster_fixture.h"

enum { SIZE_PX = 4096, FIRST_TILE = 240, TILES = 6, TRIANGLES = 200, WINDOW_PX = TILES * SHADOW_TILE_PX };

// Corners on the map, in texels.
typedef struct Flat {
  double at[3][2];
} Flat;

static double area_of(const Flat *t)
{
  return fabs((t->at[1][0] - t->at[0][0]) * (t->at[2][1] - t->at[0][1]) -
              (t->at[2][0] - t->at[0][0]) * (t->at[1][1] - t->at[0][1])) /
         2;
}

// How far apart a triangle and a square are along the axis, of those that may part them, where that is the most; below
// 0, how deep in each other. `inside`: how deep the square is within the triangle, or below 0, how far it sticks out.
static double gap_of(const Flat *t, double x, double y, double *inside)
{
  const double square[4][2] = {{x, y}, {x + 1, y}, {x, y + 1}, {x + 1, y + 1}};
  double gap = -INFINITY;
  *inside = INFINITY;
  for (int axis = 0; axis < 2; axis++) {
    const double low = fmin(fmin(t->at[0][axis], t->at[1][axis]), t->at[2][axis]),
                 high = fmax(fmax(t->at[0][axis], t->at[1][axis]), t->at[2][axis]);
    gap = fmax(gap, fmax(low - square[3][axis], square[0][axis] - high));
  }
  for (int i = 0; i < 3; i++) {
    const double *a = t->at[i], *b = t->at[(i + 1) % 3], *c = t->at[(i + 2) % 3];
    double nx = a[1] - b[1], ny = b[0] - a[0], length = hypot(nx, ny), deepest = -INFINITY, least = INFINITY;
    if (nx * (c[0] - a[0]) + ny * (c[1] - a[1]) < 0) length = -length;
    for (int k = 0; k < 4; k++) {
      const double depth = (nx * (square[k][0] - a[0]) + ny * (square[k][1] - a[1])) / length;
      deepest = fmax(deepest, depth);
      least = fmin(least, depth);
    }
    gap = fmax(gap, -deepest);
    *inside = fmin(*inside, least);
  }
  return gap;
}

static ShadowFit spot_fit(void)
{
  ShadowFit fit;
  const Camera camera = {
      .kind = CAMERA_PERSPECTIVE, .yfov_rad = 1, .znear_m = 0.1, .zfar_m = 100, .world_from_camera = mat4_identity()};
  const CameraInfo info = camera_info(&camera, &(PictureArea){64, 64, 0, 0, 64, 64});
  const LightInfo spot = {.kind = LIGHT_KIND_SPOT,
                          .position = {0.3f, -0.2f, 0.1f},
                          .direction = {0, 0, -1},
                          .radiant = {1, 1, 1},
                          .range_m = INFINITY,
                          .spot_scale = 1,
                          .spot_offset = -0.75f};
  const ShadowScope scope = {&info, vec3(-8, -8, -8), vec3(8, 8, -3)};
  assert_true(shadow_fit(&fit, &spot, SHADOWS_HYBRID, &(ShadowOptions){.map_size_px = SIZE_PX}, &scope));
  assert_int_equal(fit.info.view_count, 1);
  return fit;
}

// Triangles about half a texel to twelve wide, in the map's window.
static Soup soup_make(const ShadowView *view)
{
  Soup soup = {0};
  Random random = random_make(7);
  while (soup.triangle_count < TRIANGLES) {
    Flat flat;
    float corner[3][3];
    const float size = random_between(&random, 0.5f, 12), w = random_between(&random, 4, 6);
    const float x = FIRST_TILE * SHADOW_TILE_PX + random_between(&random, 8, WINDOW_PX - 8),
                y = FIRST_TILE * SHADOW_TILE_PX + random_between(&random, 8, WINDOW_PX - 8);
    for (int i = 0; i < 3; i++) {
      const float px = x + random_between(&random, -size, size) / 2, py = y + random_between(&random, -size, size) / 2,
                  away = w * random_between(&random, 0.999f, 1.001f);
      const Float3 o = view->raster.origin, s = view->sight_0, r = view->sight_x, d = view->sight_y;
      corner[i][0] = o.x + (s.x + px * r.x + py * d.x) * away;
      corner[i][1] = o.y + (s.y + px * r.y + py * d.y) * away;
      corner[i][2] = o.z + (s.z + px * r.z + py * d.z) * away;
      flat.at[i][0] = px;
      flat.at[i][1] = py;
    }
    if (area_of(&flat) < 0.15 * size * size) continue;
    uint32_t v[3];
    for (int i = 0; i < 3; i++) v[i] = soup_vertex(&soup, corner[i][0], corner[i][1], corner[i][2]);
    soup_triangle(&soup, v[0], v[1], v[2]);
  }
  return soup;
}

static double row_of(Float4 row, const double a[3])
{
  return (double)row.x * a[0] + (double)row.y * a[1] + (double)row.z * a[2] + (double)row.w;
}

static Flat flat_of(const BvhTriangle *triangle, const RasterView *view)
{
  Flat flat;
  const Float3 o = view->origin;
  for (int i = 0; i < 3; i++) {
    const float *p = triangle->vertex[i];
    const double a[3] = {(double)p[0] - (double)o.x, (double)p[1] - (double)o.y, (double)p[2] - (double)o.z};
    flat.at[i][0] = row_of(view->x, a) / row_of(view->w, a);
    flat.at[i][1] = row_of(view->y, a) / row_of(view->w, a);
  }
  return flat;
}

static void *buffer_copy(Device *device, const DeviceBuffer *buffer)
{
  void *to = malloc(buffer->bytes);
  assert_non_null(to);
  raster_assert_ok(buffer_read(device, buffer, to, buffer->bytes, &raster_log));
  return to;
}

// Draws the window's tiles alone.
static void window_draw(SureMaps *maps, Device *device, const RasterFixture *fixture, const ShadowFit *fit)
{
  static const uint32_t all = 0x007fffffu;  // whatever the closeness: what cl/rays/shadow_mark.cl makes of -INFINITY
  const uint32_t columns = TILE_COLUMNS(SIZE_PX), no_solid = 0;
  SureRaster raster;
  DeviceBuffer solid;
  uint32_t *marks = malloc((size_t)columns * columns * sizeof *marks);
  assert_non_null(marks);
  for (uint32_t i = 0; i < columns * columns; i++) {
    const uint32_t x = i % columns - FIRST_TILE, y = i / columns - FIRST_TILE;
    marks[i] = x < TILES && y < TILES ? all : SHADOW_TILE_UNKNOWN;
  }
  raster_assert_ok(buffer_create(&solid, device, sizeof no_solid, &no_solid, "solid", &raster_log));
  raster_assert_ok(sure_raster_make(&raster, device, &fixture->triangles, &(RasterOptions){0}, &raster_log));
  raster_assert_ok(sure_maps_aim(maps, device, fit, 1, true, &raster_log));
  raster_assert_ok(buffer_write(device, &maps->marks, marks, maps->marks.bytes, &raster_log));
  raster_assert_ok(sure_maps_read_marks(maps, device, &raster_log));
  raster_assert_ok(sure_maps_settle(maps, device, NULL, NULL, &raster_log));
  assert_int_equal(maps->known_tiles[0], TILES * TILES);
  raster_assert_ok(
      sure_maps_draw(maps, 0, &raster, device, &fixture->triangles, &solid, SURE_NONE_MARKED, &raster_log));
  sure_raster_free(&raster);
  buffer_free(&solid);
  free(marks);
}

// What was drawn, on the host.
typedef struct Drawn {
  BvhTriangle *triangles;
  ShadowTile *tiles;
  ShadowBlock *blocks;
  ShadowRow *rows;
  uint32_t block_count;
} Drawn;

// Texel `at` of a block; without a block nothing is in its tile.
typedef struct Texel {
  uint32_t x, y, at;
  const ShadowBlock *block;
  const ShadowRow *rows;  // from the second on
} Texel;

static Texel texel_of(const Drawn *drawn, uint32_t p)
{
  const uint32_t first = FIRST_TILE * SHADOW_TILE_PX, x = first + p % WINDOW_PX, y = first + p / WINDOW_PX;
  const ShadowTile *tile = &drawn->tiles[y / SHADOW_TILE_PX * TILE_COLUMNS(SIZE_PX) + x / SHADOW_TILE_PX];
  const uint32_t block = tile->first_block + y % SHADOW_TILE_PX / 4 * 4 + x % SHADOW_TILE_PX / 4;
  const bool is_there = tile->near > -INFINITY;
  return (Texel){x, y, y % 4 * 4 + x % 4, is_there ? &drawn->blocks[block] : NULL, drawn->rows + block};
}

static bool texel_names(const Texel *texel, const Drawn *drawn, uint32_t number)
{
  for (uint32_t k = 0; texel->block && k < texel->block->row_count; k++) {
    const ShadowRow *row = k ? texel->rows + (size_t)(k - 1) * drawn->block_count : &texel->block->first;
    if (row->near[texel->at] > -INFINITY && (row->number[texel->at] & ~SHADOW_CLOSED) == number) return true;
  }
  return false;
}

static bool texel_is_covered(const Texel *texel)
{
  return texel->block && texel->block->covered[texel->at] > -INFINITY;
}

// Texels in which a triangle was looked for.
typedef struct Counts {
  uint32_t touched, beside, hidden;
} Counts;

// Fails unless a texel knows of a triangle what is so, but for parts of a texel that rounding on such a map and
// SURE_PADDING take. Says whether the triangle hides all of it.
static bool texel_check(Counts *counts, const Texel *texel, const Drawn *drawn, const Flat *flat, uint32_t number)
{
  const double beside = 0.35, within = 0.5;
  double inside;
  const double gap = gap_of(flat, texel->x, texel->y, &inside);
  const bool named = texel_names(texel, drawn, number), covered = texel_is_covered(texel),
             overfull = texel->block && texel->block->rest[texel->at] > -INFINITY;
  if (gap < 0 && !named && !covered && !overfull)
    fail_msg("texel %u, %u does not name triangle %u, which touches it", texel->x, texel->y, number);
  if (gap > beside && named) fail_msg("texel %u, %u names triangle %u, %g away", texel->x, texel->y, number, gap);
  if (inside > within && !covered)
    fail_msg("texel %u, %u, by %g within triangle %u, is not covered", texel->x, texel->y, inside, number);
  counts->touched += gap < 0 && named;
  counts->beside += gap > 0 && named;
  counts->hidden += inside > within;
  return inside >= 0;
}

static void texels_know_small_triangles(void **state)
{
  static bool hidden[WINDOW_PX * WINDOW_PX];  // by one triangle
  const ShadowFit fit = spot_fit();
  Soup soup = soup_make(&fit.views[0]);
  RasterFixture fixture;
  SureMaps maps = {0};
  Counts counts = {0};
  raster_fixture_of_soup(&fixture, &soup);
  Device *device = raster_device(RASTER_BINS_16);
  window_draw(&maps, device, &fixture, &fit);
  Drawn drawn = {buffer_copy(device, &fixture.scene.bvh2_triangles), buffer_copy(device, &maps.tiles),
                 buffer_copy(device, &maps.blocks), buffer_copy(device, &maps.rows), maps.block_count};
  for (uint32_t i = 0; i < fixture.triangles.triangle_count; i++) {
    const Flat flat = flat_of(&drawn.triangles[i], &fit.views[0].raster);
    for (uint32_t p = 0; p < WINDOW_PX * WINDOW_PX; p++) {
      const Texel texel = texel_of(&drawn, p);
      hidden[p] |= texel_check(&counts, &texel, &drawn, &flat, i);
    }
  }
  for (uint32_t p = 0; p < WINDOW_PX * WINDOW_PX; p++) {
    const Texel texel = texel_of(&drawn, p);
    if (texel_is_covered(&texel) && !hidden[p]) fail_msg("texel %u, %u is covered by nothing", texel.x, texel.y);
  }
  printf("%u triangles: named by %u texels that they touch and %u beside; %u are hidden\n", TRIANGLES, counts.touched,
         counts.beside, counts.hidden);
  assert_true(counts.touched > 1000 && counts.hidden > 100 && counts.beside < counts.touched / 8);
  free(drawn.triangles);
  free(drawn.tiles);
  free(drawn.blocks);
  free(drawn.rows);
  sure_maps_free(&maps);
  raster_fixture_free(&fixture);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(texels_know_small_triangles),
  };
  return cmocka_run_group_tests(tests, raster_tests_begin, raster_tests_end);
}
