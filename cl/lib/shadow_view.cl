// Which of a light's maps a point is in, and where: shared/shadow.h.

#include "lib/view.cl"
#include "shared/shadow.h"

// A point in one map. `depth` is what the map holds; `w` is 1 in parallel projection.
typedef struct MapPoint {
  FloatL x, y, w, depth;
} MapPoint;

static inline Vec3L shadow_relative(global const ShadowView *view, Vec3L point)
{
  Float3 origin = view->raster.origin;
  return sub3(point, vec3l(FLOATL(origin.x), FLOATL(origin.y), FLOATL(origin.z)));
}

static inline MapPoint shadow_project(global const ShadowView *view, Vec3L relative)
{
  global const RasterView *raster = &view->raster;
  MapPoint p;
  FloatL one = FLOATL(1);
  p.w = raster->parallel ? one : row_dot(raster->w, relative);
  FloatL inverse = one / p.w;
  p.x = row_dot(raster->x, relative) * inverse;
  p.y = row_dot(raster->y, relative) * inverse;
  p.depth = raster->parallel ? row_dot(raster->depth, relative)
                             : FLOATL(raster->depth_far) + FLOATL(raster->depth_by_w) * inverse;
  return p;
}

static inline IntL shadow_in_view(const MapPoint *p, global const ShadowInfo *info, bool parallel)
{
  FloatL low = FLOATL((float)info->gutter_px), high = FLOATL((float)(info->size_px - info->gutter_px));
  IntL before = parallel ? INTL(-1) : p->w > FLOATL(0);
  return before & (p->x >= low) & (p->x <= high) & (p->y >= low) & (p->y <= high);
}

#define SHADOW_VIEW_NONE 0xffu

// The map of each lane's point (world space); SHADOW_VIEW_NONE where none holds it.
static inline UintL shadow_view_choose(global const ShadowInfo *info, global const ShadowView *views, Vec3L point)
{
  UintL none = UINTL(SHADOW_VIEW_NONE);
  if (info->views == SHADOW_VIEWS_CUBE) {
    Vec3L a = shadow_relative(&views[0], point);
    FloatL x = fabs(a.x), y = fabs(a.y), z = fabs(a.z), zero = FLOATL(0);
    IntL by_x = (x >= y) & (x >= z), by_y = !by_x & (y >= z);
    UintL face = by_x ? (a.x < zero ? UINTL(1) : UINTL(0)) : (a.z < zero ? UINTL(5) : UINTL(4));
    face = by_y ? (a.y < zero ? UINTL(3) : UINTL(2)) : face;
    return max_lane(max_lane(x, y), z) > zero ? face : none;
  }
  UintL chosen = none;
  for (uint i = info->view_count; i-- > 0;) {
    MapPoint p = shadow_project(&views[i], shadow_relative(&views[i], point));
    chosen = shadow_in_view(&p, info, views[i].raster.parallel) ? UINTL(i) : chosen;
  }
  return chosen;
}
