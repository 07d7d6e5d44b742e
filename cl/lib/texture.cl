// Texture fetch from buffers: images are slow to filter on a CPU device. Lanes that hit the same triangle share its
// material and its corners' texture coordinates; texels are fetched a lane at a time.

#include "lib/lanes.cl"
#include "shared/scene.h"

typedef struct Color4L {
  Vec3L rgb;
  FloatL a;
} Color4L;

// Texel coordinate under a wrap mode, for i in [-1, 2 size].
static inline int wrap_texel(int i, int size, uint mode)
{
  if (mode == WRAP_MODE_CLAMP) return clamp(i, 0, size - 1);
  int period = mode == WRAP_MODE_MIRROR ? 2 * size : size;
  i += i < 0 ? period : 0;
  i -= i >= period ? period : 0;
  i -= i >= period ? period : 0;
  return i < size ? i : period - 1 - i;
}

// `linear_from_byte` decodes the three colour channels (256 entries); alpha is always linear.
static inline float4 texel_load(global const uchar4 *texels, constant float *linear_from_byte, uint at)
{
  uchar4 t = texels[at];
  return (float4)(linear_from_byte[t.x], linear_from_byte[t.y], linear_from_byte[t.z], t.w * (1.0f / 255.0f));
}

// Value at `uv` (v = 0 is the top row, texel centres at (i + 1/2) / size), level 0, bilinear or nearest.
static inline float4 texture_sample(const TextureInfo *info, global const uchar4 *texels,
                                    constant float *linear_from_byte, float2 uv)
{
  // Far coordinates would overflow the conversion to int; a period is taken off first, where there is one.
  if (info->wrap_u != WRAP_MODE_CLAMP) uv.x -= 2 * floor(uv.x * 0.5f);
  if (info->wrap_v != WRAP_MODE_CLAMP) uv.y -= 2 * floor(uv.y * 0.5f);
  int width = (int)info->width, height = (int)info->height;
  float2 at = clamp(uv, -1.0f, 2.0f) * (float2)(width, height);
  texels += info->first_texel;
  if (info->nearest) {
    int x = wrap_texel((int)floor(at.x), width, info->wrap_u), y = wrap_texel((int)floor(at.y), height, info->wrap_v);
    return texel_load(texels, linear_from_byte, (uint)(y * width + x));
  }
  at -= 0.5f;
  float2 base = floor(at), f = at - base;
  int x0 = wrap_texel((int)base.x, width, info->wrap_u), x1 = wrap_texel((int)base.x + 1, width, info->wrap_u);
  int y0 = wrap_texel((int)base.y, height, info->wrap_v), y1 = wrap_texel((int)base.y + 1, height, info->wrap_v);
  float4 top = mix(texel_load(texels, linear_from_byte, (uint)(y0 * width + x0)),
                   texel_load(texels, linear_from_byte, (uint)(y0 * width + x1)), f.x);
  float4 bottom = mix(texel_load(texels, linear_from_byte, (uint)(y1 * width + x0)),
                      texel_load(texels, linear_from_byte, (uint)(y1 * width + x1)), f.x);
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

// Sets the lanes of `group`, which hit one triangle at barycentrics (u, v), to the value of a material's texture;
// `table` 0 decodes sRGB, 256 leaves values as they are.
static inline void texture_use_sample(Color4L *out, const AttributeSources *from, global const TextureUse *use,
                                      const TriangleCorners *corners, IntL group, FloatL u, FloatL v, uint table)
{
  float2 a = corner_uv(from, use->uv_set, corners->vertex[0]);
  float2 b = corner_uv(from, use->uv_set, corners->vertex[1]);
  float2 c = corner_uv(from, use->uv_set, corners->vertex[2]);
  FloatL w = FLOATL(1) - u - v;
  FloatL s = FLOATL(a.x) * w + FLOATL(b.x) * u + FLOATL(c.x) * v;
  FloatL t = FLOATL(a.y) * w + FLOATL(b.y) * u + FLOATL(c.y) * v;
  global const float *m = use->matrix;
  FloatL x = FLOATL(m[0]) * s + FLOATL(m[1]) * t + FLOATL(m[2]);
  FloatL y = FLOATL(m[3]) * s + FLOATL(m[4]) * t + FLOATL(m[5]);
  TextureInfo info = from->textures[use->texture];
  for (uint bits = lane_bits(group); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    float4 texel = texture_sample(&info, from->texels, from->linear_from_byte + table,
                                  (float2)(LANE_FLOAT(x, lane), LANE_FLOAT(y, lane)));
    LANE_FLOAT(out->rgb.x, lane) = texel.x;
    LANE_FLOAT(out->rgb.y, lane) = texel.y;
    LANE_FLOAT(out->rgb.z, lane) = texel.z;
    LANE_FLOAT(out->a, lane) = texel.w;
  }
}

// Base colour and alpha of the lanes of `group`, which hit one triangle: factor x texture x vertex colour.
static inline Color4L base_color_sample(const AttributeSources *from, const TriangleCorners *corners, IntL group,
                                        FloatL u, FloatL v)
{
  global const MaterialInfo *material = &from->materials[corners->material];
  FloatL one = FLOATL(1);
  Color4L color = {vec3l(one, one, one), one};
#ifdef HAS_TEXTURES
  if (material->base_color_use.texture != TEXTURE_NONE)
    texture_use_sample(&color, from, &material->base_color_use, corners, group, u, v, 0);
#endif
#ifdef HAS_VERTEX_COLORS
  float4 a = vload4(corners->vertex[0], (global const float *)from->colors);
  float4 b = vload4(corners->vertex[1], (global const float *)from->colors);
  float4 c = vload4(corners->vertex[2], (global const float *)from->colors);
  FloatL w = one - u - v;
  color.rgb.x *= FLOATL(a.x) * w + FLOATL(b.x) * u + FLOATL(c.x) * v;
  color.rgb.y *= FLOATL(a.y) * w + FLOATL(b.y) * u + FLOATL(c.y) * v;
  color.rgb.z *= FLOATL(a.z) * w + FLOATL(b.z) * u + FLOATL(c.z) * v;
  color.a *= FLOATL(a.w) * w + FLOATL(b.w) * u + FLOATL(c.w) * v;
#endif
  color.rgb = mul3(color.rgb, vec3l(FLOATL(material->base_color[0]), FLOATL(material->base_color[1]),
                                    FLOATL(material->base_color[2])));
  color.a *= FLOATL(material->base_color[3]);
  return color;
}
