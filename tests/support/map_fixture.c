#include "support/map_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "shared/depth_map.h"
#include "support/oracle_scene.h"

RasterView map_view_of_rows(const double rows[4][4], Vec3 origin, uint32_t size, double least_w)
{
  Mat4 m;
  for (int row = 0; row < 4; row++)
    for (int column = 0; column < 4; column++) m.m[4 * column + row] = rows[row][column];
  return raster_view_of_map(&m, origin, size, least_w);
}

RasterView map_view_flat(uint32_t size)
{
  static const double rows[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  return map_view_of_rows(rows, vec3(0, 0, 0), size, 0);
}

RasterView map_view_of_face(int face, Vec3 eye, uint32_t size, double near_m)
{
  double rows[4][4] = {{0}}, sign = face % 2 ? -1 : 1, e[3] = {eye.x, eye.y, eye.z};
  int z = face / 2, x = (z + 1) % 3, y = (z + 2) % 3;
  rows[3][z] = sign;
  rows[0][x] = rows[1][y] = 0.5;
  rows[0][z] = rows[1][z] = 0.5 * sign;
  rows[2][z] = sign;
  for (int row = 0; row < 4; row++)
    for (int axis = 0; axis < 3; axis++) rows[row][3] -= rows[row][axis] * e[axis];
  rows[2][3] -= near_m;
  return map_view_of_rows(rows, eye, size, near_m / 2);
}

static size_t texels_of(const RasterView *views, uint32_t view_count)
{
  size_t texels = 0;
  for (uint32_t i = 0; i < view_count; i++) texels += (size_t)views[i].width * views[i].width;
  return texels;
}

float *maps_draw(RasterFixture *fixture, const RasterView *views, uint32_t view_count, RasterVariant variant,
                 const RasterOptions *options)
{
  RasterDepth raster;
  RasterOptions all = options ? *options : (RasterOptions){0};
  Device *device = raster_device(variant);
  const size_t texels = texels_of(views, view_count);
  all.way = variant == RASTER_DIRECT_1 ? RASTER_WAY_DIRECT : RASTER_WAY_BINS;
  raster_assert_ok(raster_depth_make(&raster, device, &fixture->scene, &all, &raster_log));
  RasterView *before = oracle_array(view_count, sizeof *before);
  for (uint32_t i = 0; i < view_count; i++) {
    before[i] = views[i];
    before[i].x = views[i].y;
    before[i].y = views[i].x;
  }
  for (int use = 0; use < 2; use++)  // what was drawn before leaves no trace
    raster_assert_ok(raster_depth(&raster, device, &fixture->scene, &fixture->triangles, use ? views : before,
                                  view_count, &raster_log));
  free(before);
  float *blocks = oracle_array(texels, sizeof *blocks), *rows = oracle_array(texels, sizeof *rows);
  raster_assert_ok(buffer_read(device, &raster.maps, blocks, texels * sizeof *blocks, &raster_log));
  for (uint32_t view = 0; view < view_count; view++) {
    const size_t first = texels_of(views, view), size = views[view].width;
    for (uint32_t y = 0; y < size; y++)
      for (uint32_t x = 0; x < size; x++)
        rows[first + y * size + x] = blocks[first + depth_map_index(x, y, (uint32_t)size)];
  }
  raster_depth_free(&raster);
  free(blocks);
  return rows;
}

float *maps_by_all(RasterFixture *fixture, const RasterView *views, uint32_t view_count)
{
  const size_t bytes = texels_of(views, view_count) * sizeof(float);
  float *maps = maps_draw(fixture, views, view_count, RASTER_BINS_16, NULL);
  for (int variant = RASTER_BINS_8; variant < raster_variant_count(); variant++) {
    float *other = maps_draw(fixture, views, view_count, (RasterVariant)variant, NULL);
    if (memcmp(maps, other, bytes)) fail_msg("%s: not the same map", raster_variant_names[variant]);
    free(other);
  }
  return maps;
}

float *maps_of_soup(Soup *soup, const RasterView *views, uint32_t view_count)
{
  RasterFixture fixture;
  raster_fixture_of_soup(&fixture, soup);
  float *maps = maps_by_all(&fixture, views, view_count);
  raster_fixture_free(&fixture);
  return maps;
}
