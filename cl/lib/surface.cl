// The surface at a hit: position with its error bound, normals, material. World space.

#include "lib/brdf.cl"
#include "lib/texture.cl"

// Arrays of the scene (host/device_scene), by vertex.
typedef struct GeometrySources {
  global const float *positions;  // [vertex_count][3]
  global const float *normals;    // [vertex_count][3]
  global const Float4
      *tangents;  // [vertex_count], w = side of the bitangent, 0 where the file has none; with HAS_NORMAL_MAPS
} GeometrySources;

typedef struct Surface {
  Vec3L position;
  Vec3L offset;     // what to add to the position to be outside, on the viewer's side, whatever the rounding
  Vec3L geometric;  // unit normal of the triangle, to the viewer
  Vec3L normal;     // unit shading normal, on the side of the geometric one's flip
  Vec3L emission;
  Vec3L base;
  FloatL alpha;      // 1, or what a BLEND surface stops
  FloatL occlusion;  // of the environment's diffuse light; 1 is open
  Reflectance reflectance;
  IntL unlit;
} Surface;

// Bound on the rounding of a point from barycentrics and on that of the triangle test, as a factor on the sum of the
// magnitudes: twice gamma(7) of Pharr, Jakob, Humphreys, "Physically Based Rendering", 3rd edition, 2016, section 3.9.
#define POSITION_ERROR 8.4e-7f

// Sets the lanes of `group` to the vector `index` of an array.
static inline void group_vector_load(Vec3L *out, IntL group, global const float *array, uint index)
{
  float3 value = vload3(index, array);
  out->x = group ? FLOATL(value.x) : out->x;
  out->y = group ? FLOATL(value.y) : out->y;
  out->z = group ? FLOATL(value.z) : out->z;
}

static inline Vec3L blend3(Vec3L a, Vec3L b, Vec3L c, FloatL u, FloatL v)
{
  FloatL w = FLOATL(1) - u - v;
  return add3(add3(scale3(a, w), scale3(b, u)), scale3(c, v));
}

#ifdef HAS_NORMAL_MAPS
// Tangents of a mapped normal: glTF 2.0, sections 3.7.2.1 and 3.9.3. Where the file gives none, the triangle's own.
typedef struct TangentFrame {
  Vec3L tangent;
  FloatL side;    // bitangent = cross(normal, tangent) x side; 0: no normal map here
  Vec3L sampled;  // in the frame tangent, bitangent, normal
} TangentFrame;

// Sets all but what is sampled, for the lanes of `group` on one triangle.
static inline void tangent_frame_load(TangentFrame *frame, const GeometrySources *geometry,
                                      const AttributeSources *attributes, const TriangleCorners *corners,
                                      global const MaterialInfo *material, IntL group, FloatL u, FloatL v)
{
  global const float *tangents = (global const float *)geometry->tangents;
  float4 a = vload4(corners->vertex[0], tangents), b = vload4(corners->vertex[1], tangents);
  float4 c = vload4(corners->vertex[2], tangents);
  if (a.w == 0) {
    float3 p = vload3(corners->vertex[0], geometry->positions);
    float3 pb = vload3(corners->vertex[1], geometry->positions) - p,
           pc = vload3(corners->vertex[2], geometry->positions) - p;
    uint set = material->normal_use.uv_set;
    float2 t = corner_uv(attributes, set, corners->vertex[0]);
    float2 tb = corner_uv(attributes, set, corners->vertex[1]) - t,
           tc = corner_uv(attributes, set, corners->vertex[2]) - t;
    float sign = tb.x * tc.y - tc.x * tb.y < 0 ? -1 : 1;
    float3 along_u = (pb * tc.y - pc * tb.y) * sign, along_v = (pc * tb.x - pb * tc.x) * sign;
    float length = sqrt(dot(along_u, along_u));
    float side = dot(cross(cross(pb, pc), along_u), along_v) < 0 ? -1 : 1;
    a = b = c = (float4)(length > 0 ? along_u / length : (float3)(0), side);
  }
  Vec3L tangent = blend3(vec3l(FLOATL(a.x), FLOATL(a.y), FLOATL(a.z)), vec3l(FLOATL(b.x), FLOATL(b.y), FLOATL(b.z)),
                         vec3l(FLOATL(c.x), FLOATL(c.y), FLOATL(c.z)), u, v);
  frame->tangent = select3(group, tangent, frame->tangent);
  frame->side = group ? FLOATL(a.w) : frame->side;
}

static inline void normal_sample(TangentFrame *frame, const AttributeSources *attributes,
                                 global const MaterialInfo *material, const Attributes *at, IntL group)
{
  Vec3L texel = texture_use_sample(attributes, &material->normal_use, at, group, 256).rgb;
  FloatL scale = FLOATL(2 * material->normal_scale), shift = FLOATL(material->normal_scale);
  Vec3L sampled = vec3l(texel.x * scale - shift, texel.y * scale - shift, FLOATL(2) * texel.z - FLOATL(1));
  frame->sampled = select3(group, sampled, frame->sampled);
}

static inline Vec3L normal_mapped(const TangentFrame *frame, Vec3L normal)
{
  Vec3L bitangent = scale3(cross3(normal, frame->tangent), frame->side);
  Vec3L mapped = add3(scale3(frame->tangent, frame->sampled.x), scale3(bitangent, frame->sampled.y));
  mapped = add3(mapped, scale3(normal, frame->sampled.z));
  return select3((frame->side != FLOATL(0)) & (dot3(mapped, mapped) > FLOATL(0)), unit3(mapped), normal);
}
#endif

// Unit normal; the triangle's front is where its corners run counter-clockwise.
static inline Vec3L triangle_normal(const Vec3L p[3]) { return unit3(cross3(sub3(p[1], p[0]), sub3(p[2], p[0]))); }

// Corners of the triangles that lanes hit, and what else is read of them.
typedef struct HitTriangles {
  Vec3L p[3], n[3];
  Vec3L geometric;  // unit normal
  Attributes at;
  UintL material;
#ifdef HAS_NORMAL_MAPS
  TangentFrame frame;
#endif
} HitTriangles;

// Sets what hangs on the place (u, v) in a triangle, for the lanes of `group` that hit it.
static inline __attribute__((always_inline)) void hit_place_set(HitTriangles *out, const GeometrySources *geometry,
                                                                const AttributeSources *attributes,
                                                                const TriangleCorners *corners, IntL group, FloatL u,
                                                                FloatL v)
{
  attributes_load(&out->at, attributes, corners, group, u, v);
#ifdef HAS_NORMAL_MAPS
  global const MaterialInfo *material = &attributes->materials[corners->material];
  if (material->normal_use.texture != TEXTURE_NONE)
    tangent_frame_load(&out->frame, geometry, attributes, corners, material, group, u, v);
#endif
}

// Sets the rest.
static inline __attribute__((always_inline)) void hit_corners_set(HitTriangles *out, const GeometrySources *geometry,
                                                                  const TriangleCorners *corners, IntL group)
{
#pragma unroll
  for (uint i = 0; i < 3; i++) {
    group_vector_load(&out->p[i], group, geometry->positions, corners->vertex[i]);
    group_vector_load(&out->n[i], group, geometry->normals, corners->vertex[i]);
  }
  out->material = group ? UINTL(corners->material) : out->material;
}

// Sets the lanes of `group`, which hit one triangle.
static inline __attribute__((always_inline)) void hit_triangle_load(HitTriangles *out, const GeometrySources *geometry,
                                                                    const AttributeSources *attributes, uint triangle,
                                                                    IntL group, FloatL u, FloatL v)
{
  TriangleCorners corners = attributes->corners[triangle];
  hit_corners_set(out, geometry, &corners, group);
  hit_place_set(out, geometry, attributes, &corners, group, u, v);
}

// Loads a triangle that all lanes will hit, but for what hangs on where they do.
static inline void hit_triangle_hold(HitTriangles *out, const GeometrySources *geometry,
                                     const AttributeSources *attributes, uint triangle)
{
  TriangleCorners corners = attributes->corners[triangle];
  hit_corners_set(out, geometry, &corners, INTL(-1));
  out->geometric = triangle_normal(out->p);
}

// Lanes on one triangle load it once. Where that is all of them, nothing is kept of others; where *out holds it
// already, only what hangs on the place in it is loaded.
static inline void hit_triangles_load(HitTriangles *out, const GeometrySources *geometry,
                                      const AttributeSources *attributes, UintL id, FloatL u, FloatL v, IntL mask,
                                      bool held)
{
  Vec3L nothing = vec3l(FLOATL(0), FLOATL(0), FLOATL(0));
  out->at = attributes_none();
#ifdef HAS_NORMAL_MAPS
  TangentFrame none = {nothing, FLOATL(0), nothing};
  out->frame = none;
#endif
  if (held) {
    TriangleCorners corners = attributes->corners[LANE_UINT(id, 0)];
    hit_place_set(out, geometry, attributes, &corners, INTL(-1), u, v);
    return;
  }
  for (uint i = 0; i < 3; i++) out->p[i] = out->n[i] = nothing;
  out->material = UINTL(0);
  uint bits = lane_bits(mask);
  if (!bits) return;
  uint triangle = LANE_UINT(id, lowest_bit(bits));
  if (!any_lane(mask & (id != UINTL(triangle)))) {
    hit_triangle_load(out, geometry, attributes, triangle, INTL(-1), u, v);
    return;
  }
  while (bits) {
    triangle = LANE_UINT(id, lowest_bit(bits));
    IntL group = mask & (id == UINTL(triangle));
    bits &= ~lane_bits(group);
    hit_triangle_load(out, geometry, attributes, triangle, group, u, v);
  }
}

// Sets what the surface has of a material, for the lanes of `group`.
static inline __attribute__((always_inline)) void material_sample(Surface *s, FloatL *metallic, HitTriangles *of,
                                                                  const AttributeSources *attributes, uint number,
                                                                  IntL group)
{
  const FloatL zero = FLOATL(0), one = FLOATL(1);
  global const MaterialInfo *material = &attributes->materials[number];
  Color4L base = base_color_sample(attributes, material, &of->at, group);
  FloatL roughness = FLOATL(material->roughness), group_metallic = FLOATL(material->metallic);
  Vec3L emission = vec3l(FLOATL(material->emission[0]), FLOATL(material->emission[1]), FLOATL(material->emission[2]));
#ifdef HAS_TEXTURES
  if (material->metallic_roughness_use.texture != TEXTURE_NONE) {
    Vec3L texel = texture_use_sample(attributes, &material->metallic_roughness_use, &of->at, group, 256).rgb;
    roughness *= texel.y;
    group_metallic *= texel.z;
  }
  if (material->emission_use.texture != TEXTURE_NONE)
    emission = mul3(emission, texture_use_sample(attributes, &material->emission_use, &of->at, group, 0).rgb);
  if (material->occlusion_use.texture != TEXTURE_NONE) {
    FloatL open = texture_use_sample(attributes, &material->occlusion_use, &of->at, group, 256).rgb.x;
    s->occlusion = group ? one + FLOATL(material->occlusion_strength) * (open - one) : s->occlusion;
  }
#endif
#ifdef HAS_NORMAL_MAPS
  if (material->normal_use.texture != TEXTURE_NONE) normal_sample(&of->frame, attributes, material, &of->at, group);
#endif
  s->base = select3(group, base.rgb, s->base);
  s->emission = select3(group, emission, s->emission);
  s->reflectance.roughness = group ? roughness : s->reflectance.roughness;
  *metallic = group ? group_metallic : *metallic;
  if (material->flags & MATERIAL_UNLIT) s->unlit = s->unlit | group;
#ifdef HAS_BLEND
  if (material->flags & MATERIAL_BLENDED) s->alpha = group ? max_lane(min_lane(base.a, one), zero) : s->alpha;
#endif
}

// Sets what it has of all. Lanes of one material sample it at once; `held`: all are on one triangle.
static inline void materials_sample(Surface *s, FloatL *metallic, HitTriangles *of, const AttributeSources *attributes,
                                    IntL mask, bool held)
{
  FloatL zero = FLOATL(0), one = FLOATL(1);
  *metallic = zero;
  s->base = s->emission = vec3l(zero, zero, zero);
  s->occlusion = s->alpha = one;
  s->reflectance.roughness = zero;
  s->unlit = INTL(0);
  if (held) {
    material_sample(s, metallic, of, attributes, LANE_UINT(of->material, 0), INTL(-1));
    return;
  }
  for (uint bits = lane_bits(mask); bits;) {
    uint number = LANE_UINT(of->material, lowest_bit(bits));
    IntL group = mask & (of->material == UINTL(number));
    bits &= ~lane_bits(group);
    material_sample(s, metallic, of, attributes, number, group);
  }
}

// What to add to a position on a triangle to be on the side of `normal`, its own or the opposite one, whatever the
// rounding.
static inline Vec3L position_offset(const Vec3L p[3], FloatL u, FloatL v, Vec3L normal)
{
  FloatL w = FLOATL(1) - u - v;
  Vec3L error = vec3l(fabs(w * p[0].x) + fabs(u * p[1].x) + fabs(v * p[2].x),
                      fabs(w * p[0].y) + fabs(u * p[1].y) + fabs(v * p[2].y),
                      fabs(w * p[0].z) + fabs(u * p[1].z) + fabs(v * p[2].z));
  FloatL distance =
      FLOATL(POSITION_ERROR) * (fabs(normal.x) * error.x + fabs(normal.y) * error.y + fabs(normal.z) * error.z);
  return scale3(normal, distance);
}

// Surface at barycentrics (u, v) of triangles `id`, for the lanes of `mask`, seen along `direction` (any length). `on`
// is room for the triangles; `held`: it holds that of all lanes (hit_triangle_hold).
static inline Surface surface_load(HitTriangles *on, const GeometrySources *geometry,
                                   const AttributeSources *attributes, UintL id, FloatL u, FloatL v, Vec3L direction,
                                   IntL mask, bool held)
{
  Surface s;
  FloatL zero = FLOATL(0), one = FLOATL(1), metallic;
  Vec3L nothing = vec3l(zero, zero, zero);
  hit_triangles_load(on, geometry, attributes, id, u, v, mask, held);
  if (!held) on->geometric = triangle_normal(on->p);
  s.geometric = on->geometric;
  materials_sample(&s, &metallic, on, attributes, mask, held);
  s.position = blend3(on->p[0], on->p[1], on->p[2], u, v);
  Vec3L interpolated = blend3(on->n[0], on->n[1], on->n[2], u, v);
  s.normal = select3(dot3(interpolated, interpolated) > zero, unit3(interpolated), s.geometric);
#ifdef HAS_NORMAL_MAPS
  s.normal = normal_mapped(&on->frame, s.normal);
#endif
  IntL behind = dot3(s.geometric, direction) > zero;
  s.geometric = select3(behind, sub3(nothing, s.geometric), s.geometric);
  s.normal = select3(behind, sub3(nothing, s.normal), s.normal);
  s.offset = position_offset(on->p, u, v, s.geometric);

  FloatL diffuse = one - metallic;
  s.reflectance.diffuse = scale3(s.base, diffuse);
  FloatL dielectric = FLOATL(0.04f) * diffuse;
  s.reflectance.specular =
      vec3l(dielectric + s.base.x * metallic, dielectric + s.base.y * metallic, dielectric + s.base.z * metallic);
  s.reflectance.mirror = s.reflectance.roughness <= zero;
  return s;
}
