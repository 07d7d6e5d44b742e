// Vectors and matrices of the host, in double precision: transforms are composed here and rounded to float once, where
// an array for the device is written. Column vectors: `clip_from_world * position_world`.
#pragma once

#include <math.h>
#include <stdbool.h>

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

typedef struct Vec3 {
  double x, y, z;
} Vec3;

typedef struct Mat4 {
  double m[16];  // column-major: m[4 * column + row], as in glTF
} Mat4;

static inline Vec3 vec3(double x, double y, double z) { return (Vec3){x, y, z}; }
static inline Vec3 vec3_from_floats(const float v[3]) { return (Vec3){v[0], v[1], v[2]}; }
static inline Vec3 vec3_add(Vec3 a, Vec3 b) { return vec3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline Vec3 vec3_sub(Vec3 a, Vec3 b) { return vec3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline Vec3 vec3_mul(Vec3 a, Vec3 b) { return vec3(a.x * b.x, a.y * b.y, a.z * b.z); }
static inline Vec3 vec3_scale(Vec3 a, double s) { return vec3(a.x * s, a.y * s, a.z * s); }
static inline Vec3 vec3_neg(Vec3 a) { return vec3(-a.x, -a.y, -a.z); }
static inline Vec3 vec3_min(Vec3 a, Vec3 b) { return vec3(fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z)); }
static inline Vec3 vec3_max(Vec3 a, Vec3 b) { return vec3(fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z)); }
static inline double vec3_dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline double vec3_length(Vec3 a) { return sqrt(vec3_dot(a, a)); }
static inline Vec3 vec3_cross(Vec3 a, Vec3 b)
{
  return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

// Unit vector along `a`; `fallback` where `a` is zero or not finite.
static inline Vec3 vec3_unit_or(Vec3 a, Vec3 fallback)
{
  double length = vec3_length(a);
  return length > 0 && isfinite(length) ? vec3_scale(a, 1 / length) : fallback;
}

static inline bool vec3_is_finite(Vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }

// Corners of a box: bits of a corner's number tell on which side of x, y and z it is.
enum { BOX_CORNERS = 8 };
static inline void box_corners(Vec3 out[BOX_CORNERS], Vec3 low, Vec3 high)
{
  for (int i = 0; i < BOX_CORNERS; i++)
    out[i] = vec3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
}

Mat4 mat4_identity(void);
Mat4 mat4_mul(Mat4 a, Mat4 b);

// From glTF's translation, unit quaternion (x, y, z, w; normalised here) and scale.
Mat4 mat4_from_trs(Vec3 translation, const double rotation[4], Vec3 scale);

// `m` times the point (v, 1), without division by w; `m` times the direction (v, 0).
Vec3 mat4_point(const Mat4 *m, Vec3 v);
Vec3 mat4_direction(const Mat4 *m, Vec3 v);

// Determinant of the upper left 3 x 3, negative for a mirrored transform.
double mat4_determinant3(const Mat4 *m);

// Adjugate transpose of the upper left 3 x 3 applied to a normal: the inverse transpose times the determinant, which
// exists for singular matrices too. The caller normalises, and flips where the determinant is negative.
Vec3 mat4_normal(const Mat4 *m, Vec3 normal);
