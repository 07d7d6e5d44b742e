// Ray and hit streams: structures of arrays, field f of ray i at [f * capacity + i]. Written by ray_generate and shade,
// read by the trace kernels.
#ifndef SHARED_STREAM_H
#define SHARED_STREAM_H

#include "shared/types.h"

// A ray is the segment origin + t * direction, t_min < t <= t_max; the direction is not of unit length: camera rays
// have t = depth along the view axis, shadow rays t = 1 at the light. A ray with t_max < 0 is inactive and hits
// nothing; a shadow ray with t_max = 0 is known to arrive, and is not traced.
enum RayField {
  RAY_ORIGIN_X,
  RAY_ORIGIN_Y,
  RAY_ORIGIN_Z,
  RAY_DIRECTION_X,
  RAY_DIRECTION_Y,
  RAY_DIRECTION_Z,
  RAY_T_MAX,     // of rays that stand for what a rough surface reflects (RAY_FROM_MIRROR): its roughness, 1 at most
  RAY_WEIGHT_R,  // camera and reflected rays: throughput; shadow rays: the radiance that arrives if nothing blocks
  RAY_WEIGHT_G,
  RAY_WEIGHT_B,
  // In streams of reflected rays, where rough surfaces reflect: the density, 1 / sr, with which the surface chose the
  // direction among those that it samples; INFINITY where it had no choice (mirrors).
  // Where maps may answer reflected rays, of those that mirrors reflect, or that maps answer for rough surfaces: the
  // bits of the id of the triangle that the ray starts on, with RAY_FROM_MIRROR.
  RAY_DENSITY,
  // In streams of shadow rays, where maps are doubted: the bits of the id of the triangle that the ray starts on.
  RAY_RECEIVER = RAY_DENSITY,
  RAY_FIELD_COUNT
};

#define RAY_FROM_MIRROR 0x80000000u

enum HitField {
  HIT_T,  // this and the others are undefined where the id is HIT_NONE
  HIT_U,  // barycentric weight of vertex 1
  HIT_V,  // barycentric weight of vertex 2
  HIT_FIELD_COUNT
};

// Besides its fields, a stream has one uint a ray: the slot of the wave whose radiance it adds to; a hit stream: the
// triangle's id.
#define HIT_NONE 0xffffffffu

// A wave is a range of 8 x 8 pixel tiles times a range of samples. Slots run tile by tile, then sample by sample; in a
// tile, 4 x 4 blocks of pixels follow each other, so that 16 neighbouring slots are a compact block on screen. The
// picture's tiles are numbered by bins of BIN_TILES x BIN_TILES, bins and tiles within them row by row; bins at its
// right and lower edge hold fewer.
#define TILE_SIZE 8
#define TILE_PIXELS 64
#define BIN_TILES 8

#endif
