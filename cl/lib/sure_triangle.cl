// A triangle of a conservative raster of a light's maps: where it may touch texels, and how close to the light it is
// there (shared/shadow.h). What a map knows of it is settled here, for both ways of drawing it.
//
//   From  Akenine-Moller, Aila, "Conservative and Tiled Rasterization Using a Modified Triangle Setup", 2005.

#include "lib/depth_clip.cl"
#include "lib/shadowless.cl"
#include "lib/sure_tiles.cl"
#include "lib/view.cl"
#include "shared/bvh.h"
#include "shared/raster.h"
#include "shared/shadow.h"

#define SURE_ROUNDING 9.5367432e-7f  // 2^-20: 16 roundings of the terms of an edge's coefficients

typedef struct ListTriangle {
  Vec3L clip[3];                           // x, y, w before division
  FloatL edge_x[3], edge_y[3], edge_0[3];  // >= 0 where texel (x, y) may be touched
  FloatL near_x, near_y, near_0;           // closeness over texel (x, y) is at most near_0 + ..
  FloatL across;                           // over a texel closeness is less by this at most
  FloatL near_most, near_least;            // that of the vertices
  FloatL slack;                            // of the edges: what rounding may do
  IntL culled, whole;                      // whole: no edge is to be trusted
  IntL hides;                              // rays that end behind it meet it, whatever the rounding
  FloatL determinant;                      // its sign is that of the area on the map
  FloatL low_x, low_y, high_x, high_y;     // where it is, not clipped
  IntL crosses;                            // the eye plane: the bounds are not
} ListTriangle;

static inline FloatL positive(FloatL x) { return max_lane(x, FLOATL(0)); }

static inline FloatL dot_row(Vec3L a, Float3 b) { return a.x * FLOATL(b.x) + a.y * FLOATL(b.y) + a.z * FLOATL(b.z); }

static inline float sum_of(Float3 v) { return fabs(v.x) + fabs(v.y) + fabs(v.z); }

// Closeness is 1 / w, or in parallel projection -depth: what is larger is nearer, and it is linear on the map. Of a
// triangle that is seen at an angle `inexact` is what rounding may do to that: its plane passes through the light but
// for a difference of large terms. `size_of` is what 1 / scale would be if it faced the light.
static inline void list_nearness(ListTriangle *t, constant ShadowView *view, const Vec3L a[3], Vec3L normal,
                                 FloatL facing, FloatL size_of)
{
  constant RasterView *raster = &view->raster;
  FloatL scale, one = FLOATL(1);
  FloatL closeness[3];
  if (raster->parallel) {
    scale = one / dot_row(normal, view->axis);
    t->near_0 = (dot_row(normal, view->sight_0) - facing) * scale;
    for (uint i = 0; i < 3; i++) closeness[i] = FLOATL(0) - row_dot(raster->depth, a[i]);
  } else {
    scale = one / facing;
    t->near_0 = dot_row(normal, view->sight_0) * scale;
    for (uint i = 0; i < 3; i++) closeness[i] = one / t->clip[i].z;
  }
  t->near_x = dot_row(normal, view->sight_x) * scale;
  t->near_y = dot_row(normal, view->sight_y) * scale;
  t->near_most = t->crosses ? FLOATL(INFINITY) : max3_lane(closeness[0], closeness[1], closeness[2]);
  t->near_least = t->crosses ? FLOATL(-INFINITY) : min3_lane(closeness[0], closeness[1], closeness[2]);
  FloatL extent = FLOATL((float)raster->width), length = sqrt(dot3(normal, normal));
  FloatL largest = fabs(t->near_0) + extent * (fabs(t->near_x) + fabs(t->near_y));
  largest = raster->parallel ? one : t->crosses ? largest : t->near_most;
  FloatL terms = FLOATL(sum_of(view->sight_0)) + extent * FLOATL(sum_of(view->sight_x) + sum_of(view->sight_y));
  if (raster->parallel) terms += fabs(a[0].x) + fabs(a[0].y) + fabs(a[0].z);
  FloatL inexact = FLOATL(SURE_ROUNDING) * fabs(scale) * (length * terms + size_of * largest);
  FloatL padding = FLOATL(SURE_PADDING) * (fabs(t->near_x) + fabs(t->near_y));
  t->near_0 += positive(t->near_x) + positive(t->near_y) + padding + inexact;
  t->across = (fabs(t->near_x) + fabs(t->near_y)) * FLOATL(1 + 2 * SURE_PADDING) + FLOATL(2) * inexact;
  // Edge on, the plane's depth is not to be had.
  IntL sound = (fabs(t->near_x) < FLOATL(1e6f)) & (fabs(t->near_y) < FLOATL(1e6f)) & (fabs(t->near_0) < FLOATL(1e9f));
  t->near_x = sound ? t->near_x : FLOATL(0);
  t->near_y = sound ? t->near_y : FLOATL(0);
  t->near_0 = sound ? t->near_0 : FLOATL(INFINITY);
  t->across = sound ? t->across : FLOATL(INFINITY);
}

// Rays drop hits near their ends, by 3 times the error of a hit's distance at the light's (lib/hit.cl). That is a few
// roundings of (ray + triangle) x triangle^2 / (twice area x the plane's distance from the light) for lengths of a ray
// and of the triangle's longest edge: a triangle hides nothing for sure where this is too near 1, and at a ray's start,
// where the ray's length is not among the terms, it hides what is that share beyond it.
static inline void list_ends(ListTriangle *t, constant RasterView *raster, const Vec3L a[3], FloatL along)
{
  Vec3L ab = sub3(a[1], a[0]), bc = sub3(a[2], a[1]), ca = sub3(a[0], a[2]);
  FloatL squared = max3_lane(dot3(ab, ab), dot3(bc, bc), dot3(ca, ca)), longest = sqrt(squared);
  FloatL inverse = squared / fabs(along), touch = FLOATL(20 * SURE_ROUNDING) * longest * inverse;
  FloatL ray = FLOATL(raster->parallel ? 0 : raster->depth_by_w / (1 - raster->depth_far));
  FloatL beside = FLOATL(12 * SURE_ROUNDING) * (ray + FLOATL(4) * longest) * inverse;
  t->hides = raster->parallel ? INTL(-1) : beside < FLOATL(1);
  if (!raster->parallel) touch *= t->near_most;
  t->across += touch;
  t->near_least -= touch;
}

// Edges by cross products of corners before division, which hold wherever these are, with what rounding does to terms
// that are as large as the map.
static inline void list_edges_large(ListTriangle *t, IntL large, FloatL extent)
{
  FloatL sums = FLOATL(0);
  for (uint i = 0; i < 3; i++) {
    Vec3L p = t->clip[(i + 1) % 3], q = t->clip[(i + 2) % 3];
    FloatL x = p.y * q.z - q.y * p.z, y = p.z * q.x - q.z * p.x, at = p.x * q.y - q.x * p.y;
    t->edge_x[i] = large ? x : t->edge_x[i];
    t->edge_y[i] = large ? y : t->edge_y[i];
    t->edge_0[i] = large ? at : t->edge_0[i];
    sums = max_lane(sums, extent * (fabs(p.y * q.z) + fabs(q.y * p.z) + fabs(p.z * q.x) + fabs(q.z * p.x)) +
                              fabs(p.x * q.y) + fabs(q.x * p.y));
  }
  FloatL determinant = t->clip[0].x * t->edge_x[0] + t->clip[0].y * t->edge_y[0] + t->clip[0].z * t->edge_0[0];
  t->determinant = large ? determinant : t->determinant;
  t->slack = large ? sums * FLOATL(SURE_ROUNDING) : t->slack;
}

// How far off, in texels, a corner may be on the map: 8 roundings of the terms of its place.
static inline FloatL corner_error(constant RasterView *view, const Vec3L a[3], const ListTriangle *t, FloatL extent)
{
  FloatL squared = max3_lane(dot3(a[0], a[0]), dot3(a[1], a[1]), dot3(a[2], a[2]));
  FloatL least_w = min3_lane(t->clip[0].z, t->clip[1].z, t->clip[2].z);
  FloatL by_m = FLOATL(view->norm_x + view->norm_y) + extent * FLOATL(view->parallel ? 0 : view->norm_w);
  FloatL fixed = FLOATL(fabs(view->x.w) + fabs(view->y.w)) + extent * FLOATL(view->parallel ? 0 : fabs(view->w.w));
  return FLOATL(SURE_ROUNDING / 2) * (sqrt(squared) * by_m + fixed) / least_w;
}

// Where texels are beyond its edges. An edge runs from one corner on the map to the other, so that little is lost to
// rounding however small the triangle is; points within its bounds, and a texel and a half beyond, count.
static inline void list_edges(ListTriangle *t, constant RasterView *view, const Vec3L a[3], FloatL extent)
{
  FloatL x[3], y[3], one = FLOATL(1);
  for (uint i = 0; i < 3; i++) {
    FloatL inverse = one / t->clip[i].z;
    x[i] = t->clip[i].x * inverse;
    y[i] = t->clip[i].y * inverse;
  }
  t->low_x = min3_lane(x[0], x[1], x[2]);
  t->low_y = min3_lane(y[0], y[1], y[2]);
  t->high_x = max3_lane(x[0], x[1], x[2]);
  t->high_y = max3_lane(y[0], y[1], y[2]);
  for (uint i = 0; i < 3; i++) {
    uint p = (i + 1) % 3, q = (i + 2) % 3;
    t->edge_x[i] = y[p] - y[q];
    t->edge_y[i] = x[q] - x[p];
    t->edge_0[i] = FLOATL(0) - (t->edge_x[i] * x[p] + t->edge_y[i] * y[p]);
  }
  t->determinant = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
  FloatL reach = t->high_x - t->low_x + t->high_y - t->low_y + FLOATL(3);
  t->slack = reach * FLOATL(2) * (corner_error(view, a, t, extent) + FLOATL(SURE_ROUNDING) * extent);
  IntL large = t->crosses | !(reach < FLOATL(2) * extent);
  if (any_lane(large)) list_edges_large(t, large, extent);
  FloatL sign = t->determinant < FLOATL(0) ? FLOATL(-1) : one;
  for (uint i = 0; i < 3; i++) {
    t->edge_x[i] *= sign;
    t->edge_y[i] *= sign;
    t->edge_0[i] = t->edge_0[i] * sign + positive(t->edge_x[i]) + positive(t->edge_y[i]) +
                   FLOATL(SURE_PADDING) * (fabs(t->edge_x[i]) + fabs(t->edge_y[i])) + t->slack;
  }
}

static inline ListTriangle list_triangle(constant ShadowView *view, uint size, const Vec3L a[3], IntL solid,
                                         IntL unused)
{
  ListTriangle t;
  constant RasterView *raster = &view->raster;
  FloatL zero = FLOATL(0), extent = FLOATL((float)size), least_w = FLOATL(raster->least_w), one = FLOATL(1);
  IntL left = INTL(-1), right = left, above = left, below = left, beyond = left, behind = left;
  t.crosses = INTL(0);
  for (uint i = 0; i < 3; i++) {
    FloatL x = row_dot(raster->x, a[i]), y = row_dot(raster->y, a[i]), d = row_dot(raster->depth, a[i]);
    FloatL w = raster->parallel ? one : row_dot(raster->w, a[i]);
    FloatL pad = FLOATL(SURE_PADDING) * fabs(w);
    left = left & (x < zero - pad);
    right = right & (x > extent * w + pad);
    above = above & (y < zero - pad);
    below = below & (y > extent * w + pad);
    beyond = beyond & (d > w * FLOATL(1.001f));
    behind = behind & (w < least_w);
    t.crosses = t.crosses | (w < least_w);
    t.clip[i] = vec3l(x, y, w);
  }
  Vec3L normal = cross3(sub3(a[1], a[0]), sub3(a[2], a[0]));
  FloatL facing = dot3(normal, a[0]), along = facing;  // negative: the front is towards the light
  FloatL size_of = sqrt(dot3(normal, normal)) * (fabs(a[0].x) + fabs(a[0].y) + fabs(a[0].z));
  if (raster->parallel) {
    along = dot_row(normal, view->axis);
    size_of = sqrt(dot3(normal, normal)) *
              (fabs(FLOATL(view->axis.x)) + fabs(FLOATL(view->axis.y)) + fabs(FLOATL(view->axis.z)));
  }
  IntL faces = along < FLOATL(-1e-5f) * size_of;
  t.culled = unused | left | right | above | below | beyond | behind | (faces & solid);

  t.whole = fabs(along) <= FLOATL(1e-6f) * size_of;
  list_edges(&t, raster, a, extent);
  list_nearness(&t, view, a, normal, facing, size_of);
  list_ends(&t, raster, a, along);
  return t;
}

// Bounds of what of a triangle lies before the eye plane and within the map.
static inline float4 list_clipped_bounds(const ListTriangle *t, uint lane, constant RasterView *view)
{
  ClipPolygon polygon;
  float size = (float)view->width;
  for (uint i = 0; i < 3; i++)
    polygon.vertex[i] =
        (float4)(LANE_FLOAT(t->clip[i].x, lane), LANE_FLOAT(t->clip[i].y, lane), 0, LANE_FLOAT(t->clip[i].z, lane));
  polygon.count = 3;
  polygon_cut(&polygon, (float4)(0, 0, 0, 1), view->least_w);
  polygon_cut(&polygon, (float4)(1, 0, 0, 1), 0);
  polygon_cut(&polygon, (float4)(-1, 0, 0, size + 1), 0);
  polygon_cut(&polygon, (float4)(0, 1, 0, 1), 0);
  polygon_cut(&polygon, (float4)(0, -1, 0, size + 1), 0);
  float4 bounds = (float4)(INFINITY, INFINITY, -INFINITY, -INFINITY);
  for (uint i = 0; i < polygon.count; i++) {
    float2 at = polygon.vertex[i].xy / polygon.vertex[i].w;
    bounds = (float4)(min(bounds.x, at.x), min(bounds.y, at.y), max(bounds.z, at.x), max(bounds.w, at.y));
  }
  return bounds;
}

// Texels that the triangle may touch, each bound within the map: first x, first y, last x, last y.
static inline void list_bounds(IntL out[4], const ListTriangle *t, constant RasterView *view)
{
  FloatL low_x = t->low_x, low_y = t->low_y, high_x = t->high_x, high_y = t->high_y;
  for (uint bits = lane_bits(t->crosses & !t->culled); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    float4 bounds = list_clipped_bounds(t, lane, view);
    LANE_FLOAT(low_x, lane) = bounds.x;
    LANE_FLOAT(low_y, lane) = bounds.y;
    LANE_FLOAT(high_x, lane) = bounds.z;
    LANE_FLOAT(high_y, lane) = bounds.w;
  }
  FloatL zero = FLOATL(0), last = FLOATL((float)view->width - 1), pad = FLOATL(SURE_PADDING);
  out[0] = LANE_CONVERT_INT(min_lane(max_lane(floor_lane(low_x - pad), zero), last + FLOATL(1)));
  out[1] = LANE_CONVERT_INT(min_lane(max_lane(floor_lane(low_y - pad), zero), last + FLOATL(1)));
  out[2] = LANE_CONVERT_INT(max_lane(min_lane(floor_lane(high_x + pad), last), FLOATL(-1)));
  out[3] = LANE_CONVERT_INT(max_lane(min_lane(floor_lane(high_y + pad), last), FLOATL(-1)));
}

// Lanes whose triangle is marked.
static inline IntL lanes_marked(global const uint *marks, UintL id, IntL used)
{
  UintL bit = UINTL(0);
  for (uint bits = lane_bits(used); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits), number = LANE_UINT(id, lane);
    LANE_UINT(bit, lane) = marks[number / 32] >> number % 32 & 1;
  }
  return bit != UINTL(0);
}

static inline UintL packed_range(IntL first, IntL last)
{
  return LANE_AS_UINT(first) | LANE_AS_UINT(last) << UINTL(16);
}

// The words of a triangle's record, all but SURE_VIEW.
static inline void list_fields(UintL fields[SURE_VIEW], const ListTriangle *t, const IntL box[4], UintL number,
                               UintL flags, IntL marked)
{
  FloatL zero = FLOATL(0);
  const FloatL near[6] = {t->near_0, t->near_x, t->near_y, t->near_most, t->near_least, t->slack};
  for (uint i = 0; i < 3; i++) {
    fields[SURE_EDGE + 3 * i] = LANE_AS_UINT(t->whole ? zero : t->edge_x[i]);
    fields[SURE_EDGE + 3 * i + 1] = LANE_AS_UINT(t->whole ? zero : t->edge_y[i]);
    fields[SURE_EDGE + 3 * i + 2] = LANE_AS_UINT(t->whole ? zero : t->edge_0[i]);
  }
  for (uint i = 0; i < 6; i++) fields[SURE_NEAR + i] = LANE_AS_UINT(near[i]);
  fields[SURE_TEXELS] = packed_range(box[0], box[2]);
  fields[SURE_TEXELS + 1] = packed_range(box[1], box[3]);
  fields[SURE_NUMBER] = number | (marked ? UINTL(SHADOW_CLOSED) : UINTL(0));
  // One that is cut, or lets light through, hides nothing for sure; neither does one whose edges are not to be had.
  IntL hides = t->hides & !t->whole & ((flags & UINTL(TRIANGLE_MASKED | TRIANGLE_BLENDED)) == UINTL(0));
  fields[SURE_HIDES] = hides ? UINTL(1) : UINTL(0);
  fields[SURE_ACROSS] = LANE_AS_UINT(t->across);
}

// Sets up triangles from number `first` on: returns the lanes that known tiles of a map have texels of, `box`.
static inline IntL list_setup(ListTriangle *t, IntL box[4], IntL *marked, global const RasterBlock *blocks, uint first,
                              constant ShadowView *view, global const uint *marks, uint what,
                              global const ShadowTile *tiles, uint tile_columns)
{
  Vec3L corners[3], a[3];
  UintL id = LANE_LOAD(blocks[first / RASTER_STEP].id, first % RASTER_STEP);
  IntL unused = id == UINTL(RASTER_UNUSED);
  *marked = what == SURE_NONE_MARKED ? INTL(0) : lanes_marked(marks, id, !unused);
  if (what == SURE_MARKED_LEFT_OUT)
    unused = unused | *marked;
  else
    unused = unused | lanes_shadowless(LANE_LOAD(blocks[first / RASTER_STEP].flags, first % RASTER_STEP));
  triangles_load(corners, a, blocks, first, &view->raster);
  *t = list_triangle(view, view->raster.width, a, what == SURE_MARKED_SOLID ? *marked : INTL(0), unused);
  list_bounds(box, t, &view->raster);
  IntL seen = !t->culled & (box[0] <= box[2]) & (box[1] <= box[3]);
  for (uint bits = lane_bits(seen); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    int4 texels =
        (int4)(LANE_INT(box[0], lane), LANE_INT(box[1], lane), LANE_INT(box[2], lane), LANE_INT(box[3], lane));
    if (!tiles_want(tiles, tile_columns, texels / SHADOW_TILE_PX, LANE_FLOAT(t->near_most, lane)))
      LANE_INT(seen, lane) = 0;
  }
  return seen;
}
