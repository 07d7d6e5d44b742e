// Radiance from infinitely far away, and the irradiance it gives, in double precision.
#pragma once

#include "scene/scene.h"

// Radiance that arrives from a unit direction, in world space: intensity, and the turn about +Y (counter-clockwise seen
// from above) included. Images are filtered bilinearly, wrapping in u, held at the edge in v.
Vec3 oracle_environment(const Environment *environment, Vec3 direction_world);

// The sphere of directions cut into cells of equal solid angle, each with the flux of its radiance.
typedef struct OracleDome {
  Vec3 (*cells)[2];  // unit direction, radiance x solid angle
  uint32_t cell_count;
} OracleDome;

// 2 rows^2 cells, each the mean of `inner`^2 points. The irradiance of 128 rows is good to about 1e-4.
OracleDome oracle_dome_make(const Environment *environment, uint32_t rows, uint32_t inner);
void oracle_dome_free(OracleDome *dome);

// Unoccluded irradiance on a plane with this unit normal.
Vec3 oracle_dome_irradiance(const OracleDome *dome, Vec3 normal_world);
