// The point a ray hits, as the shading models need it: interpolated attributes, textures and normal map, in double
// precision.
#pragma once

#include "support/oracle_shade.h"
#include "support/oracle_trace.h"

typedef struct OraclePoint {
  Vec3 position_world;
  Vec3 normal_world;     // shading normal: interpolated, normal-mapped, turned on the back of a double-sided triangle
  Vec3 geometric_world;  // of the triangle, on the side the ray comes from
  const Material *material;
  OracleSurface surface;
  double margin;  // as OracleHit.margin: small where a nearest-filtered texture is about to change texel
} OraclePoint;

// A hit of a scene made from a model. A normal map without tangents in the file takes the triangle's own, from its uvs.
OraclePoint oracle_surface_at(const OracleScene *scene, const OracleRay *ray, const OracleHit *hit);

// What MASK cuts (0 or 1) and BLEND stops (its alpha): an OracleCoverage.
double oracle_surface_coverage(const OracleScene *scene, uint32_t triangle, double u, double v, double *margin);

// Four channels of a texture at (u, v), v = 0 at the top, level 0, texel centres at (i + 1/2) / size. With `srgb`
// colour becomes linear texel by texel, before the filter. Lowers *margin near the border of a nearest-filtered texel.
void oracle_texture_at(double out[4], const Scene *model, int texture, double u, double v, bool srgb, double *margin);
