// Which faces of a cube map show anything on which lights shine.
//
//   in    center, size, first_texel   of the cube
//         texels                      of all cubes (shared/cube.h): closeness tells where what they show is
//         lights                      [light_count]
//         slack_m                     what rounding may do to a place
//   out   faces                       0 before; bit f is set where face f shows a place to which a light of these comes
//                                     unless something stands before it: within its range and its cone
//
//   Cost  light_count lights a texel, 4 bytes read.
//   Fails where texels let through what is behind them: BLEND. Surfaces that face away from a light count.

#include "lib/cube.cl"
#include "lib/lanes.cl"
#include "shared/scene.h"

#define COSINE_SLACK 1e-5f
#define RANGE_SLACK 1.0001f

// True where that is not sure.
static inline bool light_may_shine(global const LightInfo *light, float3 at, float slack_m)
{
  float x = at.x - light->position.x, y = at.y - light->position.y, z = at.z - light->position.z;
  float along = x * light->direction.x + y * light->direction.y + z * light->direction.z;
  float away = sqrt(x * x + y * y + z * z), slack = COSINE_SLACK + slack_m / away;
  bool shines = light->radiant.x > 0 || light->radiant.y > 0 || light->radiant.z > 0;
  bool beyond = away > light->range_m * RANGE_SLACK + slack_m;
  bool aside = (along / away + slack) * light->spot_scale + light->spot_offset <= 0;
  if (light->kind == LIGHT_KIND_DIRECTIONAL || !shines) return shines;
  return !beyond && !(light->kind == LIGHT_KIND_SPOT && aside);
}

kernel void cube_lit(float center_x, float center_y, float center_z, uint size, uint first_texel,
                     global const float4 *texels, global const LightInfo *lights, uint light_count, float slack_m,
                     global uint *faces)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM, end = min(begin + RAYS_PER_ITEM, CUBE_TEXELS(size)), lit = 0;
  for (uint i = begin; i < end; i++) {
    float closeness = texels[first_texel + i].w;
    uint2 pixel = (uint2)(i % size, i / size);
    uint face = 1u << (pixel.y / size);
    if ((lit & face) || closeness == 0) continue;
    float3 at = (float3)(center_x, center_y, center_z) + face_direction(size, pixel) / closeness;
    for (uint k = 0; k < light_count; k++)
      if (light_may_shine(&lights[k], at, slack_m)) lit |= face;
  }
  if (lit) atomic_or(faces, lit);
}
