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

// The direction of texel (x, y) of the tall picture of faces of size x size texels, its longest component 1.
static inline float3 face_direction(uint size, uint2 pixel)
{
  uint face = pixel.y / size;
  float step = 2.0f / (float)(size - 1);
  float a = (float)pixel.x * step - 1, b = (float)(pixel.y - face * size) * step - 1, s = face & 1 ? -1 : 1;
  return face < 2 ? (float3)(s, a, b) : face < 4 ? (float3)(b, s, a) : (float3)(a, b, s);
}

// Where a direction of any length but 0 points, on faces of size x size texels that begin at first_texel.
static inline CubePlace faces_place(uint size_px, uint first_texel, float3 d)
{
  float3 size = fabs(d);
  bool along_x = size.x >= size.y && size.x >= size.z, along_y = !along_x && size.y >= size.z;
  float major = along_x ? d.x : along_y ? d.y : d.z;
  float a = along_x ? d.y : along_y ? d.z : d.x, b = along_x ? d.z : along_y ? d.x : d.y;
  uint face = (along_x ? 0 : along_y ? 2 : 4) + (major < 0);
  float half_last = 0.5f * (float)(size_px - 1);
  CubePlace place;
  place.major = fabs(major);
  float x = (a / place.major + 1) * half_last, y = (b / place.major + 1) * half_last;
  uint column = min((uint)max(x, 0.0f), size_px - 2), row = min((uint)max(y, 0.0f), size_px - 2);
  place.across = x - (float)column;
  place.down = y - (float)row;
  place.size = size_px;
  uint across_cells = size_px / CUBE_CELL;
  place.cell = first_texel / (CUBE_CELL * CUBE_CELL) + (face * across_cells + row / CUBE_CELL) * across_cells +
               column / CUBE_CELL;
  place.texel = first_texel + (face * size_px + row) * size_px + column;
  return place;
}

static inline CubePlace cube_place(global const CubeInfo *cube, float3 d)
{
  return faces_place(cube->size, cube->first_texel, d);
}

// The four texels' radiance and closeness, bilinear.
static inline float4 cube_sample(global const float4 *texels, CubePlace place)
{
  global const float4 *upper = texels + place.texel, *lower = upper + place.size;
  float4 above = upper[0] + (upper[1] - upper[0]) * place.across;
  float4 below = lower[0] + (lower[1] - lower[0]) * place.across;
  return above + (below - above) * place.down;
}

// Radiance, and 1 / distance, about a direction as a surface of that roughness reflects them; between the last level
// and the cube itself for less than the last's.
static inline float4 cube_prefiltered(global const CubeInfo *cube, global const float4 *texels,
                                      global const float4 *levels, float3 direction, float roughness)
{
  uint last = cube_level_count(cube->size) - 1;
  float level = max(-2 * log2(max(roughness, 1e-6f)), 0.0f), whole = min(floor(level), (float)last);
  uint k = (uint)whole;
  float share = k < last ? level - whole : 1 - roughness * roughness * exp2(whole);
  float3 unit = normalize(direction);
  CubePlace place =
      faces_place(cube_level_size(k, cube->size), cube->first_level + cube_level_first(k, cube->size), unit);
  float4 value = cube_sample(levels, place), next;
  if (k < last) {
    place =
        faces_place(cube_level_size(k + 1, cube->size), cube->first_level + cube_level_first(k + 1, cube->size), unit);
    next = cube_sample(levels, place);
  } else {
    place = cube_place(cube, unit);
    next = cube_sample(texels, place);
    next.w *= place.major;
  }
  return mix(value, next, share);
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
