// Resolve: sums of samples -> exposure, tone curve, sRGB.
//
//   in    sums     [pixel_count], linear radiance and coverage, over all samples
//   out   picture  [pixel_count], RGBA: linear and premultiplied, or display-encoded in [0, 1] with straight alpha
//
//   Cost  32 bytes a pixel, three powers where display-encoded.
//   From  IEC 61966-2-1 (sRGB); Hable, "Uncharted 2: HDR Lighting", GDC 2010 (filmic); Khronos, "PBR Neutral Tone
//         Mapper", 2024 (pbr-neutral).

#include "lib/lanes.cl"
#include "shared/resolve.h"

static inline float srgb_encode(float c)
{
  return c <= 0.0031308f ? 12.92f * c : 1.055f * powr(c, 1.0f / 2.4f) - 0.055f;
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
    if (info->display) color = (float3)(srgb_encode(color.x), srgb_encode(color.y), srgb_encode(color.z));
    picture[i] = (float4)(color, info->opaque ? 1 : coverage);
  }
}
