// What bounds blocks of depth maps, and squares of blocks, against every texel in double precision; at each width.

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "shared/depth_map.h"
#include "support/map_fixture.h"
#include "support/oracle_scene.h"

enum { VIEWS = 2, BEFORE = 48 };      // floats of something else that lie before the maps
static const double rounding = 4e-7;  // of depths and slopes up to 1, over 16 texels

// A map of planes with steps, noise and holes between them; the first quarter of it is one plane.
static void map_invent(float *map, uint32_t size, Random *random)
{
  const float by_x = 0.4f / (float)size, by_y = -0.2f / (float)size;
  for (uint32_t y = 0; y < size; y++) {
    for (uint32_t x = 0; x < size; x++) {
      float depth = 0.3f + by_x * (float)x + by_y * (float)y;
      if (y >= size / 4) {
        if (random_next(random) % 3 == 0) depth += 1e-3f * (float)(random_next(random) % 100) / 100;
        if (x / 11 % 2) depth -= 0.1f;
        if (y / 7 % 5 == 4 || random_next(random) % 400 == 0) depth = 1;
      }
      map[depth_map_index(x, y, size)] = depth;
    }
  }
}

typedef struct Bounds {
  uint32_t whole, holed, empty, flat;  // blocks by what their texels hold
} Bounds;

// Checks the plane of the texels [x0, x0 + side) x [y0, y0 + side) of a map.
static void plane_check(Bounds *bounds, const float plane[4], const float *map, uint32_t size, uint32_t x0, uint32_t y0,
                        uint32_t side)
{
  double least = INFINITY, most = -INFINITY;  // of texels above the plane's slopes
  uint32_t filled = 0;
  for (uint32_t y = 0; y < side; y++) {
    for (uint32_t x = 0; x < side; x++) {
      const double depth = map[depth_map_index(x0 + x, y0 + y, size)];
      const double level = depth - (double)plane[DEPTH_PLANE_BY_X] * x - (double)plane[DEPTH_PLANE_BY_Y] * y;
      if (depth == 1) continue;
      filled++;
      least = fmin(least, level);
      most = fmax(most, level);
    }
  }
  const bool is_whole = filled == side * side;
  const double low = plane[DEPTH_PLANE_LOW], high = plane[DEPTH_PLANE_HIGH];
  bounds->whole += is_whole;
  bounds->empty += filled == 0;
  bounds->holed += filled && !is_whole;
  assert_true(filled ? low <= least + rounding : low == INFINITY);
  assert_true(is_whole ? high >= most - rounding : high == INFINITY);
  if (filled && side == 4) assert_true(low >= least - rounding);  // of a square's blocks corners count, not texels
  if (y0 + side > size / 4) return;
  bounds->flat++;
  assert_true(high - low < 2 * rounding);
}

static void planes_bound_all_texels(void **state)
{
  static const uint32_t sizes[] = {16, 64, 20, 272};  // squares of a map of 20 would not be whole
  for (int variant = RASTER_BINS_16; variant <= RASTER_BINS_8; variant++) {
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
      const uint32_t size = sizes[s], texels = size * size, blocks = depth_plane_floats(size),
                     wide = depth_wide_floats(size), count = BEFORE + VIEWS * (texels + blocks + wide) + 12;
      Random random = random_make(size);
      Soup soup = {0};
      soup_triangle(&soup, soup_vertex(&soup, 0, 0, 0), soup_vertex(&soup, 1, 0, 0), soup_vertex(&soup, 0, 1, 0));
      RasterFixture fixture;
      raster_fixture_of_soup(&fixture, &soup);
      Device *device = raster_device((RasterVariant)variant);
      float *floats = oracle_array(count, sizeof *floats), *maps = floats + BEFORE;
      for (uint32_t i = 0; i < VIEWS; i++) map_invent(maps + i * texels, size, &random);
      DeviceBuffer buffer;
      raster_assert_ok(buffer_create(&buffer, device, count * sizeof *floats, floats, "maps", &raster_log));
      raster_assert_ok(raster_depth_planes(device, &fixture.scene, &buffer, BEFORE, size, VIEWS, &raster_log));
      raster_assert_ok(buffer_read(device, &buffer, floats, count * sizeof *floats, &raster_log));
      Bounds of_blocks = {0}, of_squares = {0};
      for (uint32_t i = 0; i < VIEWS; i++) {
        const float *map = maps + i * texels, *planes = maps + VIEWS * texels + i * blocks;
        const float *squares = maps + VIEWS * (texels + blocks) + i * wide;
        for (uint32_t at = 0; at < blocks; at += 4)
          plane_check(&of_blocks, planes + at, map, size, at / 4 % (size / 4) * 4, at / 4 / (size / 4) * 4, 4);
        for (uint32_t at = 0; at < wide; at += 4)
          plane_check(&of_squares, squares + at, map, size, at / 4 % (size / 16) * 16, at / 4 / (size / 16) * 16, 16);
      }
      if (size == 272) {
        printf("%s: blocks whole %u, holed %u, empty %u, of one plane %u; squares %u, %u, %u, %u\n",
               raster_variant_names[variant], of_blocks.whole, of_blocks.holed, of_blocks.empty, of_blocks.flat,
               of_squares.whole, of_squares.holed, of_squares.empty, of_squares.flat);
        assert_true(of_blocks.whole > 1000 && of_blocks.holed > 1000 && of_blocks.empty > 200);
        assert_true(of_squares.whole > 80 && of_squares.holed > 200 && of_squares.flat > 100);
      }
      buffer_free(&buffer);
      free(floats);
      raster_fixture_free(&fixture);
    }
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(planes_bound_all_texels)};
  return cmocka_run_group_tests(tests, raster_tests_begin, raster_tests_end);
}
