// Does a ray meet a triangle, and where: the one function that decides it, for every kernel that asks.
//
// Watertight: rays that pass an edge or a vertex of a closed mesh hit one of its triangles. The edge function of an
// edge shared by two triangles is the same product difference up to its sign, and rounding keeps the order of the two
// products, so that it is never positive where the truth is negative; a zero counts as inside for both (no double
// precision needed), and the tie in distance goes to the nearer hit, then to the lower id. That needs FP_CONTRACT OFF.
//
// A hit counts only where t exceeds t_error, the rounding error of t itself: a ray that starts on a triangle's plane
// does not hit it, nor what lies in the same plane, and what is lost is nearer than rounding can tell. That error
// shrinks with the triangle's depth along the ray: slivers ahead of a ray are hit.
//
//   Fails where a triangle is so thin that its determinant underflows (about 1e-38): it is then not hit at all.
//   From  Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2013; Pharr, Jakob, Humphreys, "Physically
//         Based Rendering", 3rd edition, 2016, section 3.9.6 (the error bound, here with this test's own roundings).

#include "lib/lanes.cl"
#include "shared/bvh.h"

// A ray sheared so that it runs along the axis `kz`, which is the same for all lanes in use.
typedef struct ShearedRay {
  FloatL origin_x, origin_y, origin_z;  // permuted: the components kx, ky, kz
  FloatL shear_x, shear_y, shear_z;
} ShearedRay;

static inline FloatL component3(Vec3L v, uint axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

// Axis of the largest component of each direction.
static inline UintL dominant_axis(Vec3L direction)
{
  FloatL x = fabs(direction.x), y = fabs(direction.y), z = fabs(direction.z);
  return LANE_AS_UINT(((x >= y) & (x >= z)) ? INTL(0) : (y >= z) ? INTL(1) : INTL(2));
}

static inline ShearedRay shear_ray(Vec3L origin, Vec3L direction, uint kz)
{
  uint kx = kz == 2 ? 0 : kz + 1, ky = kz == 0 ? 2 : kz - 1;
  FloatL inverse = FLOATL(1) / component3(direction, kz);
  ShearedRay ray = {component3(origin, kx),
                    component3(origin, ky),
                    component3(origin, kz),
                    component3(direction, kx) * inverse,
                    component3(direction, ky) * inverse,
                    inverse};
  return ray;
}

typedef struct TriangleHit {
  IntL inside;     // the line meets the triangle
  FloatL t, u, v;  // distance, weights of vertices 1 and 2; undefined where not inside
  FloatL t_error;  // bound on the error of t from all roundings but that of the shear, which vanishes at t = 0
  IntL doubtful;   // t_error is above HIT_DOUBT of t, or not a number
  IntL close;      // inside, or but for rounding
  IntL determinant_positive;  // front face, if the direction's component kz is positive
} TriangleHit;

// A distance is in doubt where rounding may move it by more than this share of it.
#define HIT_DOUBT 1e-5f

#define ROUNDING 5.9604645e-8f  // 2^-24, half an ulp of 1

static inline FloatL max_magnitude(FloatL a, FloatL b, FloatL c)
{
  return max_lane(max_lane(fabs(a), fabs(b)), fabs(c));
}

// The sheared triangle and its edge functions: what tells whether the line meets it.
typedef struct TriangleEdges {
  FloatL ax, ay, az, bx, by, bz, cx, cy, cz;
  FloatL u, v, w, determinant;
  IntL inside;
} TriangleEdges;

// Vertices a, b, c as components (kx, ky, kz) in world space.
static inline TriangleEdges triangle_edges(const ShearedRay *ray, FloatL ax, FloatL ay, FloatL az, FloatL bx, FloatL by,
                                           FloatL bz, FloatL cx, FloatL cy, FloatL cz)
{
  TriangleEdges e;
  e.az = az - ray->origin_z;
  e.bz = bz - ray->origin_z;
  e.cz = cz - ray->origin_z;
  e.ax = ax - ray->origin_x - ray->shear_x * e.az;
  e.ay = ay - ray->origin_y - ray->shear_y * e.az;
  e.bx = bx - ray->origin_x - ray->shear_x * e.bz;
  e.by = by - ray->origin_y - ray->shear_y * e.bz;
  e.cx = cx - ray->origin_x - ray->shear_x * e.cz;
  e.cy = cy - ray->origin_y - ray->shear_y * e.cz;
  e.u = e.cx * e.by - e.cy * e.bx;
  e.v = e.ax * e.cy - e.ay * e.cx;
  e.w = e.bx * e.ay - e.by * e.ax;
  FloatL zero = FLOATL(0);
  e.determinant = e.u + e.v + e.w;
  FloatL least = min_lane(min_lane(e.u, e.v), e.w), greatest = max_lane(max_lane(e.u, e.v), e.w);
  e.inside = ((least >= zero) | (greatest <= zero)) & (e.determinant != zero);
  return e;
}

// The hit as far as hit_is_closest needs it.
static inline TriangleHit triangle_distance(const TriangleEdges *e, const ShearedRay *ray)
{
  TriangleHit hit;
  FloatL weighted = e->u * e->az + e->v * e->bz + e->w * e->cz;
  hit.inside = e->inside;
  hit.t = weighted * ray->shear_z / e->determinant;
  hit.determinant_positive = e->determinant > FLOATL(0);
  return hit;
}

// What rounding may do to an edge function, in ROUNDING; z: the most of az, bz, cz. Each sheared coordinate is off by
// 2 (|x| + |z|) roundings, each product of an edge function by one and both by their factors' errors.
static inline FloatL triangle_edge_terms(FloatL *z, const TriangleEdges *e)
{
  FloatL x = max_magnitude(e->ax, e->bx, e->cx), y = max_magnitude(e->ay, e->by, e->cy);
  *z = max_magnitude(e->az, e->bz, e->cz);
  return FLOATL(12) * x * y + FLOATL(4) * *z * (x + y);
}

// How far the corners' depths lie apart along the ray's axis.
static inline FloatL triangle_depth(const TriangleEdges *e)
{
  return max_lane(max_lane(e->az, e->bz), e->cz) - min_lane(min_lane(e->az, e->bz), e->cz);
}

static inline IntL triangle_close(const TriangleEdges *e, FloatL edge_terms)
{
  FloatL reach = FLOATL(ROUNDING) * edge_terms, least = min_lane(min_lane(e->u, e->v), e->w),
         greatest = max_lane(max_lane(e->u, e->v), e->w);
  return (least >= FLOATL(0) - reach) | (greatest <= reach);
}

// Is t_error, the bound on the error of t, above HIT_DOUBT of t? t is a mean of az, bz, cz weighted by edge functions
// over their sum, so that an error of these counts by the distance of az, bz, cz from it.
static inline IntL triangle_doubtful(const TriangleEdges *e)
{
  FloatL weighted = e->u * e->az + e->v * e->bz + e->w * e->cz;
  FloatL z, edge = triangle_edge_terms(&z, e);
  return !(FLOATL(6) * z * fabs(e->determinant) + FLOATL(3) * edge * triangle_depth(e) <=
           fabs(weighted) * FLOATL(HIT_DOUBT / ROUNDING));
}

// The rest of it.
static inline void triangle_complete(TriangleHit *hit, const TriangleEdges *e, const ShearedRay *ray)
{
  hit->u = e->v / e->determinant;
  hit->v = e->w / e->determinant;
  FloatL z, edge = triangle_edge_terms(&z, e);
  hit->close = triangle_close(e, edge);
  hit->t_error =
      FLOATL(ROUNDING) * fabs(ray->shear_z) *
      (FLOATL(6) * z + FLOATL(3) * edge * triangle_depth(e) / max_lane(fabs(e->determinant), FLOATL(1e-37f)));
  hit->doubtful = triangle_doubtful(e);
}

static inline TriangleHit triangle_hit(const TriangleEdges *e, const ShearedRay *ray)
{
  TriangleHit hit = triangle_distance(e, ray);
  triangle_complete(&hit, e, ray);
  return hit;
}

static inline TriangleHit triangle_intersect(const ShearedRay *ray, FloatL ax, FloatL ay, FloatL az, FloatL bx,
                                             FloatL by, FloatL bz, FloatL cx, FloatL cy, FloatL cz)
{
  TriangleEdges edges = triangle_edges(ray, ax, ay, az, bx, by, bz, cx, cy, cz);
  return triangle_hit(&edges, ray);
}
