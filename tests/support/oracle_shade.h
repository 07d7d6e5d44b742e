// The two lighting models, the lights and the BRDFs' albedos in double precision, from the published formulas.
//
// Sources: Khronos, "glTF 2.0", 2021, appendix B (the simplified mix: c_diff, f0 and F shared by metal and dielectric),
// with Smith's masking and shadowing height-correlated: Heitz, "Understanding the Masking-Shadowing Function in
// Microfacet-Based BRDFs", 2014; Khronos, "KHR_lights_punctual", 2018; and the 2007 system's own formula (`phong`).
#pragma once

#include "scene/scene.h"

typedef enum OracleModel { ORACLE_PBR, ORACLE_PHONG } OracleModel;

// A material at a point, textures and vertex colours multiplied in.
typedef struct OracleSurface {
  Vec3 base;
  double alpha, metallic, roughness;
  Vec3 emission;
  double occlusion;  // of environment diffuse; 1 is open
  bool unlit;
} OracleSurface;

// Roughness 0: reflects the scene and shows no highlight of a light.
bool oracle_is_mirror(const OracleSurface *surface);

// BRDF towards view `v` of light from `l`; n, v and l are unit vectors. Zero for l below n. n.v counts by its absolute
// value, as in glTF's appendix.
typedef struct OracleBrdf {
  Vec3 diffuse, specular;  // 1 / sr
} OracleBrdf;
OracleBrdf oracle_brdf(OracleModel model, const OracleSurface *surface, Vec3 n, Vec3 v, Vec3 l);

// Weight of a mirror's reflection: Schlick's F at N.V (pbr), ks (phong).
Vec3 oracle_reflectance(OracleModel model, const OracleSurface *surface, double n_dot_v);

// What leaves without a light: emission, and A base in phong; the base colour where the material is unlit.
Vec3 oracle_own_light(OracleModel model, const OracleSurface *surface, double ambient);

// A light seen from a point.
typedef struct OracleArrival {
  Vec3 direction;     // unit, towards the light
  double distance_m;  // INFINITY for directional
  Vec3 irradiance;    // on a plane that faces the light, falloff and cone included
} OracleArrival;
OracleArrival oracle_light_at(const Light *light, Vec3 position_world);

// f x E x max(0, N.L), without visibility; 0 where the light is behind the geometric normal (which faces the viewer).
Vec3 oracle_direct(OracleModel model, const OracleSurface *surface, Vec3 n, Vec3 geometric, Vec3 v,
                   const OracleArrival *arrival);

// Trowbridge and Reitz's distribution (GGX) at alpha = roughness^2, and the visibility G / (4 N.L N.V).
double oracle_ggx(double n_dot_h, double alpha);
double oracle_smith(double n_dot_l, double n_dot_v, double alpha);

// Cosine to the normal of the half vector at `share` (0..1) of the model's distribution, and the density there, 1 / sr.
double oracle_half_vector(OracleModel model, const OracleSurface *surface, double share, double *density);

// Directional albedo: the integral of f N.L over the hemisphere for a view at n_dot_v (white furnace), by midpoints in
// the distribution of half vectors and, for diffuse, of cosine. `cells`^2 points; 512 gives about 1e-4. A mirror's
// specular part is its reflectance. Where l has no share (below the plane), energy is lost as in the BRDF itself.
OracleBrdf oracle_albedo(OracleModel model, const OracleSurface *surface, double n_dot_v, int cells);
