// Texture fetch from buffers: images are slow to filter on a CPU device. Lanes that hit the same triangle share its
// material and its corners' texture coordinates.

#include "lib/texel.cl"
#include "shared/scene.h"

#ifdef HAS_SECOND_UVS
#define UV_SETS 2
#else
#define UV_SETS 1
#endif

static inline IntL clamp_lane(IntL i, int low, int high)
{
  IntL least = INTL(low), most = INTL(high);
  return i < least ? least : i > most ? most : i;
}

// Texel coordinates under a wrap mode, for i in [-1, 2 size], and those of the texel behind.
typedef struct TexelPair {
  IntL first, second;
} TexelPair;

static inline TexelPair wrap_texels(IntL i, int size, uint mode)
{
  IntL zero = INTL(0), one = INTL(1), period = INTL(mode == WRAP_MODE_MIRROR ? 2 * size : size);
  TexelPair out = {clamp_lane(i, 0, size - 1), clamp_lane(i + one, 0, size - 1)};
  if (mode == WRAP_MODE_CLAMP) return out;
  i += i < zero ? period : zero;
  i -= i >= period ? period : zero;
  i -= i >= period ? period : zero;
  out.first = i;
  out.second = i + one < period ? i + one : zero;
  if (mode == WRAP_MODE_REPEAT) return out;
  out.first = out.first < INTL(size) ? out.first : period - one - out.first;
  out.second = out.second < INTL(size) ? out.second : period - one - out.second;
  return out;
}

static inline FloatL mix_lane(FloatL a, FloatL b, FloatL share) { return a + (b - a) * share; }

static inline Color4L mix_color(Color4L a, Color4L b, FloatL share)
{
  Color4L out = {
      vec3l(mix_lane(a.rgb.x, b.rgb.x, share), mix_lane(a.rgb.y, b.rgb.y, share), mix_lane(a.rgb.z, b.rgb.z, share)),
      a.a};
#ifdef HAS_ALPHA
  out.a = mix_lane(a.a, b.a, share);
#endif
  return out;
}

// Values at (x, y) of the lanes of `mask` (y = 0 is the top row, texel centres at (i + 1/2) / size), level 0, bilinear
// or nearest.
static inline Color4L texture_sample(const TextureInfo *info, const Texels *texels, FloatL x, FloatL y, IntL mask)
{
  FloatL high = FLOATL(2), half_texel = FLOATL(0.5f), zero = FLOATL(0);
  // Far coordinates would overflow the conversion to int; a period is taken off first, where there is one.
  if (info->wrap_u != WRAP_MODE_CLAMP) x -= high * floor_lane(x * half_texel);
  if (info->wrap_v != WRAP_MODE_CLAMP) y -= high * floor_lane(y * half_texel);
  // What is not a number is 0, as other lanes are; so is what lies before the first texel's centre where it is clamped.
  x = (mask & (x > zero)) ? x : zero;
  y = (mask & (y > zero)) ? y : zero;
  int width = (int)info->width, height = (int)info->height;
  x = min_lane(x, high) * FLOATL((float)width);
  y = min_lane(y, high) * FLOATL((float)height);
  if (info->nearest) {
    IntL column = wrap_texels(LANE_CONVERT_INT(floor_lane(x)), width, info->wrap_u).first;
    IntL row = wrap_texels(LANE_CONVERT_INT(floor_lane(y)), height, info->wrap_v).first;
    Color4L nearest[2];
    IntL place = row * INTL(width) + column;
    texels_load(nearest, texels, place, place);
    return nearest[0];
  }
  x -= half_texel;
  y -= half_texel;
  FloatL base_x = floor_lane(x), base_y = floor_lane(y);
  TexelPair across = wrap_texels(LANE_CONVERT_INT(base_x), width, info->wrap_u);
  TexelPair down = wrap_texels(LANE_CONVERT_INT(base_y), height, info->wrap_v);
  IntL x0 = across.first, x1 = across.second, y0 = down.first * INTL(width), y1 = down.second * INTL(width);
  Color4L at[4];
  texels_load(at, texels, y0 + x0, y0 + x1);
  texels_load(at + 2, texels, y1 + x0, y1 + x1);
  return mix_color(mix_color(at[0], at[1], x - base_x), mix_color(at[2], at[3], x - base_x), y - base_y);
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

// What corners bring to a hit: texture coordinates by set, and the vertex colour.
typedef struct Attributes {
  FloatL s[UV_SETS], t[UV_SETS];
  Color4L color;
} Attributes;

// Sets the lanes of `group`, which hit one triangle at barycentrics (u, v).
static inline void attributes_load(Attributes *out, const AttributeSources *from, const TriangleCorners *corners,
                                   IntL group, FloatL u, FloatL v)
{
  FloatL w = FLOATL(1) - u - v;
#ifdef HAS_TEXTURES
#pragma unroll
  for (uint set = 0; set < UV_SETS; set++) {
    float2 a = corner_uv(from, set, corners->vertex[0]), b = corner_uv(from, set, corners->vertex[1]),
           c = corner_uv(from, set, corners->vertex[2]);
    out->s[set] = group ? FLOATL(a.x) * w + FLOATL(b.x) * u + FLOATL(c.x) * v : out->s[set];
    out->t[set] = group ? FLOATL(a.y) * w + FLOATL(b.y) * u + FLOATL(c.y) * v : out->t[set];
  }
#endif
#ifdef HAS_VERTEX_COLORS
  float4 a = vload4(corners->vertex[0], (global const float *)from->colors);
  float4 b = vload4(corners->vertex[1], (global const float *)from->colors);
  float4 c = vload4(corners->vertex[2], (global const float *)from->colors);
  Vec3L rgb =
      vec3l(FLOATL(a.x) * w + FLOATL(b.x) * u + FLOATL(c.x) * v, FLOATL(a.y) * w + FLOATL(b.y) * u + FLOATL(c.y) * v,
            FLOATL(a.z) * w + FLOATL(b.z) * u + FLOATL(c.z) * v);
  out->color.rgb = select3(group, rgb, out->color.rgb);
  out->color.a = group ? FLOATL(a.w) * w + FLOATL(b.w) * u + FLOATL(c.w) * v : out->color.a;
#endif
}

// Where there are none.
static inline Attributes attributes_none(void)
{
  Attributes none;
  FloatL zero = FLOATL(0), one = FLOATL(1);
#pragma unroll
  for (uint set = 0; set < UV_SETS; set++) none.s[set] = none.t[set] = zero;
  none.color.rgb = vec3l(one, one, one);
  none.color.a = one;
  return none;
}

// A material's texture in the lanes of `group`; `table` 0 decodes sRGB, 256 leaves values as they are.
static inline Color4L texture_use_sample(const AttributeSources *from, global const TextureUse *use,
                                         const Attributes *at, IntL group, uint table)
{
  FloatL s = at->s[0], t = at->t[0];
  if (UV_SETS > 1 && use->uv_set) {
    s = at->s[UV_SETS - 1];
    t = at->t[UV_SETS - 1];
  }
  global const float *m = use->matrix;
  FloatL x = FLOATL(m[0]) * s + FLOATL(m[1]) * t + FLOATL(m[2]);
  FloatL y = FLOATL(m[3]) * s + FLOATL(m[4]) * t + FLOATL(m[5]);
  TextureInfo info = from->textures[use->texture];
  Texels texels = {(global const uint *)(from->texels + info.first_texel), from->linear_from_byte + table};
  return texture_sample(&info, &texels, x, y, group);
}

// Base colour and alpha of the lanes of `group`: factor x texture x vertex colour.
static inline Color4L base_color_sample(const AttributeSources *from, global const MaterialInfo *material,
                                        const Attributes *at, IntL group)
{
  Color4L color = at->color;
#ifdef HAS_TEXTURES
  if (material->base_color_use.texture != TEXTURE_NONE) {
    Color4L texel = texture_use_sample(from, &material->base_color_use, at, group, 0);
    color.rgb = mul3(texel.rgb, color.rgb);
    color.a *= texel.a;
  }
#endif
  color.rgb = mul3(color.rgb, vec3l(FLOATL(material->base_color[0]), FLOATL(material->base_color[1]),
                                    FLOATL(material->base_color[2])));
  color.a *= FLOATL(material->base_color[3]);
  return color;
}
