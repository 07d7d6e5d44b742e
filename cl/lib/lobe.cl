// Directions sampled as a surface reflects: a cosine lobe, and GGX by the normals that the eye sees.
//
//   From  Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 2018; Dupuy, Benyoub, "Sampling Visible GGX
//         Normals with Spherical Caps", 2023 (the same density); Duff and others, "Building an Orthonormal Basis,
//         Revisited", JCGT 2017.

#include "lib/brdf.cl"

// Tangents that make a right-handed orthonormal frame with the unit vector n.
static inline void frame_about(Vec3L n, Vec3L *tangent, Vec3L *bitangent)
{
  FloatL one = FLOATL(1), zero = FLOATL(0);
  FloatL sign = n.z >= zero ? one : zero - one;
  FloatL a = FLOATL(-1) / (sign + n.z), b = n.x * n.y * a;
  *tangent = vec3l(one + sign * n.x * n.x * a, sign * b, zero - sign * n.x);
  *bitangent = vec3l(b, sign + n.y * n.y * a, zero - n.y);
}

static inline Vec3L from_frame(Vec3L tangent, Vec3L bitangent, Vec3L n, FloatL x, FloatL y, FloatL z)
{
  return add3(add3(scale3(tangent, x), scale3(bitangent, y)), scale3(n, z));
}

// Direction about n with density n.l / pi.
static inline Vec3L cosine_sample(Vec3L n, FloatL x, FloatL y)
{
  Vec3L tangent, bitangent;
  frame_about(n, &tangent, &bitangent);
  FloatL phi = FLOATL(6.2831853f) * x, radius = sqrt(y);
  return from_frame(tangent, bitangent, n, radius * cos(phi), radius * sin(phi), sqrt(FLOATL(1) - y));
}

// What a sample of a lobe stands for: the light from `direction` times `weight`, over the share of samples that go to
// the lobe, is the lobe's reflection in the mean. A direction below n has weight 0.
typedef struct LobeSample {
  Vec3L direction;
  Vec3L weight;    // f x n.l / density
  FloatL density;  // 1 / sr
} LobeSample;

static inline LobeSample lobe_sample_diffuse(const Reflectance *r, Vec3L n, Vec3L v, FloatL x, FloatL y)
{
  LobeSample s;
  s.direction = cosine_sample(n, x, y);
  FloatL nl = dot3(n, s.direction), one = FLOATL(1);
  s.density = nl * FLOATL(INV_PI);
  Vec3L f = fresnel_schlick(r->specular, fabs(dot3(v, unit3(add3(v, s.direction)))));
  Vec3L weight = vec3l((one - f.x) * r->diffuse.x, (one - f.y) * r->diffuse.y, (one - f.z) * r->diffuse.z);
  Vec3L nothing = vec3l(FLOATL(0), FLOATL(0), FLOATL(0));
  s.weight = select3(nl > FLOATL(0), weight, nothing);
  return s;
}

// Needs n.v > 0. Weight F G2 / G1, never above F.
static inline LobeSample lobe_sample_specular(const Reflectance *r, Vec3L n, Vec3L v, FloatL x, FloatL y)
{
  LobeSample s;
  FloatL zero = FLOATL(0), one = FLOATL(1);
  FloatL alpha = max_lane(r->roughness * r->roughness, FLOATL(1e-9f)), alpha2 = alpha * alpha;
  Vec3L tangent, bitangent;
  frame_about(n, &tangent, &bitangent);
  FloatL nv = dot3(n, v);
  // A cap of the sphere of directions that v, stretched to the hemisphere of alpha 1, sees.
  Vec3L stretched = unit3(vec3l(alpha * dot3(tangent, v), alpha * dot3(bitangent, v), nv));
  FloatL phi = FLOATL(6.2831853f) * x;
  FloatL z = (one - y) * (one + stretched.z) - stretched.z;
  FloatL radius = sqrt(max_lane(one - z * z, zero));
  Vec3L h = add3(vec3l(radius * cos(phi), radius * sin(phi), z), stretched);
  h = unit3(vec3l(alpha * h.x, alpha * h.y, max_lane(h.z, FLOATL(1e-20f))));
  FloatL squared = h.x * h.x + h.y * h.y, denominator = alpha2 * h.z * h.z + squared;
  FloatL d = alpha2 * FLOATL(INV_PI) / (denominator * denominator);
  Vec3L half_world = from_frame(tangent, bitangent, n, h.x, h.y, h.z);
  FloatL vh = dot3(v, half_world);
  s.direction = unit3(sub3(scale3(half_world, FLOATL(2) * vh), v));
  FloatL nl = dot3(n, s.direction);
  FloatL masking_v = sqrt(nv * nv * (one - alpha2) + alpha2), masking_l = sqrt(nl * nl * (one - alpha2) + alpha2);
  s.density = d * FLOATL(0.5f) / (nv + masking_v);
  FloatL seen = nl * (nv + masking_v) / (nl * masking_v + nv * masking_l);
  Vec3L weight = scale3(fresnel_schlick(r->specular, fabs(vh)), seen);
  s.weight = select3(nl > zero, weight, vec3l(zero, zero, zero));
  return s;
}
