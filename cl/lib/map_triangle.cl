// Triangles of a depth map: snapped vertices, integer edge functions, depth by plane. What a map shows is settled here,
// for both ways of drawing it.
//
// Vertices are snapped to 1/RASTER_SNAP of a texel and turned so that their area is positive. A texel belongs to a
// triangle if its centre is inside, or on a top or left edge: of two triangles that share an edge just one has it.
//
//   From  Pineda, "A Parallel Algorithm for Polygon Rasterization", 1988.

#include "lib/alpha.cl"
#include "lib/depth_clip.cl"
#include "lib/shadowless.cl"
#include "lib/view.cl"
#include "shared/bvh.h"

typedef struct MapTriangle {
  IntL x[3], y[3];                        // snapped
  FloatL depth[3];                        // after division
  FloatL clip[3][4];                      // x, y, depth and w before it, for lanes that must be clipped
  FloatL depth_x, depth_y;                // growth of the depth by a part of a texel
  IntL first_x, first_y, last_x, last_y;  // texels whose centres lie within the bounds and the map
  IntL clipped, culled;
} MapTriangle;

static inline IntL min_int(IntL a, IntL b) { return a < b ? a : b; }
static inline IntL max_int(IntL a, IntL b) { return a > b ? a : b; }
static inline IntL snap_lanes(FloatL px)
{
  return LANE_CONVERT_INT(floor_lane(px * FLOATL(RASTER_SNAP) + FLOATL(0.5f)));
}

// Turns the triangles so that their areas are positive. Returns the areas in square parts of a texel; zero is exact.
static inline FloatL map_triangle_turn(MapTriangle *t)
{
  LANE_TYPE(long) right = LANE_TYPE(convert_long)(t->x[1] - t->x[0]) * LANE_TYPE(convert_long)(t->y[2] - t->y[0]);
  LANE_TYPE(long) left = LANE_TYPE(convert_long)(t->x[2] - t->x[0]) * LANE_TYPE(convert_long)(t->y[1] - t->y[0]);
  FloatL area = LANE_TYPE(convert_float)(right - left);
  IntL turned = area < FLOATL(0);
  IntL x = turned ? t->x[2] : t->x[1], y = turned ? t->y[2] : t->y[1];
  FloatL depth = turned ? t->depth[2] : t->depth[1];
  t->x[2] = turned ? t->x[1] : t->x[2];
  t->y[2] = turned ? t->y[1] : t->y[2];
  t->depth[2] = turned ? t->depth[1] : t->depth[2];
  t->x[1] = x;
  t->y[1] = y;
  t->depth[1] = depth;
  return fabs(area);
}

// Growth of the depth by a part of a texel along x and y, for a triangle of that area.
static inline void map_triangle_plane(MapTriangle *t, FloatL area)
{
  FloatL inverse = FLOATL(1) / area, rise1 = t->depth[1] - t->depth[0], rise2 = t->depth[2] - t->depth[0];
  t->depth_x =
      (rise1 * LANE_CONVERT_FLOAT(t->y[2] - t->y[0]) - rise2 * LANE_CONVERT_FLOAT(t->y[1] - t->y[0])) * inverse;
  t->depth_y =
      (rise2 * LANE_CONVERT_FLOAT(t->x[1] - t->x[0]) - rise1 * LANE_CONVERT_FLOAT(t->x[2] - t->x[0])) * inverse;
}

static inline float4 clip_corner(const MapTriangle *t, uint corner, uint lane)
{
  FloatL x = t->clip[corner][0], y = t->clip[corner][1], depth = t->clip[corner][2], w = t->clip[corner][3];
  return (float4)(LANE_FLOAT(x, lane), LANE_FLOAT(y, lane), LANE_FLOAT(depth, lane), LANE_FLOAT(w, lane));
}

// Bounds of one lane that must be clipped, in parts of a texel; empty where nothing of it is left.
static inline int4 clipped_bounds(const MapTriangle *t, uint lane, constant RasterView *view)
{
  ClipPolygon polygon = depth_clip(view, clip_corner(t, 0, lane), clip_corner(t, 1, lane), clip_corner(t, 2, lane));
  int4 bounds = (int4)(INT_MAX / 2, INT_MAX / 2, INT_MIN / 2, INT_MIN / 2);
  for (uint i = 0; i < polygon.count; i++) {
    ClipCorner corner = clip_project(view, polygon.vertex[i]);
    int2 at = (int2)(corner.x, corner.y);
    bounds = (int4)(min(bounds.x, at.x), min(bounds.y, at.y), max(bounds.z, at.x), max(bounds.w, at.y));
  }
  return bounds;
}

// Sets up LANES triangles, whose vertices are relative to the view's origin; lanes of `unused` come out culled, as do
// those that cover no texel's centre.
static inline MapTriangle map_triangle_setup(constant RasterView *view, const Vec3L a[3], IntL unused)
{
  MapTriangle t;
  FloatL zero = FLOATL(0), size = FLOATL((float)view->width), guard = FLOATL(RASTER_GUARD_PX),
         least_w = FLOATL(view->least_w);
  IntL left = INTL(-1), right = left, above = left, below = left, beyond = left, behind = left;
  t.clipped = INTL(0);
  for (uint i = 0; i < 3; i++) {
    FloatL x = row_dot(view->x, a[i]), y = row_dot(view->y, a[i]), d = row_dot(view->depth, a[i]),
           w = row_dot(view->w, a[i]);
    left = left & (x < zero);
    right = right & (x > size * w);
    above = above & (y < zero);
    below = below & (y > size * w);
    beyond = beyond & (d > w);
    behind = behind & (w < least_w);
    FloatL inverse = FLOATL(1) / w, px = x * inverse, py = y * inverse;
    IntL fits = (w >= least_w) & (fabs(px) < guard) & (fabs(py) < guard);
    t.clipped = t.clipped | !fits;
    t.x[i] = snap_lanes(fits ? px : zero);
    t.y[i] = snap_lanes(fits ? py : zero);
    t.depth[i] = view->parallel ? d : FLOATL(view->depth_far) + FLOATL(view->depth_by_w) * inverse;
    t.clip[i][0] = x;
    t.clip[i][1] = y;
    t.clip[i][2] = d;
    t.clip[i][3] = w;
  }
  FloatL area = map_triangle_turn(&t);
  map_triangle_plane(&t, area);
  t.culled = unused | left | right | above | below | beyond | behind | ((area == zero) & !t.clipped);
  IntL low_x = min_int(min_int(t.x[0], t.x[1]), t.x[2]), high_x = max_int(max_int(t.x[0], t.x[1]), t.x[2]);
  IntL low_y = min_int(min_int(t.y[0], t.y[1]), t.y[2]), high_y = max_int(max_int(t.y[0], t.y[1]), t.y[2]);
  for (uint bits = lane_bits(t.clipped & !t.culled); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    int4 bounds = clipped_bounds(&t, lane, view);
    LANE_INT(low_x, lane) = bounds.x;
    LANE_INT(low_y, lane) = bounds.y;
    LANE_INT(high_x, lane) = bounds.z;
    LANE_INT(high_y, lane) = bounds.w;
  }
  IntL half_texel = INTL(RASTER_SNAP / 2), last = INTL((int)view->width - 1);
  t.first_x = max_int((low_x + half_texel - INTL(1)) >> INTL(8), INTL(0));
  t.first_y = max_int((low_y + half_texel - INTL(1)) >> INTL(8), INTL(0));
  t.last_x = min_int((high_x - half_texel) >> INTL(8), last);
  t.last_y = min_int((high_y - half_texel) >> INTL(8), last);
  t.culled = t.culled | (t.first_x > t.last_x) | (t.first_y > t.last_y);
  return t;
}

// One triangle in a window of at most 64 x 64 texels: edge functions in units of 1/RASTER_SNAP^2, divided by
// RASTER_SNAP and rounded down, at the centre of the window's first texel; a centre is inside where none is negative.
typedef struct WindowTriangle {
  int edge[3], edge_x[3], edge_y[3];  // at the first centre; growth by a texel
  float depth, depth_x, depth_y;      // at corner 0; growth by a part of a texel
  int offset_x, offset_y;             // from corner 0 to the first centre, parts of a texel
  float least, greatest;  // the depth is held within (slivers), and not below 0 (casters before the near plane)
  int first_x, first_y, last_x, last_y;  // texels of the window whose centres lie within the bounds
} WindowTriangle;

// From snapped vertices of positive area, the depth at corner 0 and its growth by a part of a texel. `window`: its
// first texel, then its size. False where it holds no centre within the bounds.
static inline __attribute__((always_inline)) bool window_triangle(WindowTriangle *out, const int x[3], const int y[3],
                                                                  float depth, float depth_x, float depth_y,
                                                                  float least, float greatest, int4 window)
{
  int corner_x = window.x * RASTER_SNAP + RASTER_SNAP / 2, corner_y = window.y * RASTER_SNAP + RASTER_SNAP / 2;
  int low_x = min(min(x[0], x[1]), x[2]) - corner_x, high_x = max(max(x[0], x[1]), x[2]) - corner_x;
  int low_y = min(min(y[0], y[1]), y[2]) - corner_y, high_y = max(max(y[0], y[1]), y[2]) - corner_y;
  out->first_x = max((low_x + RASTER_SNAP - 1) / RASTER_SNAP, 0);
  out->first_y = max((low_y + RASTER_SNAP - 1) / RASTER_SNAP, 0);
  out->last_x = min(high_x >> 8, window.z - 1);
  out->last_y = min(high_y >> 8, window.w - 1);
  if (out->first_x > out->last_x || out->first_y > out->last_y) return false;
  for (int i = 0; i < 3; i++) {
    int j = i == 2 ? 0 : i + 1;
    int dx = x[j] - x[i], dy = y[j] - y[i];
    bool top_left = dy < 0 || (dy == 0 && dx > 0);
    long edge = (long)dx * (corner_y - y[i]) - (long)dy * (corner_x - x[i]) - (top_left ? 0 : 1);
    out->edge[i] =
        (int)clamp(edge >> 8, -(1l << 30), 1l << 30);  // beyond that no centre of the window changes the sign
    out->edge_x[i] = -dy;
    out->edge_y[i] = dx;
  }
  out->depth = depth;
  out->depth_x = depth_x;
  out->depth_y = depth_y;
  out->offset_x = corner_x - x[0];
  out->offset_y = corner_y - y[0];
  out->least = max(least, 0.0f);
  out->greatest = greatest;
  return true;
}

// Depth at the first centre of a block of 4 x 4 texels, at texel (x, y) of the window, and what a texel of the block
// adds. Every window that holds the block gives the same bits.
static inline float block_depth(const WindowTriangle *t, int x, int y)
{
  return t->depth + t->depth_y * (float)(t->offset_y + y * RASTER_SNAP) +
         t->depth_x * (float)(t->offset_x + x * RASTER_SNAP);
}

static inline FloatL texel_depth(const WindowTriangle *t, float block, IntL x, IntL y)
{
  FloatL depth = FLOATL(t->depth_x * RASTER_SNAP) * LANE_CONVERT_FLOAT(x) +
                 FLOATL(t->depth_y * RASTER_SNAP) * LANE_CONVERT_FLOAT(y);
  return max_lane(min_lane(depth + FLOATL(block), FLOATL(t->greatest)), FLOATL(t->least));
}

// Triangle `corner` (2..) of a clipped polygon's fan. False where it has no area or no centre in the window.
static inline bool window_fan_triangle(WindowTriangle *out, const ClipPolygon *polygon, uint corner,
                                       constant RasterView *view, int4 window)
{
  int x[3], y[3];
  float depth[3];
  for (uint k = 0; k < 3; k++) {
    ClipCorner at = clip_project(view, polygon->vertex[k == 0 ? 0 : corner - 2 + k]);
    x[k] = at.x;
    y[k] = at.y;
    depth[k] = at.depth;
  }
  long area = (long)(x[1] - x[0]) * (y[2] - y[0]) - (long)(x[2] - x[0]) * (y[1] - y[0]);
  if (area == 0) return false;
  int from = area > 0 ? 1 : 2, to = 3 - from;
  const int tx[3] = {x[0], x[from], x[to]}, ty[3] = {y[0], y[from], y[to]};
  float inverse = 1 / fabs((float)area), rise1 = depth[from] - depth[0], rise2 = depth[to] - depth[0];
  float depth_x = (rise1 * (float)(ty[2] - ty[0]) - rise2 * (float)(ty[1] - ty[0])) * inverse;
  float depth_y = (rise2 * (float)(tx[1] - tx[0]) - rise1 * (float)(tx[2] - tx[0])) * inverse;
  return window_triangle(out, tx, ty, depth[0], depth_x, depth_y, min(min(depth[0], depth[1]), depth[2]),
                         max(max(depth[0], depth[1]), depth[2]), window);
}

#ifdef HAS_MASK
// Lanes of `lanes` that alpha leaves of a triangle in slot `slot` of a block, at pixels (x, y) of the map.
static __attribute__((noinline)) IntL texels_pass(const AttributeSources *attributes, global const RasterBlock *block,
                                                  uint slot, constant RasterView *view, IntL lanes, FloatL x, FloatL y)
{
  const float origin[3] = {view->origin.x, view->origin.y, view->origin.z};
  float c[3][3];
  for (uint i = 0; i < 3; i++) {
    float a[3];
    for (uint axis = 0; axis < 3; axis++) a[axis] = block->vertex[i][axis][slot] - origin[axis];
    c[i][0] = row_dot_one(view->x, a);
    c[i][1] = row_dot_one(view->y, a);
    c[i][2] = row_dot_one(view->w, a);
  }
  FloatL weight[3];  // homogeneous edge functions: the corners' weights up to a factor
  for (uint i = 0; i < 3; i++) {
    uint j = i == 2 ? 0 : i + 1, k = i == 0 ? 2 : i - 1;
    weight[i] = FLOATL(c[j][1] * c[k][2] - c[k][1] * c[j][2]) * x + FLOATL(c[j][2] * c[k][0] - c[k][2] * c[j][0]) * y +
                FLOATL(c[j][0] * c[k][1] - c[k][0] * c[j][1]);
  }
  FloatL sum = weight[0] + weight[1] + weight[2];
  return alpha_passes(attributes, block->id[slot], lanes, weight[1] / sum, weight[2] / sum);
}
#endif
