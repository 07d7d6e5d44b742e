// Which pixels may a triangle be seen in? Conservative bounds and edges for camera visibility: what they leave out is
// out of the reach of triangle_intersect's roundings; what they let in, triangle_intersect decides.
//
// A ray's meeting with a triangle is exact for vertices moved by at most 12 roundings of their distance across the ray
// (lib/triangle.cl), so that a sample which hits is within the view's error_px of the projected triangle, in x and in
// y. Everything here is widened by that.
//
//   From  Akenine-Moller, Aila, "Conservative and Tiled Rasterization Using a Modified Triangle Setup", 2005; Olano,
//         Greer, "Triangle Scan Conversion using 2D Homogeneous Coordinates", 1997 (triangles that cross the eye
//         plane).

#include "lib/view.cl"
#include "shared/bvh.h"

#define GUARD_PX 32768.0f  // projected coordinates within it keep their digits

typedef struct VisibleTriangle {
  FloatL edge_x[3], edge_y[3],
      edge_0[3];  // >= 0 (or NaN) for a block of 4 x 4 samples that may be met, by its first sample
  FloatL low_x, low_y, high_x, high_y;  // bounds of samples that may be met, in pixels
  FloatL near, far;                     // no hit is nearer; about as far as one can be
  IntL culled;
} VisibleTriangle;

// From the edge function x px + y py + constant of a point to that of a block of 4 x 4 samples, widened by `margin`.
static inline float edge_of_block(float x, float y, float constant_0, float margin)
{
  return constant_0 + (fabs(x) + fabs(y)) * (margin + 1.5f) + 1.5f * (x + y);
}

// Is every corner beyond the same side of the picture, by more than rounding takes (bounds_meet)? `far_off` is the
// length of the longest.
static inline bool corners_beside(constant RasterView *view, const float a[3][3], float far_off)
{
  const Float4 sides[4] = {view->x, row_sum(row_scaled(view->x, -1), (float)view->width, view->w), view->y,
                           row_sum(row_scaled(view->y, -1), (float)view->height, view->w)};
  for (int i = 0; i < 4; i++) {
    Float4 p = sides[i];
    float size = fabs(p.x) + fabs(p.y) + fabs(p.z);
    float slack = 4 * RASTER_ROUNDING * (2 * size * far_off + fabs(p.w)) + size * view->error_m;
    bool beside = true;
    for (int k = 0; k < 3; k++) beside = beside && row_dot_one(p, a[k]) < -slack;
    if (beside) return true;
  }
  return false;
}

// One lane that crosses the eye plane, comes close to it or reaches far out of the picture: bounds of its part beyond
// half the near distance, and homogeneous edges.
static inline void visible_hard(VisibleTriangle *out, uint lane, constant RasterView *view, const float a[3][3],
                                uint flags)
{
  float x[3], y[3], w[3], length[3], far_off = 0;
  for (int i = 0; i < 3; i++) {
    x[i] = row_dot_one(view->x, a[i]);
    y[i] = row_dot_one(view->y, a[i]);
    w[i] = row_dot_one(view->w, a[i]);
    length[i] = sqrt(a[i][0] * a[i][0] + a[i][1] * a[i][1] + a[i][2] * a[i][2]);
    far_off = length[i] > far_off ? length[i] : far_off;
  }
  if (corners_beside(view, a, far_off)) {
    LANE_INT(out->culled, lane) = -1;
    return;
  }
  float cut = view->parallel ? 1 : 0.5f * view->near;
  float low_x = INFINITY, low_y = INFINITY, high_x = -INFINITY, high_y = -INFINITY;
  for (int i = 0; i < 3; i++) {
    int j = i == 2 ? 0 : i + 1;
    float share = (cut - w[i]) / (w[j] - w[i]);
    float px[2] = {x[i] / w[i], (x[i] + share * (x[j] - x[i])) / cut};
    float py[2] = {y[i] / w[i], (y[i] + share * (y[j] - y[i])) / cut};
    bool there[2] = {w[i] >= cut, (w[i] < cut) != (w[j] < cut)};
    for (int k = 0; k < 2; k++) {
      if (!there[k]) continue;
      low_x = px[k] > low_x ? low_x : px[k];
      low_y = py[k] > low_y ? low_y : py[k];
      high_x = px[k] < high_x ? high_x : px[k];
      high_y = py[k] < high_y ? high_y : py[k];
    }
  }
  float ratio = far_off / cut, error_px = view->error_px;
  float margin = view->parallel ? error_px + view->error_px_m * far_off : error_px * ratio * ratio;
  margin += 2e-6f * (fabs(low_x) + fabs(low_y) + fabs(high_x) + fabs(high_y));
  bool bounded = view->parallel || 4 * RASTER_ROUNDING * far_off <= 0.5f * view->near;
  bool sound = bounded && margin < 1e6f;  // false for NaN
  LANE_FLOAT(out->low_x, lane) = sound ? low_x - margin : -1;
  LANE_FLOAT(out->low_y, lane) = sound ? low_y - margin : -1;
  LANE_FLOAT(out->high_x, lane) = sound ? high_x + margin : (float)view->width + 1;
  LANE_FLOAT(out->high_y, lane) = sound ? high_y + margin : (float)view->height + 1;

  float reach = view->norm_y * view->norm_w * (float)view->width + view->norm_x * view->norm_w * (float)view->height +
                view->norm_x * view->norm_y;
  float determinant = 0, edge[3][3];
  for (int i = 0; i < 3; i++) {
    int j = i == 2 ? 0 : i + 1;
    edge[i][0] = y[i] * w[j] - y[j] * w[i];
    edge[i][1] = w[i] * x[j] - w[j] * x[i];
    edge[i][2] = x[i] * y[j] - x[j] * y[i];
  }
  determinant = edge[0][0] * x[2] + edge[0][1] * y[2] + edge[0][2] * w[2];
  float doubt = 6 * RASTER_ROUNDING * view->norm_x * view->norm_y * view->norm_w * length[0] * length[1] * length[2];
  bool clear = !view->parallel && fabs(determinant) > doubt;
  float sign = determinant > 0 ? 1 : -1;
  for (int i = 0; i < 3; i++) {
    int j = i == 2 ? 0 : i + 1;
    float error = 2 * RASTER_ROUNDING * length[i] * length[j] * reach;
    float ex = sign * edge[i][0], ey = sign * edge[i][1];
    LANE_FLOAT(out->edge_x[i], lane) = clear ? ex : 0;
    LANE_FLOAT(out->edge_y[i], lane) = clear ? ey : 0;
    LANE_FLOAT(out->edge_0[i], lane) = clear ? edge_of_block(ex, ey, sign * edge[i][2] + error, error_px) : INFINITY;
  }
  if (clear && (determinant > 0) != (view->mirrored != 0) && flags & TRIANGLE_SINGLE_SIDED)
    LANE_INT(out->culled, lane) = -1;
}

// Adds what one axis of a triangle's box does to the least and the greatest depth of the box. It is the box that bounds
// a hit: where a triangle's own distance is in doubt, hit_hold (lib/hit.cl) moves it to where the ray enters the box.
static inline void box_depth(FloatL *least, FloatL *greatest, float row, FloatL a, FloatL b, FloatL c)
{
  FloatL low = FLOATL(row) * min3_lane(a, b, c), high = FLOATL(row) * max3_lane(a, b, c);
  *least += row > 0 ? low : high;
  *greatest += row > 0 ? high : low;
}

// Sets up LANES triangles, whose vertices are relative to the view's origin; lanes of `unused` come out culled.
static inline VisibleTriangle visible_setup(constant RasterView *view, const Vec3L a[3], UintL flags, IntL unused)
{
  VisibleTriangle out;
  FloatL zero = FLOATL(0), one = FLOATL(1), px[3], py[3], w[3], square[3], ratio[3];
  for (int i = 0; i < 3; i++) {
    w[i] = row_dot(view->w, a[i]);
    square[i] = dot3(a[i], a[i]);
    FloatL inverse = one / w[i];
    px[i] = row_dot(view->x, a[i]) * inverse;
    py[i] = row_dot(view->y, a[i]) * inverse;
    ratio[i] = square[i] * inverse * inverse;
  }
  FloatL far_off = sqrt(max3_lane(square[0], square[1], square[2]));
  FloatL slack = FLOATL(4 * RASTER_ROUNDING) * far_off + FLOATL(view->error_m);  // above HIT_DOUBT
  FloatL least = FLOATL(view->depth.w), greatest = least;
  box_depth(&least, &greatest, view->depth.x, a[0].x, a[1].x, a[2].x);
  box_depth(&least, &greatest, view->depth.y, a[0].y, a[1].y, a[2].y);
  box_depth(&least, &greatest, view->depth.z, a[0].z, a[1].z, a[2].z);
  out.near = max_lane(least - slack, zero);
  out.far = max_lane(greatest, zero);
  out.culled = unused | (greatest <= FLOATL(view->near) - slack) | (least > FLOATL(view->far) + slack);

  FloatL low_x = min3_lane(px[0], px[1], px[2]), high_x = max3_lane(px[0], px[1], px[2]);
  FloatL low_y = min3_lane(py[0], py[1], py[2]), high_y = max3_lane(py[0], py[1], py[2]);
  FloatL reach = max_lane(max_lane(high_x, zero - low_x), max_lane(high_y, zero - low_y));
  FloatL margin = view->parallel ? FLOATL(view->error_px) + FLOATL(view->error_px_m) * far_off
                                 : FLOATL(view->error_px) * max3_lane(ratio[0], ratio[1], ratio[2]);
  margin += FLOATL(1e-6f) * reach;  // of the edge functions below
  IntL easy = (min3_lane(w[0], w[1], w[2]) > zero) & (margin < one) & (reach < FLOATL(GUARD_PX));
  out.low_x = low_x - margin;
  out.low_y = low_y - margin;
  out.high_x = high_x + margin;
  out.high_y = high_y + margin;

  FloatL area = (px[1] - px[0]) * (py[2] - py[0]) - (px[2] - px[0]) * (py[1] - py[0]);
  IntL clear = fabs(area) > FLOATL(4) * margin * ((out.high_x - out.low_x) + (out.high_y - out.low_y));
  FloatL sign = area > zero ? one : FLOATL(-1);
  for (int i = 0; i < 3; i++) {
    int j = i == 2 ? 0 : i + 1;
    FloatL ex = sign * (py[i] - py[j]), ey = sign * (px[j] - px[i]);
    FloatL constant_0 = zero - (ex * px[i] + ey * py[i]);
    out.edge_x[i] = clear ? ex : zero;
    out.edge_y[i] = clear ? ey : zero;
    out.edge_0[i] = clear ? constant_0 + (fabs(ex) + fabs(ey)) * (margin + FLOATL(1.5f)) + FLOATL(1.5f) * (ex + ey)
                          : FLOATL(INFINITY);
  }
  IntL single = (flags & UINTL(TRIANGLE_SINGLE_SIDED)) != UINTL(0);
  IntL averted = view->mirrored ? area < zero : area > zero;
  out.culled = out.culled | (easy & clear & single & averted);
  for (uint bits = lane_bits(!out.culled & !easy); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    float corners[3][3];
    for (int i = 0; i < 3; i++) {
      corners[i][0] = LANE_FLOAT(a[i].x, lane);
      corners[i][1] = LANE_FLOAT(a[i].y, lane);
      corners[i][2] = LANE_FLOAT(a[i].z, lane);
    }
    visible_hard(&out, lane, view, corners, LANE_UINT(flags, lane));
  }
  return out;
}

// Lanes whose triangles are in one of `count` ranges of ids, [x, y).
static inline IntL triangles_hidden(UintL id, global const uint2 *hidden, uint count)
{
  IntL out = INTL(0);
  for (uint i = 0; i < count; i++) out = out | ((id >= UINTL(hidden[i].x)) & (id < UINTL(hidden[i].y)));
  return out;
}

// Lanes whose bounds hold a sample of the picture's rows [first_row, end_row).
static inline IntL visible_samples(const VisibleTriangle *triangle, constant RasterView *view, uint first_row,
                                   uint end_row, constant Float2 *offsets, uint sample_count)
{
  IntL on_screen = (triangle->high_x >= FLOATL(0)) & (triangle->low_x <= FLOATL((float)view->width)) &
                   (triangle->high_y >= FLOATL((float)first_row)) & (triangle->low_y <= FLOATL((float)end_row));
  if (sample_count > 16) return on_screen;
  IntL sampled = INTL(0);
  for (uint i = 0; i < sample_count; i++) {
    FloatL x = FLOATL(offsets[i].x), y = FLOATL(offsets[i].y);
    sampled = sampled | ((floor_lane(triangle->high_x - x) >= triangle->low_x - x) &
                         (floor_lane(triangle->high_y - y) >= triangle->low_y - y));
  }
  return on_screen & sampled;
}
