// Radiance from infinitely far away, and the light it gives, in double precision.
#pragma once

#include "support/oracle_shade.h"

// Radiance that arrives from a unit direction, in world space: intensity, and the turn about +Y (counter-clockwise seen
// from above) included. Images are filtered bilinearly, wrapping in u, held at the edge in v.
Vec3 oracle_environment(const Environment *environment, Vec3 direction_world);

// The sphere of directions cut into cells of equal solid angle, each with the flux of its radiance.
typedef struct OracleDome {
  Vec3 (*cells)[2];  // unit direction, radiance x solid angle
  uint32_t cell_count;
} OracleDome;

// 2 rows^2 cells, each the mean of `inner`^2 points. The irradiance of 48 rows is good to about 1e-3.
OracleDome oracle_dome_make(const Environment *environment, uint32_t rows, uint32_t inner);
void oracle_dome_free(OracleDome *dome);

// What a surface sends to the view `v` of the environment's light, as if nothing stood in its way: the integral of the
// BRDF x radiance, diffuse over the dome, specular at 24^2 half vectors. 0 for phong, whose ambient term stands in for
// it, and for what is unlit; mirrors have no specular part: they reflect rays.
Vec3 oracle_environment_light(const Environment *environment, const OracleDome *dome, OracleModel model,
                              const OracleSurface *surface, Vec3 n, Vec3 v);
