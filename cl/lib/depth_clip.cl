// A triangle of a depth map that crosses the eye plane or leaves the range of the integers, cut to what lies before
// both.
//
// Where two triangles share an edge both cut it at the same point, as a point is always computed from the end that
// stays: there are no cracks. Such a point is off by a rounding of the distance to the far end: a triangle of a
// kilometre is cut within 0.1 mm.
//
//   From  Sutherland, Hodgman, "Reentrant Polygon Clipping", 1974.

#include "lib/lanes.cl"
#include "shared/raster.h"
#include "shared/view.h"

#define CLIP_VERTICES 8  // a triangle and five planes

typedef struct ClipPolygon {
  float4 vertex[CLIP_VERTICES];  // x, y, depth and w before division, pixels
  uint count;
} ClipPolygon;

// Keeps what has dot(plane, (x, y, depth, w)) >= least. Most planes cut nothing off.
static inline void polygon_cut(ClipPolygon *polygon, float4 plane, float least)
{
  ClipPolygon out;
  bool whole = true;
  for (uint i = 0; i < polygon->count; i++) whole = whole && dot(polygon->vertex[i], plane) - least >= 0;
  if (whole) return;
  out.count = 0;
  for (uint i = 0; i < polygon->count; i++) {
    float4 a = polygon->vertex[i], b = polygon->vertex[i + 1 == polygon->count ? 0 : i + 1];
    float side_a = dot(a, plane) - least, side_b = dot(b, plane) - least;
    bool a_stays = side_a >= 0, b_stays = side_b >= 0;
    if (a_stays && out.count < CLIP_VERTICES) out.vertex[out.count++] = a;
    if (a_stays == b_stays || out.count == CLIP_VERTICES) continue;
    float4 from = a_stays ? a : b, to = a_stays ? b : a;
    float side_from = a_stays ? side_a : side_b, side_to = a_stays ? side_b : side_a;
    out.vertex[out.count++] = from + (to - from) * (side_from / (side_from - side_to));
  }
  *polygon = out;
}

static inline ClipPolygon depth_clip(constant RasterView *view, float4 a, float4 b, float4 c)
{
  ClipPolygon polygon;
  const float guard = RASTER_GUARD_PX;
  polygon.vertex[0] = a;
  polygon.vertex[1] = b;
  polygon.vertex[2] = c;
  polygon.count = 3;
  if (!view->parallel) polygon_cut(&polygon, (float4)(0, 0, 0, 1), view->least_w);
  polygon_cut(&polygon, (float4)(1, 0, 0, guard), 0);
  polygon_cut(&polygon, (float4)(-1, 0, 0, guard), 0);
  polygon_cut(&polygon, (float4)(0, 1, 0, guard), 0);
  polygon_cut(&polygon, (float4)(0, -1, 0, guard), 0);
  return polygon;
}

// Where a corner of a clipped polygon is on the map, in 1/RASTER_SNAP of a texel (halves up), and its depth. Rounding
// may have left it a little before the least w or beyond the range.
typedef struct ClipCorner {
  int x, y;
  float depth;
} ClipCorner;

static inline int snap_within(float px)
{
  const float guard = RASTER_GUARD_PX;
  px = px > -guard ? px : -guard;
  px = px < guard ? px : guard;
  return (int)floor(px * RASTER_SNAP + 0.5f);
}

static inline ClipCorner clip_project(constant RasterView *view, float4 v)
{
  float w = view->parallel || v.w > view->least_w ? v.w : view->least_w;
  ClipCorner corner = {snap_within(v.x / w), snap_within(v.y / w),
                       view->parallel ? v.z : view->depth_far + view->depth_by_w / w};
  return corner;
}
