// Resolve: sums of samples -> exposure, tone curve, sRGB.
//
//   in    sums     [pixel_count], linear radiance and coverage, over all samples
//   out   picture  [pixel_count], RGBA: linear and premultiplied, or display-encoded in [0, 1] with straight alpha
//
//   Cost  32 bytes a pixel.
//   From  IEC 61966-2-1 (sRGB); Kahan, "Computing a Real Cube Root", 1991 (a root's first digits from its bits); Hable,
//         "Uncharted 2: HDR Lighting", GDC 2010 (filmic); Khronos, "PBR Neutral Tone Mapper", 2024 (pbr-neutral).

#include "lib/lanes.cl"
#include "shared/resolve.h"

// c^(1 / 2.4) = (c^(1 / 12))^5 within 1e-6 of itself, for c in [0.003, 1]: pow() takes ten times as long on a CPU. A
// third of the exponent's bits is within 4 % of the cube root, and a step of Halley's leaves a third of that, cubed.
static inline float4 root_2_4(float4 c)
{
  float4 root = as_float4(convert_int4(convert_float4(as_int4(c)) * (1.0f / 3)) + 0x2a510000);
  for (int i = 0; i < 2; i++) {
    float4 cube = root * root * root;
    root *= (cube + 2 * c) / (2 * cube + c);
  }
  float4 twelfth = sqrt(sqrt(root));
  float4 fourth = twelfth * twelfth * twelfth * twelfth;
  return fourth * twelfth;
}

static inline float3 srgb_encode(float3 c)
{
  float4 wide = (float4)(c, 0);
  return select(1.055f * root_2_4(max(wide, 0.0031308f)) - 0.055f, 12.92f * wide, wide <= 0.0031308f).xyz;
}

static inline float filmic_curve(float x)
{
  return (x * (0.15f * x + 0.05f) + 0.004f) / (x * (0.15f * x + 0.5f) + 0.06f) - 0.02f / 0.3f;
}

static inline float3 tone_neutral(float3 color)
{
  const float start = 0.8f - 0.04f, desaturation = 0.15f;
  float low = min(color.x, min(color.y, color.z));
  float offset = low < 0.08f ? low - 6.25f * low * low : 0.04f;
  color -= offset;
  float peak = max(color.x, max(color.y, color.z));
  if (peak < start) return color;
  float d = 1 - start;
  float compressed = 1 - d * d / (peak + d - start);
  color *= compressed / peak;
  float g = 1 - 1 / (desaturation * (peak - compressed) + 1);
  return mix(color, (float3)(compressed), g);
}

static inline float3 tone_apply(float3 color, uint tone)
{
  if (tone == TONE_CURVE_FILMIC) {
    float white = 1 / filmic_curve(11.2f);
    color = (float3)(filmic_curve(2 * color.x), filmic_curve(2 * color.y), filmic_curve(2 * color.z)) * white;
  }
  if (tone == TONE_CURVE_PBR_NEUTRAL) color = tone_neutral(color);
  return clamp(color, 0.0f, 1.0f);
}

kernel void resolve(constant ResolveInfo *info, global const float4 *sums, global float4 *picture)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, info->pixel_count);
  for (uint i = begin; i < end; i++) {
    float3 color = sums[i].xyz * info->scale;
    float coverage = clamp(sums[i].w * info->coverage_scale, 0.0f, 1.0f);
    if (info->display) {
      bool straight = !info->opaque || info->has_background;
      color = tone_apply(straight && coverage > 0 ? color / coverage : color, info->tone);
      if (info->has_background) color *= coverage;
    }
    if (info->has_background)
      color += (float3)(info->background.x, info->background.y, info->background.z) * (1 - coverage);
    if (info->display) color = srgb_encode(color);
    picture[i] = (float4)(color, info->opaque ? 1 : coverage);
  }
}
