// Texture fetch from buffers: images are slow to filter on a CPU device. Scalar: one lane at a time, because
// neighbouring lanes may use different textures.

#include "lib/lanes.cl"
#include "shared/scene.h"

// Integer texel coordinate under a wrap mode.
static inline int wrap_texel(int i, int size, uint mode)
{
  if (mode == WRAP_MODE_CLAMP) return clamp(i, 0, size - 1);
  int period = mode == WRAP_MODE_MIRROR ? 2 * size : size;
  int folded = i % period;
  folded += folded < 0 ? period : 0;
  return folded < size ? folded : period - 1 - folded;
}


// `linear_from_byte` decodes the three colour channels (256 entries); alpha is always linear.
static inline float4 texel_load(const TextureInfo *info, global const uchar4 *texels, constant float *linear_from_byte, int x,
                                int y)
{
  x = wrap_texel(x, (int)info->width, info->wrap_u);
  y = wrap_texel(y, (int)info->height, info->wrap_v);
  uchar4 t = texels[info->first_texel + (uint)y * info->width + (uint)x];
  return (float4)(linear_from_byte[t.x], linear_from_byte[t.y], linear_from_byte[t.z], t.w * (1.0f / 255.0f));
}

// Value at `uv` (v = 0 is the top row, texel centres at (i + 1/2) / size), level 0, bilinear or nearest.
static inline float4 texture_sample(const TextureInfo *info, global const uchar4 *texels, constant float *linear_from_byte,
                                    float2 uv)
{
  // Far coordinates would overflow the conversion to int; a period is taken off first, where there is one.
  if (info->wrap_u != WRAP_MODE_CLAMP) uv.x -= 2 * floor(uv.x * 0.5f);
  if (info->wrap_v != WRAP_MODE_CLAMP) uv.y -= 2 * floor(uv.y * 0.5f);
  float2 at = clamp(uv, -4.0f, 4.0f) * (float2)(info->width, info->height);
  if (info->nearest) return texel_load(info, texels, linear_from_byte, (int)floor(at.x), (int)floor(at.y));
  at -= 0.5f;
  float2 base = floor(at), f = at - base;
  int x = (int)base.x, y = (int)base.y;
  float4 top = mix(texel_load(info, texels, linear_from_byte, x, y), texel_load(info, texels, linear_from_byte, x + 1, y), f.x);
  float4 bottom =
      mix(texel_load(info, texels, linear_from_byte, x, y + 1), texel_load(info, texels, linear_from_byte, x + 1, y + 1), f.x);
  return mix(top, bottom, f.y);
}

// What a triangle's textures and vertex colours are read from.
typedef struct AttributeSources {
  global const TriangleCorners *corners;
  global const Float2 *uvs;     // [uv_set][vertex_count]
  global const Float4 *colors;  // [vertex_count]
  uint vertex_count;
  global const MaterialInfo *materials;
  global const TextureInfo *textures;
  global const uchar4 *texels;
  constant float *linear_from_byte;  // [0, 256): sRGB; [256, 512): linear
} AttributeSources;

static inline float2 corner_uv(const AttributeSources *from, uint set, uint vertex)
{
  Float2 uv = from->uvs[set * from->vertex_count + vertex];
  return (float2)(uv.x, uv.y);
}

// A material's texture at barycentrics (u, v) of a triangle; `table` 0 decodes sRGB, 256 leaves values as they are.
static inline float4 texture_use_sample(const AttributeSources *from, global const TextureUse *use,
                                        const TriangleCorners *corners, float u, float v, uint table)
{
  float2 a = corner_uv(from, use->uv_set, corners->vertex[0]);
  float2 b = corner_uv(from, use->uv_set, corners->vertex[1]);
  float2 c = corner_uv(from, use->uv_set, corners->vertex[2]);
  float2 uv = a * (1 - u - v) + b * u + c * v;
  global const float *m = use->matrix;
  uv = (float2)(m[0] * uv.x + m[1] * uv.y + m[2], m[3] * uv.x + m[4] * uv.y + m[5]);
  TextureInfo info = from->textures[use->texture];
  return texture_sample(&info, from->texels, from->linear_from_byte + table, uv);
}

// Base colour and alpha of triangle corners at (u, v): factor x texture x vertex colour.
static inline float4 base_color_sample(const AttributeSources *from, const TriangleCorners *corners, float u, float v)
{
  global const MaterialInfo *material = &from->materials[corners->material];
  float4 color = vload4(0, material->base_color);
#ifdef HAS_TEXTURES
  if (material->base_color_use.texture != TEXTURE_NONE)
    color *= texture_use_sample(from, &material->base_color_use, corners, u, v, 0);
#endif
#ifdef HAS_VERTEX_COLORS
  float4 a = vload4(corners->vertex[0], (global const float *)from->colors);
  float4 b = vload4(corners->vertex[1], (global const float *)from->colors);
  float4 c = vload4(corners->vertex[2], (global const float *)from->colors);
  color *= a * (1 - u - v) + b * u + c * v;
#endif
  return color;
}
