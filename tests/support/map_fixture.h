// Depth maps as tests draw them: views, and a scene's maps by each way and width of raster.
#pragma once

#include "passes/raster_depth.h"
#include "support/raster_fixture.h"

// A map's view in rows: x, y, depth and w of a position before division.
RasterView map_view_of_rows(const double rows[4][4], Vec3 origin, uint32_t size, double least_w);

// World x, y and z in [0, 1] are the map's own.
RasterView map_view_flat(uint32_t size);

// A face of a cube around `eye`: w is the distance along axis face / 2, depth is 1 - near / w.
RasterView map_view_of_face(int face, Vec3 eye, uint32_t size, double near_m);

// Draws the views of a fixture's scene; `options` may be NULL for the usual. Returns [y][x] of one view behind
// the other, which the caller frees. Failures of these functions fail the test.
float *maps_draw(RasterFixture *fixture, const RasterView *views, uint32_t view_count, RasterVariant variant,
                 const RasterOptions *options);

// The maps by the first variant; fails unless all give the same bytes.
float *maps_by_all(RasterFixture *fixture, const RasterView *views, uint32_t view_count);

// The same for a soup, which it frees.
float *maps_of_soup(Soup *soup, const RasterView *views, uint32_t view_count);
