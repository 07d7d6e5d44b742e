#include "passes/raster_view.h"

#include <math.h>

static Vec3 wide(Float3 v) { return vec3(v.x, v.y, v.z); }

static Float4 row(Vec3 v, double last) { return (Float4){(float)v.x, (float)v.y, (float)v.z, (float)last}; }

// Counted in roundings (2^-24) of the largest component, on the plane at depth 1: the intersection moves a vertex by 17
// (|a| / w)^2 (lib/triangle.cl: 12 across the ray, which meets that plane at a slant), a sample's direction is off by
// 16 (1 + T), T being where the plane's corner is, and the setup's own projection by 4 (1 + 2 T + |a| / w) |a| / w. As
// |a| / w is at least 1, 49 (1 + T) (|a| / w)^2 is above their sum. In parallel projection all of it is in metres, and
// rays have origins, which are rounded at their distance from the world's.
RasterView raster_view_of_camera(const CameraInfo *camera)
{
  Vec3 position = wide(camera->position), forward = wide(camera->forward), right = wide(camera->right),
       down = wide(camera->down);
  double per_px = 1 / (double)camera->scale;
  double center_x = (double)camera->center_x * per_px - camera->crop_x,
         center_y = (double)camera->center_y * per_px - camera->crop_y;
  Vec3 x = vec3_scale(right, per_px), y = vec3_scale(down, per_px);
  bool parallel = camera->orthographic;
  double half_width = fmax(fabs(center_x), fabs(camera->width - center_x)) * camera->scale;
  double half_height = fmax(fabs(center_y), fabs(camera->height - center_y)) * camera->scale;
  double extent = half_width + half_height;
  if (!parallel) {
    x = vec3_add(x, vec3_scale(forward, center_x));
    y = vec3_add(y, vec3_scale(forward, center_y));
  }
  double far_off = parallel ? vec3_length(position) + extent : 0;
  return (RasterView){
      .origin = camera->position,
      .x = row(x, parallel ? center_x : 0),
      .y = row(y, parallel ? center_y : 0),
      .w = parallel ? (Float4){0, 0, 0, 1} : row(forward, 0),
      .depth = row(forward, 0),
      .norm_x = (float)vec3_length(x),
      .norm_y = (float)vec3_length(y),
      .norm_w = parallel ? 0 : (float)vec3_length(forward),
      .near = camera->near_m,
      .far = camera->far_m,
      .parallel = parallel,
      .mirrored = vec3_dot(vec3_cross(right, down), forward) < 0,
      .width = camera->width,
      .height = camera->height,
      .error_px = (float)(RASTER_ROUNDING * per_px * (parallel ? far_off : 1 + extent)),
      .error_px_m = parallel ? (float)(RASTER_ROUNDING * per_px) : 0,
      .error_m = (float)(RASTER_ROUNDING * far_off),
  };
}

// Row `index` of the matrix times `scale`, for positions relative to the origin.
static Float4 map_row(const Mat4 *m, int index, double scale, Vec3 origin)
{
  Vec3 v = vec3_scale(vec3(m->m[index], m->m[4 + index], m->m[8 + index]), scale);
  return row(v, vec3_dot(v, origin) + m->m[12 + index] * scale);
}

RasterView raster_view_of_map(const Mat4 *map_from_world, Vec3 origin_world, uint32_t size_px, double least_w)
{
  const double *m = map_from_world->m;
  bool parallel = m[3] == 0 && m[7] == 0 && m[11] == 0 && m[15] == 1;
  Float3 origin = {(float)origin_world.x, (float)origin_world.y, (float)origin_world.z};
  Vec3 rounded = wide(origin);
  // depth = depth_far w + depth_by_w
  Vec3 w = vec3(m[3], m[7], m[11]), depth = vec3(m[2], m[6], m[10]);
  double depth_far = parallel ? 0 : vec3_dot(depth, w) / vec3_dot(w, w);
  return (RasterView){
      .origin = origin,
      .x = map_row(map_from_world, 0, size_px, rounded),
      .y = map_row(map_from_world, 1, size_px, rounded),
      .depth = map_row(map_from_world, 2, 1, rounded),
      .w = map_row(map_from_world, 3, 1, rounded),
      .far = 1,
      .depth_far = (float)depth_far,
      .depth_by_w = (float)(parallel ? 0 : m[14] - depth_far * m[15]),
      .least_w = parallel ? 0 : (float)least_w,
      .parallel = parallel,
      .width = size_px,
      .height = size_px,
  };
}

// The greatest row . (a, 1) of points, as a share of what it is rounded by.
static double farthest_inside(Float4 plane, Vec3 origin, const Vec3 *points, uint32_t count)
{
  double most = -INFINITY, size = fabs(plane.w);
  for (uint32_t i = 0; i < count; i++) {
    Vec3 a = vec3_sub(points[i], origin);
    most = fmax(most, plane.x * a.x + plane.y * a.y + plane.z * a.z + plane.w);
    size = fmax(size, fabs(plane.x * a.x) + fabs(plane.y * a.y) + fabs(plane.z * a.z));
  }
  return size > 0 ? most / size : 0;
}

bool raster_view_may_see(const RasterView *view, const Vec3 *points_world, uint32_t count)
{
  const double rounding = 1e-5;
  for (uint32_t i = 0; i < count; i++)
    if (!vec3_is_finite(points_world[i])) return true;
  const float across = (float)view->width, down = (float)view->height;
  const Float4 x = view->x, y = view->y, w = view->w;
  const Float4 planes[] = {x,
                           {across * w.x - x.x, across * w.y - x.y, across * w.z - x.z, across * w.w - x.w},
                           y,
                           {down * w.x - y.x, down * w.y - y.y, down * w.z - y.z, down * w.w - y.w},
                           w};
  for (size_t i = 0; i < sizeof planes / sizeof *planes; i++)
    if (farthest_inside(planes[i], wide(view->origin), points_world, count) < -rounding) return false;
  return true;
}

bool raster_view_may_see_box(const RasterView *view, Vec3 low, Vec3 high)
{
  Vec3 corners[BOX_CORNERS];
  box_corners(corners, low, high);
  return raster_view_may_see(view, corners, BOX_CORNERS);
}
