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
  IntL doubtful;   // t_error is above HIT_DOUBT of t
  IntL determinant_positive;  // front face, if the direction's component kz is positive
} TriangleHit;

// A distance is in doubt where rounding may move it by more than this share of it.
#define HIT_DOUBT 1e-5f

#define ROUNDING 5.9604645e-8f  // 2^-24, half an ulp of 1

static inline FloatL max_magnitude(FloatL a, FloatL b, FloatL c)
{
  return max_lane(max_lane(fabs(a), fabs(b)), fabs(c));
}

// Vertices a, b, c as components (kx, ky, kz) in world space.
static inline TriangleHit triangle_intersect(const ShearedRay *ray, FloatL ax, FloatL ay, FloatL az, FloatL bx,
                                             FloatL by, FloatL bz, FloatL cx, FloatL cy, FloatL cz)
{
  TriangleHit hit;
  az -= ray->origin_z;
  bz -= ray->origin_z;
  cz -= ray->origin_z;
  ax = ax - ray->origin_x - ray->shear_x * az;
  ay = ay - ray->origin_y - ray->shear_y * az;
  bx = bx - ray->origin_x - ray->shear_x * bz;
  by = by - ray->origin_y - ray->shear_y * bz;
  cx = cx - ray->origin_x - ray->shear_x * cz;
  cy = cy - ray->origin_y - ray->shear_y * cz;
  FloatL u = cx * by - cy * bx;
  FloatL v = ax * cy - ay * cx;
  FloatL w = bx * ay - by * ax;
  FloatL zero = FLOATL(0);
  FloatL determinant = u + v + w;
  hit.inside =
      (((u >= zero) & (v >= zero) & (w >= zero)) | ((u <= zero) & (v <= zero) & (w <= zero))) & (determinant != zero);
  FloatL weighted = u * az + v * bz + w * cz;
  hit.t = weighted * ray->shear_z / determinant;
  hit.u = v / determinant;
  hit.v = w / determinant;
  hit.determinant_positive = determinant > zero;

  // Each sheared coordinate is off by 2 (|x| + |z|) roundings, each product of an edge function by one and both by
  // their factors' errors; t is a mean of az, bz, cz weighted by edge functions over their sum, so that an error of
  // these counts by the distance of az, bz, cz from it.
  FloatL x = max_magnitude(ax, bx, cx), y = max_magnitude(ay, by, cy), z = max_magnitude(az, bz, cz);
  FloatL edge = FLOATL(12) * x * y + FLOATL(4) * z * (x + y);
  FloatL depth = max_lane(max_lane(az, bz), cz) - min_lane(min_lane(az, bz), cz);
  hit.t_error = FLOATL(ROUNDING) * fabs(ray->shear_z) *
                (FLOATL(6) * z + FLOATL(3) * edge * depth / max_lane(fabs(determinant), FLOATL(1e-37f)));
  hit.doubtful =
      FLOATL(6) * z * fabs(determinant) + FLOATL(3) * edge * depth > fabs(weighted) * FLOATL(HIT_DOUBT / ROUNDING);
  return hit;
}
