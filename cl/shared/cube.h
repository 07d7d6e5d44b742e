// Cube maps about reflectors. Written by host/render/reflectors.c, read by cl/capture.
#ifndef SHARED_CUBE_H
#define SHARED_CUBE_H

#include "shared/types.h"

// Faces +x, -x, +y, -y, +z, -z, each size x size texels of radiance and closeness: 1 / distance along the face's axis,
// 0 where nothing was hit. That is linear over a face wherever it shows a plane. Along a face, columns run with the
// axis after the face's own (y for x, z for y, x for z), rows with the one after that. The outermost texels' centres
// lie on the cube's edges, so that faces that meet have the same texels there.
#define CUBE_FACES 6

typedef struct CubeInfo {
  Float3 center;     // world space
  Float3 low, high;  // box that the reflector's surroundings are taken to be, relative to the centre
  float reach_m;     // of the reflector from its centre, along the axis along which that is farthest; above 0
  uint size;         // texels a side, a multiple of 8
  uint first_texel;  // of its faces among those of all cubes
  uint object;       // the reflector
  float hull_least;  // least closeness of its surface: what is farther away is outside of it; INFINITY: it is convex
  uint first_level;  // of its levels among those of all cubes; CUBE_NONE: nothing rough asks it
} CubeInfo;
SHARED_SIZE(CubeInfo, 60);

// Besides, of cubes that are marched through, unless the reflector is convex: closeness of the reflector's own
// outermost surface, CUBE_NO_HULL where it has none.
#define CUBE_NO_HULL 1e30f

// Of cubes that hybrid reflections ask, two floats by texel: how far the radiance between it and its neighbours to the
// right and below may be off by interpolation, and by how much it changes if it is seen from as far beside the centre
// as the reflector reaches; INFINITY where that may be anything. And the name of what a texel shows: a triangle's id,
// or CUBE_NAMELESS where that is nothing.
#define CUBE_NAMELESS 0x7fffffffu

// And by cells of CUBE_CELL x CUBE_CELL texels of a face, row by row: the greatest closeness of the cell and of what
// lies within CUBE_STRIDE texels of it on the face.
#define CUBE_CELL 8
#define CUBE_STRIDE 4

#define CUBE_TEXELS(size) (CUBE_FACES * (size) * (size))
#define CUBE_NONE 0xffffffffu       // of an object: it has no cube
#define CUBE_FOR_ROUGH 0x80000000u  // with the cube's number: its rough surfaces alone ask it

// And of cubes that rough surfaces ask: level k is what a surface of roughness 2^(-k / 2) reflects of the cube, the eye
// at its normal (cl/capture/cube_prefilter.cl), as faces like the cube's own; the fourth is the mean of 1 / distance.
// Level after level; three, and as many more as are coarser than the cube.
#define CUBE_LEVELS 7
#define CUBE_LEVEL_OWN_SIZE(k) ((k) < 2 ? 8 : (k) == 2 ? 16 : 2 << (k))

static inline uint cube_level_size(uint level, uint size)
{
  uint own = CUBE_LEVEL_OWN_SIZE(level);
  return own < size ? own : size;
}

static inline uint cube_level_count(uint size)
{
  uint count = 3;
  while (count < CUBE_LEVELS && CUBE_LEVEL_OWN_SIZE(count) < (int)size) count++;
  return count;
}

// Texels before a level of a cube's.
static inline uint cube_level_first(uint level, uint size)
{
  uint first = 0;
  for (uint k = 0; k < level; k++) first += CUBE_FACES * cube_level_size(k, size) * cube_level_size(k, size);
  return first;
}

// A direction about which a level is asked: in the frame of a texel's direction, which is z; its share; and the image
// of the cube that it reads, by halvings of one of a texel a face, to be rounded.
typedef struct PrefilterSample {
  float x, y, z, weight, halvings;
} PrefilterSample;
SHARED_SIZE(PrefilterSample, 20);

// What answers reflected rays.
#define REFLECT_BY_ENVIRONMENT 0u
#define REFLECT_BY_CUBE 1u
#define REFLECT_BY_BOX 2u
#define REFLECT_BY_IMPOSTOR 3u

#endif
