// The environment: radiance by direction, and light from it without visibility.

#include "lib/lanes.cl"
#include "shared/scene.h"

// Radiance from the unit direction of one lane. Equirectangular image: u runs from -X over -Z..., the centre is +X and
// +Z a quarter to its right; rotation about +Y.
static inline float3 environment_image(constant EnvironmentInfo *info, global const Float4 *pixels, float3 direction)
{
  float x = info->cos_rotation * direction.x - info->sin_rotation * direction.z;
  float z = info->sin_rotation * direction.x + info->cos_rotation * direction.z;
  float u = atan2(z, x) * 0.15915494f + 0.5f, v = acos(clamp(direction.y, -1.0f, 1.0f)) * 0.31830989f;
  float px = u * info->width - 0.5f, py = v * info->height - 0.5f;
  float bx = floor(px), by = floor(py);
  int w = (int)info->width, h = (int)info->height;
  int x0 = ((int)bx % w + w) % w, x1 = (x0 + 1) % w;
  int y0 = clamp((int)by, 0, h - 1), y1 = clamp((int)by + 1, 0, h - 1);
  global const float *texels = (global const float *)pixels;
  float4 top = mix(vload4(y0 * w + x0, texels), vload4(y0 * w + x1, texels), px - bx);
  float4 bottom = mix(vload4(y1 * w + x0, texels), vload4(y1 * w + x1, texels), px - bx);
  return mix(top, bottom, py - by).xyz * info->intensity;
}

// Radiance from unit directions.
static inline Vec3L environment_radiance(constant EnvironmentInfo *info, global const Float4 *pixels, Vec3L direction,
                                         IntL mask)
{
  if (info->kind == ENVIRONMENT_KIND_IMAGE) {
    Vec3L radiance = vec3l(FLOATL(0), FLOATL(0), FLOATL(0));
    for (uint bits = lane_bits(mask); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits);
      float3 one = environment_image(
          info, pixels,
          (float3)(LANE_FLOAT(direction.x, lane), LANE_FLOAT(direction.y, lane), LANE_FLOAT(direction.z, lane)));
      LANE_FLOAT(radiance.x, lane) = one.x;
      LANE_FLOAT(radiance.y, lane) = one.y;
      LANE_FLOAT(radiance.z, lane) = one.z;
    }
    return radiance;
  }
  IntL up = direction.y >= FLOATL(0);
  FloatL f = min_lane(fabs(direction.y), FLOATL(1));
  Vec3L pole = select3(up, vec3l(FLOATL(info->zenith.x), FLOATL(info->zenith.y), FLOATL(info->zenith.z)),
                       vec3l(FLOATL(info->ground.x), FLOATL(info->ground.y), FLOATL(info->ground.z)));
  Vec3L horizon = vec3l(FLOATL(info->horizon.x), FLOATL(info->horizon.y), FLOATL(info->horizon.z));
  return add3(horizon, scale3(sub3(pole, horizon), f));
}

// Sum of the harmonics at a unit direction, each band times its factor; never negative.
static inline FloatL harmonics_sum(constant Float3 *harmonics, uint channel, Vec3L d, FloatL band1, FloatL band2)
{
#define COEFFICIENT(i) FLOATL(((constant const float *)&harmonics[i])[channel])
  FloatL first = COEFFICIENT(0) * FLOATL(0.282095f);
  FloatL second = FLOATL(0.488603f) * (COEFFICIENT(1) * d.y + COEFFICIENT(2) * d.z + COEFFICIENT(3) * d.x);
  FloatL third =
      FLOATL(1.092548f) * (COEFFICIENT(4) * d.x * d.y + COEFFICIENT(5) * d.y * d.z + COEFFICIENT(7) * d.x * d.z) +
      FLOATL(0.315392f) * COEFFICIENT(6) * (FLOATL(3) * d.z * d.z - FLOATL(1)) +
      FLOATL(0.546274f) * COEFFICIENT(8) * (d.x * d.x - d.y * d.y);
#undef COEFFICIENT
  return max_lane(first + band1 * second + band2 * third, FLOATL(0));
}

// Irradiance / pi on a surface of normal n: the cosine lobe has band factors 1, 2/3, 1/4.
// From Ramamoorthi, Hanrahan, "An Efficient Representation for Irradiance Environment Maps", 2001.
static inline Vec3L environment_irradiance(constant EnvironmentInfo *info, Vec3L n)
{
  FloatL band1 = FLOATL(2.0f / 3.0f), band2 = FLOATL(0.25f);
  return vec3l(harmonics_sum(info->harmonics, 0, n, band1, band2), harmonics_sum(info->harmonics, 1, n, band1, band2),
               harmonics_sum(info->harmonics, 2, n, band1, band2));
}

// Radiance about the reflected direction d, blurred by a lobe of GGX alpha: a stand-in, from nine harmonics, for the
// sampled lobe. Band factors of a Gaussian lobe: exp(-l^2 alpha^2 / 2).
static inline Vec3L environment_glossy(constant EnvironmentInfo *info, Vec3L d, FloatL alpha)
{
  FloatL band1 = exp(FLOATL(-0.5f) * alpha * alpha), band2 = exp(FLOATL(-2.0f) * alpha * alpha);
  return vec3l(harmonics_sum(info->harmonics, 0, d, band1, band2), harmonics_sum(info->harmonics, 1, d, band1, band2),
               harmonics_sum(info->harmonics, 2, d, band1, band2));
}
