// Texels of a cube map by direction (shared/cube.h).

#include "shared/cube.h"

// A place between four texels of a face.
typedef struct CubePlace {
  uint texel;          // the first of them, among those of all cubes
  uint size;           // texels to the next row
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

// Closeness alone.
static inline float cube_closeness(global const float4 *texels, CubePlace place)
{
  global const float4 *upper = texels + place.texel, *lower = upper + place.size;
  float above = upper[0].w + (upper[1].w - upper[0].w) * place.across;
  float below = lower[0].w + (lower[1].w - lower[0].w) * place.across;
  return above + (below - above) * place.down;
}

// Least over greatest closeness of the four texels: far from 1 where they show more than one surface.
static inline float cube_evenness(global const float4 *texels, CubePlace place)
{
  global const float4 *upper = texels + place.texel, *lower = upper + place.size;
  float least = min(min(upper[0].w, upper[1].w), min(lower[0].w, lower[1].w));
  float most = max(max(upper[0].w, upper[1].w), max(lower[0].w, lower[1].w));
  return most > 0 ? least / most : 1;
}

// Is a point of that closeness under the reflector's outermost surface, by more than `slack` of the distance? Where only
// some of the four texels show the reflector, under the farthest of them.
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
