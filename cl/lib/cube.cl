// Texels of a cube map by direction (shared/cube.h).

#include "shared/cube.h"

// A place between four texels of a face.
typedef struct CubePlace {
  uint texel;          // the first of them, among those of all cubes
  uint size;           // texels to the next row
  uint cell;           // among the cells of all cubes
  float across, down;  // towards the second column and row, 0..1
  float major;         // the direction's component along the face's axis, its magnitude
} CubePlace;

// Where a direction of any length but 0 points.
static inline CubePlace cube_place(global const CubeInfo *cube, float3 d)
{
  float3 size = fabs(d);
  bool along_x = size.x >= size.y && size.x >= size.z, along_y = !along_x && size.y >= size.z;
  float major = along_x ? d.x : along_y ? d.y : d.z;
  float a = along_x ? d.y : along_y ? d.z : d.x, b = along_x ? d.z : along_y ? d.x : d.y;
  uint face = (along_x ? 0 : along_y ? 2 : 4) + (major < 0);
  float half_last = 0.5f * (float)(cube->size - 1);
  CubePlace place;
  place.major = fabs(major);
  float x = (a / place.major + 1) * half_last, y = (b / place.major + 1) * half_last;
  uint column = min((uint)max(x, 0.0f), cube->size - 2), row = min((uint)max(y, 0.0f), cube->size - 2);
  place.across = x - (float)column;
  place.down = y - (float)row;
  place.size = cube->size;
  uint across_cells = cube->size / CUBE_CELL;
  place.cell = cube->first_texel / (CUBE_CELL * CUBE_CELL) + (face * across_cells + row / CUBE_CELL) * across_cells +
               column / CUBE_CELL;
  place.texel = cube->first_texel + (face * cube->size + row) * cube->size + column;
  return place;
}

// The four texels' radiance and closeness, bilinear.
static inline float4 cube_sample(global const float4 *texels, CubePlace place)
{
  global const float4 *upper = texels + place.texel, *lower = upper + place.size;
  float4 above = upper[0] + (upper[1] - upper[0]) * place.across;
  float4 below = lower[0] + (lower[1] - lower[0]) * place.across;
  return above + (below - above) * place.down;
}

// Closeness alone: bilinear, and the least and the most of the four texels.
typedef struct CubeDepth {
  float here, least, most;
} CubeDepth;

static inline CubeDepth cube_depth(global const float4 *texels, CubePlace place)
{
  global const float4 *upper = texels + place.texel, *lower = upper + place.size;
  float a = upper[0].w, b = upper[1].w, c = lower[0].w, d = lower[1].w;
  float above = a + (b - a) * place.across, below = c + (d - c) * place.across;
  CubeDepth depth = {above + (below - above) * place.down, min(min(a, b), min(c, d)), max(max(a, b), max(c, d))};
  return depth;
}

// Is a point of that closeness under the reflector's outermost surface, by more than `slack` of the distance? Where
// only some of the four texels show the reflector, under the farthest of them.
static inline bool hull_holds(global const float *hull, CubePlace place, float closeness, float slack)
{
  global const float *upper = hull + place.texel, *lower = upper + place.size;
  float least = min(min(upper[0], upper[1]), min(lower[0], lower[1]));
  float most = max(max(upper[0], upper[1]), max(lower[0], lower[1]));
  float above = upper[0] + (upper[1] - upper[0]) * place.across,
        below = lower[0] + (lower[1] - lower[0]) * place.across;
  float surface = most < CUBE_NO_HULL ? above + (below - above) * place.down : least;
  return closeness > surface * (1 + slack);
}

// A ray relative to a cube's centre.
typedef struct CubeRay {
  float3 origin, direction;  // the direction is of unit length
} CubeRay;

// The direction in which a ray leaves the cube's box. False where it starts outside.
static inline bool box_direction(float3 *out, global const CubeInfo *cube, CubeRay ray)
{
  float3 low = (float3)(cube->low.x, cube->low.y, cube->low.z);
  float3 high = (float3)(cube->high.x, cube->high.y, cube->high.z);
  if (any(ray.origin < low) || any(ray.origin > high)) return false;
  float3 wall = (float3)(ray.direction.x > 0 ? high.x : low.x, ray.direction.y > 0 ? high.y : low.y,
                         ray.direction.z > 0 ? high.z : low.z);
  float3 t = (wall - ray.origin) / ray.direction;
  float nearest = INFINITY;  // t of a component that does not move is infinite, or no number
  nearest = t.x < nearest ? t.x : nearest;
  nearest = t.y < nearest ? t.y : nearest;
  nearest = t.z < nearest ? t.z : nearest;
  *out = nearest < INFINITY ? ray.origin + nearest * ray.direction : ray.direction;
  return dot(*out, *out) > 0;
}
