// Rays against every triangle, in double precision and, where a sign hangs on the last bits, in 113 bits. A hit comes
// with how sure it is, so that a test can tell a tie from an error.
#pragma once

#include "support/oracle_scene.h"

// The segment origin + t * direction with t_min < t <= t_max; the direction need not be of unit length.
typedef struct OracleRay {
  Vec3 origin, direction;
  double t_min, t_max;
  uint32_t skip;   // id of a triangle left out, the one the ray starts on; ORACLE_MISS for none
  bool cull;       // single-sided triangles are open from behind (camera and reflected rays)
  double reach_m;  // margins count lengths below this one as this long: for an origin that a device has rounded
  // An arithmetic may refuse hits so near to t_min, and any hits so near to t_max, that it cannot tell on which side
  // they are. Those have a margin of 0 whose distance from there is no more than this share of the distance of the
  // triangle's vertices, and of its depth over the height at which it is seen.
  double start_margin, end_margin;
} OracleRay;

// Skips nothing, culls nothing, reach 0.
OracleRay oracle_ray(Vec3 origin, Vec3 direction, double t_min, double t_max);

// Margins above this are reported as this.
#define ORACLE_MARGIN_MAX 1e-3

typedef struct OracleHit {
  uint32_t triangle;  // ORACLE_MISS for none; of several at the same t the lowest id
  double t, u, v;     // u and v are the barycentric weights of corners 1 and 2
  double edge;        // the least of the three weights, 0 on an edge
  uint32_t next_triangle;
  double next_t, gap;  // the runner-up, and (next_t - t) / t; INFINITY where there is none
  // How much would have to change for another answer: the least of what separates the hit from its triangle's edges and
  // the ends of the segment, and every other triangle from being hit first; as a distance across (or along) the ray
  // relative to the distance of the triangle's vertices, so roughly an angle in radians.
  double margin;
  // An arithmetic with the relative error e is off by up to about e times these.
  double t_condition, u_condition, v_condition;
} OracleHit;

// Nearest hit. Edges and corners belong to the triangle. Cost: about 0.2 ms for 1e5 triangles.
void oracle_closest(OracleHit *out, const OracleScene *scene, const OracleRay *ray);

// Share of light that gets along the segment, either side of every triangle blocking: 0 or 1, or in between through
// BLEND. *margin (not NULL) is lowered to the verdict's margin, where that is less.
double oracle_lit(const OracleScene *scene, const OracleRay *ray, double *margin);

// The same for arrays of rays, on all cores. `margins` may be NULL, else it is overwritten.
void oracle_closest_all(OracleHit *out, const OracleScene *scene, const OracleRay *rays, size_t count);
void oracle_lit_all(double *out, double *margins, const OracleScene *scene, const OracleRay *rays, size_t count);

typedef enum OracleVerdict {
  ORACLE_SAME,  // the same triangle, and t, u and v as near as their conditions let them
  ORACLE_TIE,   // another answer that rounding excuses
  ORACLE_WRONG,
} OracleVerdict;

// Judges what an arithmetic of relative error `rounding` (a few times 2^-24 for float) says of a ray. `claim` needs
// triangle, t, u and v; `truth` is oracle_closest's answer.
OracleVerdict oracle_judge(const OracleScene *scene, const OracleRay *ray, const OracleHit *truth,
                           const OracleHit *claim, double rounding);
