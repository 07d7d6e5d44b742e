// Views for the raster stages (shared/view.h).
#pragma once

#include <stdbool.h>

#include "base/math3d.h"
#include "shared/camera.h"
#include "shared/view.h"

// The view of a camera's picture, from the very numbers that the ray generator reads.
RasterView raster_view_of_camera(const CameraInfo *camera);

// The view of a depth map of size_px texels a side. map_from_world takes a position to (x, y, depth) in [0, 1]^3 after
// division by w, x and y from the map's top left corner. `origin_world` is what positions are taken relative to: the
// light, or the middle of what a parallel projection shows. In perspective depth must be a function of
// w alone, as it is in every projection whose near and far planes face the view, and nothing nearer than least_w is
// drawn; what is farther than that and before depth 0 is drawn at 0.
RasterView raster_view_of_map(const Mat4 *map_from_world, Vec3 origin_world, uint32_t size_px, double least_w);

// May something of the convex hull of points be drawn in the view? Depths count only where they are not before the eye.
// True where that is not sure.
bool raster_view_may_see(const RasterView *view, const Vec3 *points_world, uint32_t count);
bool raster_view_may_see_box(const RasterView *view, Vec3 low_world, Vec3 high_world);
