// The two lighting models, for punctual lights. Unit vectors: n normal, v to the eye, l to the light.
//
//   From  Khronos, "glTF 2.0 Specification", appendix B, 2021 (pbr: GGX distribution, height-correlated Smith masking,
//         Schlick's Fresnel); Vucurevich, 2007 (phong, normalised Blinn-Phong).

#include "lib/lanes.cl"

#define INV_PI 0.31830988618f

// What the models need of a surface.
typedef struct Reflectance {
  Vec3L diffuse;     // pbr: base (1 - metallic); phong: the same, called kd
  Vec3L specular;    // pbr: F0; phong: ks
  FloatL roughness;  // perceptual; its square is the GGX alpha
  IntL mirror;       // roughness 0: no highlight of a punctual light
} Reflectance;

// Schlick's (1 - cos)^5.
static inline FloatL schlick5(FloatL cosine)
{
  FloatL m = FLOATL(1) - min_lane(cosine, FLOATL(1));
  FloatL m2 = m * m;
  return m2 * m2 * m;
}

static inline Vec3L fresnel_schlick(Vec3L f0, FloatL cosine)
{
  FloatL f = schlick5(cosine);
  return vec3l(f0.x + (FLOATL(1) - f0.x) * f, f0.y + (FLOATL(1) - f0.y) * f, f0.z + (FLOATL(1) - f0.z) * f);
}

// The two terms of pbr for light from l, without n.l, and the density of l among reflections at visible normals
// (lib/lobe.cl), 1 / sr. Both terms are for l above the surface.
typedef struct PbrTerms {
  Vec3L diffuse, specular;
  FloatL specular_density;
  FloatL nl;  // max(0, n.l)
} PbrTerms;

// The GGX denominator is alpha^2 (n.h)^2 + |n x h|^2, which keeps its digits for small alpha.
static inline PbrTerms brdf_pbr_terms(const Reflectance *r, Vec3L n, Vec3L v, Vec3L l)
{
  PbrTerms terms;
  FloatL zero = FLOATL(0), one = FLOATL(1);
  Vec3L h = unit3(add3(l, v));
  Vec3L nxh = cross3(n, h);
  FloatL nl = max_lane(dot3(n, l), zero), nv = max_lane(fabs(dot3(n, v)), FLOATL(1e-6f));
  FloatL nh = dot3(n, h), vh = fabs(dot3(v, h));
  FloatL alpha = r->roughness * r->roughness, alpha2 = max_lane(alpha * alpha, FLOATL(1e-18f));  // so that d is finite
  FloatL denominator = alpha2 * nh * nh + dot3(nxh, nxh);
  FloatL d = nh > zero ? alpha2 * FLOATL(INV_PI) / (denominator * denominator) : zero;
  FloatL masking_v = sqrt(nv * nv * (one - alpha2) + alpha2);
  FloatL smith_v = nl * masking_v;
  FloatL smith_l = nv * sqrt(nl * nl * (one - alpha2) + alpha2);
  FloatL specular = r->mirror ? zero : d * FLOATL(0.5f) / max_lane(smith_v + smith_l, FLOATL(1e-20f));
  Vec3L f = fresnel_schlick(r->specular, vh);
  terms.diffuse = vec3l((one - f.x) * r->diffuse.x * FLOATL(INV_PI), (one - f.y) * r->diffuse.y * FLOATL(INV_PI),
                        (one - f.z) * r->diffuse.z * FLOATL(INV_PI));
  terms.specular = scale3(f, specular);
  terms.specular_density = r->mirror ? zero : d * FLOATL(0.5f) / (nv + masking_v);
  terms.nl = nl;
  return terms;
}

// f x max(0, n.l), pbr.
static inline Vec3L brdf_pbr(const Reflectance *r, Vec3L n, Vec3L v, Vec3L l)
{
  PbrTerms terms = brdf_pbr_terms(r, n, v, l);
  return scale3(add3(terms.diffuse, terms.specular), terms.nl);
}

// f x max(0, n.l), phong: kd / pi + ks (n + 8) / (8 pi) (n.h)^n with n = 2 / roughness^4 - 2. The power goes through
// log1p(-|n x h|^2) / 2 = log(n.h), exact near the highlight's centre where n.h rounds to 1.
static inline Vec3L brdf_phong(const Reflectance *r, Vec3L n, Vec3L v, Vec3L l)
{
  FloatL zero = FLOATL(0);
  Vec3L h = unit3(add3(l, v));
  Vec3L nxh = cross3(n, h);
  FloatL nl = max_lane(dot3(n, l), zero);
  FloatL alpha = r->roughness * r->roughness;
  FloatL exponent = FLOATL(2) / max_lane(alpha * alpha, FLOATL(1e-20f)) - FLOATL(2);
  FloatL log_nh = FLOATL(0.5f) * log1p(-min_lane(dot3(nxh, nxh), FLOATL(0.99999994f)));
  FloatL power = dot3(n, h) > zero ? exp(exponent * log_nh) : zero;
  power = (exponent <= zero) ? FLOATL(1) : power;  // (n.h)^0, also where n.h is 0
  FloatL lobe = r->mirror ? zero : power * (exponent + FLOATL(8)) * FLOATL(0.125f * INV_PI);
  Vec3L sum =
      vec3l(r->diffuse.x * FLOATL(INV_PI) + r->specular.x * lobe, r->diffuse.y * FLOATL(INV_PI) + r->specular.y * lobe,
            r->diffuse.z * FLOATL(INV_PI) + r->specular.z * lobe);
  return scale3(sum, nl);
}

// Share of unoccluded irradiance that the diffuse term of pbr sends to the eye, by n.v: 1 - F averaged over the cosine
// hemisphere, F0 + (1 - F0) g(n.v). g is a quartic fit to the integral of (1 - v.h)^5, within 5e-6.
static inline Vec3L diffuse_albedo_pbr(const Reflectance *r, FloatL nv)
{
  FloatL g =
      FLOATL(0.02815973f) +
      nv * (FLOATL(-0.07974394f) + nv * (FLOATL(0.08593338f) + nv * (FLOATL(-0.04282516f) + nv * FLOATL(0.00855366f))));
  FloatL keep = FLOATL(1) - g;
  return vec3l(r->diffuse.x * (FLOATL(1) - r->specular.x) * keep, r->diffuse.y * (FLOATL(1) - r->specular.y) * keep,
               r->diffuse.z * (FLOATL(1) - r->specular.z) * keep);
}

// Directional albedo of the pbr specular term, F0 (all - grazing) + grazing: quotients of polynomials fitted to the
// integrals that make it, at F0 = 1 within 0.03 and by 0.01 in the mean, at F0 = 0.04 by 0.004 in the mean.
static inline Vec3L specular_albedo_fit(const Reflectance *r, FloatL nv)
{
  FloatL x = nv, z = r->roughness, y = z * z;
  FloatL all = FLOATL(0.960786f) + y * (FLOATL(-33.6227f) + y * (FLOATL(4178.99f) - y * FLOATL(3495.97f))) +
               x * (FLOATL(-115.398f) + y * (FLOATL(-1606.71f) + y * FLOATL(3485.23f)) +
                    x * (FLOATL(4808.66f) - y * FLOATL(5523.21f) - x * FLOATL(316.781f)));
  all /= FLOATL(1) + y * (FLOATL(-35.2985f) + y * (FLOATL(4312.42f) - y * FLOATL(3619))) +
         x * (FLOATL(-120.08f) + y * (FLOATL(-1432.03f) + y * FLOATL(6047.52f)) +
              x * (FLOATL(4935.54f) - y * FLOATL(4814.83f) - x * FLOATL(525.399f)));
  FloatL grazing = FLOATL(1.0163f) + z * (FLOATL(-1.47979f) + z * FLOATL(0.747576f)) +
                   x * (FLOATL(-2.51627f) + z * (FLOATL(4.08196f) - z * FLOATL(2.22945f)) +
                        x * (FLOATL(1.52811f) + z * (FLOATL(-2.64947f) + z * FLOATL(1.50446f))));
  grazing /= FLOATL(1) + z * (FLOATL(0.240836f) + z * FLOATL(5.24091f)) +
             x * (FLOATL(1.63451f) + z * (FLOATL(-24.9719f) + z * FLOATL(50.3145f)) +
                  x * (FLOATL(11.6626f) + z * (FLOATL(8.7609f) - z * FLOATL(49.3078f))));
  grazing = max_lane(grazing, FLOATL(0));
  FloatL straight = all - grazing;
  return vec3l(r->specular.x * straight + grazing, r->specular.y * straight + grazing,
               r->specular.z * straight + grazing);
}
