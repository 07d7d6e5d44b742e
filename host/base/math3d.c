#include "base/math3d.h"

Mat4 mat4_identity(void) { return (Mat4){{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}; }

Mat4 mat4_mul(Mat4 a, Mat4 b)
{
  Mat4 product = {{0}};
  for (int column = 0; column < 4; column++)
    for (int row = 0; row < 4; row++)
      for (int k = 0; k < 4; k++) product.m[4 * column + row] += a.m[4 * k + row] * b.m[4 * column + k];
  return product;
}

Mat4 mat4_from_trs(Vec3 translation, const double rotation[4], Vec3 scale)
{
  double length = sqrt(rotation[0] * rotation[0] + rotation[1] * rotation[1] + rotation[2] * rotation[2] +
                       rotation[3] * rotation[3]);
  double s = length > 0 ? 1 / length : 0;
  double x = rotation[0] * s, y = rotation[1] * s, z = rotation[2] * s, w = length > 0 ? rotation[3] * s : 1;
  return (Mat4){{
      (1 - 2 * (y * y + z * z)) * scale.x,
      2 * (x * y + z * w) * scale.x,
      2 * (x * z - y * w) * scale.x,
      0,
      2 * (x * y - z * w) * scale.y,
      (1 - 2 * (x * x + z * z)) * scale.y,
      2 * (y * z + x * w) * scale.y,
      0,
      2 * (x * z + y * w) * scale.z,
      2 * (y * z - x * w) * scale.z,
      (1 - 2 * (x * x + y * y)) * scale.z,
      0,
      translation.x,
      translation.y,
      translation.z,
      1,
  }};
}

Vec3 mat4_direction(const Mat4 *m, Vec3 v)
{
  const double *a = m->m;
  return vec3(a[0] * v.x + a[4] * v.y + a[8] * v.z, a[1] * v.x + a[5] * v.y + a[9] * v.z,
              a[2] * v.x + a[6] * v.y + a[10] * v.z);
}

Vec3 mat4_point(const Mat4 *m, Vec3 v) { return vec3_add(mat4_direction(m, v), vec3(m->m[12], m->m[13], m->m[14])); }

static Vec3 mat4_column(const Mat4 *m, int column)
{
  return vec3(m->m[4 * column], m->m[4 * column + 1], m->m[4 * column + 2]);
}

double mat4_determinant3(const Mat4 *m)
{
  return vec3_dot(mat4_column(m, 0), vec3_cross(mat4_column(m, 1), mat4_column(m, 2)));
}

Vec3 mat4_normal(const Mat4 *m, Vec3 normal)
{
  Vec3 x = mat4_column(m, 0), y = mat4_column(m, 1), z = mat4_column(m, 2);
  Vec3 sum = vec3_scale(vec3_cross(y, z), normal.x);
  sum = vec3_add(sum, vec3_scale(vec3_cross(z, x), normal.y));
  return vec3_add(sum, vec3_scale(vec3_cross(x, y), normal.z));
}
