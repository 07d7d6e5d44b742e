// A view that triangles are drawn into: a camera's picture or one depth map of several. Written by host/passes, read by
// cl/raster.
#ifndef SHARED_VIEW_H
#define SHARED_VIEW_H

#include "shared/types.h"

// A position p is taken relative to the origin, so that its digits are spent on what is near: a = p - origin. Each row
// is dotted with (a, 1). Pixel x = x / w, pixel y = y / w, from the top left corner of the view; w is the depth along
// the view axis, or 1 for parallel projection.
//   camera  depth is t of its rays: the depth along the view axis; hits lie in (near, far]
//   map     depth / w lies in [near, far] = [0, 1]; what is nearer is drawn at 0 where w >= least_w, what is farther is
//   not.
//           In perspective depth / w = depth_far + depth_by_w / w, which is more exact.
typedef struct RasterView {
  Float3 origin;
  Float4 x, y, w, depth;
  float norm_x, norm_y, norm_w;  // lengths of the first three numbers of the rows
  float near, far;
  float depth_far, depth_by_w;
  float least_w;     // map: nothing nearer to the eye plane is drawn
  uint first_texel;  // map: where its texels begin (shared/depth_map.h), a multiple of 16
  uint parallel;     // w is 1
  uint mirrored;     // x, y and w are the axes of a left-handed system
  uint width, height;
  // Camera: bounds on what rounding may do between a vertex as set up here and where a sample's ray meets it. On the
  // picture: error_px (largest |a| / w)^2 pixels, or in parallel projection error_px + error_px_m x largest |a|. In
  // depth: 4 RASTER_ROUNDING x largest |a| + error_m.
  float error_px, error_px_m, error_m;
} RasterView;
SHARED_SIZE(RasterView, 140);

#define RASTER_ROUNDING 3.814697e-6f  // 64 x 2^-24

#endif
