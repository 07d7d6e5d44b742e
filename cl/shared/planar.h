// A flat mirror and the camera behind it. Written by host/render/planar.c, read by cl/capture/planar.cl.
#ifndef SHARED_PLANAR_H
#define SHARED_PLANAR_H

#include "shared/types.h"

typedef struct PlanarInfo {
  Float3 normal;                  // unit, on the side that reflects; world space
  float offset_m;                 // the mirror is where dot(normal, p) = offset_m
  Float3 eye, forward;            // of the mirrored camera
  float slack_m;                  // what rounding makes of a point in the plane
  uint parallel;                  // projection: rays go along `forward`
  uint tiles_per_row, tile_rows;  // of the picture
} PlanarInfo;
SHARED_SIZE(PlanarInfo, 56);

#define PLANE_NONE 0xffffffffu  // of an object: it has no picture

#endif
