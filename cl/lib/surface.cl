// The surface at a hit: position with its error bound, normals, material. World space.

#include "lib/brdf.cl"
#include "lib/texture.cl"

// Arrays of the scene (host/device_scene), by vertex or by triangle id.
typedef struct GeometrySources {
  global const float *positions;  // [vertex_count][3]
  global const float *normals;    // [vertex_count][3]
} GeometrySources;

typedef struct Surface {
  Vec3L position;
  Vec3L offset;     // what to add to the position to be outside, on the viewer's side, whatever the rounding
  Vec3L geometric;  // unit normal of the triangle, to the viewer
  Vec3L normal;     // unit shading normal, on the side of the geometric one's flip
  Vec3L emission;
  Vec3L base;
  Reflectance reflectance;
  IntL unlit;
} Surface;

// Bound on the rounding of a point from barycentrics and on that of the triangle test, as a factor on the sum of the
// magnitudes: twice gamma(7) of Pharr, Jakob, Humphreys, "Physically Based Rendering", 3rd edition, 2016, section 3.9.
#define POSITION_ERROR 8.4e-7f

static inline void lane_vector_load(Vec3L *out, uint lane, global const float *array, uint index)
{
  LANE_FLOAT(out->x, lane) = array[3 * index];
  LANE_FLOAT(out->y, lane) = array[3 * index + 1];
  LANE_FLOAT(out->z, lane) = array[3 * index + 2];
}

// Surface at barycentrics (u, v) of triangles `id`, for the lanes of `mask`, seen along `direction` (any length).
static inline Surface surface_load(const GeometrySources *geometry, const AttributeSources *attributes, UintL id, FloatL u,
                                   FloatL v, Vec3L direction, IntL mask)
{
  Surface s;
  FloatL zero = FLOATL(0), one = FLOATL(1);
  Vec3L nothing = vec3l(zero, zero, zero);
  Vec3L p0 = nothing, p1 = nothing, p2 = nothing, n0 = nothing, n1 = nothing, n2 = nothing;
  FloatL metallic = zero;
  s.base = s.emission = nothing;
  s.reflectance.roughness = zero;
  UintL flags = UINTL(0);
  for (uint bits = lane_bits(mask); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    TriangleCorners corners = attributes->corners[LANE_UINT(id, lane)];
    global const MaterialInfo *material = &attributes->materials[corners.material];
    lane_vector_load(&p0, lane, geometry->positions, corners.vertex[0]);
    lane_vector_load(&p1, lane, geometry->positions, corners.vertex[1]);
    lane_vector_load(&p2, lane, geometry->positions, corners.vertex[2]);
    lane_vector_load(&n0, lane, geometry->normals, corners.vertex[0]);
    lane_vector_load(&n1, lane, geometry->normals, corners.vertex[1]);
    lane_vector_load(&n2, lane, geometry->normals, corners.vertex[2]);
    float lane_u = LANE_FLOAT(u, lane), lane_v = LANE_FLOAT(v, lane);
    float4 base = base_color_sample(attributes, &corners, lane_u, lane_v);
    float roughness = material->roughness, lane_metallic = material->metallic;
    float3 emission = vload3(0, material->emission);
#ifdef HAS_TEXTURES
    if (material->metallic_roughness_use.texture != TEXTURE_NONE) {
      float4 t = texture_use_sample(attributes, &material->metallic_roughness_use, &corners, lane_u, lane_v, 256);
      roughness *= t.y;
      lane_metallic *= t.z;
    }
    if (material->emission_use.texture != TEXTURE_NONE)
      emission *= texture_use_sample(attributes, &material->emission_use, &corners, lane_u, lane_v, 0).xyz;
#endif
    LANE_FLOAT(s.base.x, lane) = base.x;
    LANE_FLOAT(s.base.y, lane) = base.y;
    LANE_FLOAT(s.base.z, lane) = base.z;
    LANE_FLOAT(s.emission.x, lane) = emission.x;
    LANE_FLOAT(s.emission.y, lane) = emission.y;
    LANE_FLOAT(s.emission.z, lane) = emission.z;
    LANE_FLOAT(s.reflectance.roughness, lane) = roughness;
    LANE_FLOAT(metallic, lane) = lane_metallic;
    LANE_UINT(flags, lane) = material->flags;
  }
  FloatL w = one - u - v;
  s.position = add3(add3(scale3(p0, w), scale3(p1, u)), scale3(p2, v));
  s.geometric = unit3(cross3(sub3(p1, p0), sub3(p2, p0)));
  Vec3L interpolated = add3(add3(scale3(n0, w), scale3(n1, u)), scale3(n2, v));
  IntL defined = dot3(interpolated, interpolated) > zero;
  s.normal = select3(defined, unit3(interpolated), s.geometric);
  IntL behind = dot3(s.geometric, direction) > zero;
  s.geometric = select3(behind, sub3(nothing, s.geometric), s.geometric);
  s.normal = select3(behind, sub3(nothing, s.normal), s.normal);

  Vec3L error = vec3l(fabs(w * p0.x) + fabs(u * p1.x) + fabs(v * p2.x), fabs(w * p0.y) + fabs(u * p1.y) + fabs(v * p2.y),
                      fabs(w * p0.z) + fabs(u * p1.z) + fabs(v * p2.z));
  FloatL distance = FLOATL(POSITION_ERROR) *
                    (fabs(s.geometric.x) * error.x + fabs(s.geometric.y) * error.y + fabs(s.geometric.z) * error.z);
  s.offset = scale3(s.geometric, distance);

  FloatL diffuse = one - metallic;
  s.reflectance.diffuse = scale3(s.base, diffuse);
  FloatL dielectric = FLOATL(0.04f) * diffuse;
  s.reflectance.specular = vec3l(dielectric + s.base.x * metallic, dielectric + s.base.y * metallic, dielectric + s.base.z * metallic);
  s.reflectance.mirror = s.reflectance.roughness <= zero;
  s.unlit = (flags & UINTL(MATERIAL_UNLIT)) != UINTL(0);
  return s;
}
