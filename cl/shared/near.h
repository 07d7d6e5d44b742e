// What is near the centre of a cube map, and so not in it. Written by host/render/near_objects.c, read by cl/capture.
#ifndef SHARED_NEAR_H
#define SHARED_NEAR_H

#include "shared/types.h"

// Of one cube map: its list of objects, some as a BVH over their triangles, some as snapshots.
typedef struct NearInfo {
  uint first_node, first_triangle;  // of the BVH (shared/bvh.h) among those of all cubes
  uint first_snapshot, snapshot_count;
  float change;     // mean change of the cube's radiance, in the channel where it is greatest, by radian
  float nearest_m;  // from the centre: nothing that the cube shows is nearer
  uint padding[2];
} NearInfo;
SHARED_SIZE(NearInfo, 32);

// One object seen from the centre of a cube, alone. size x size texels of radiance and closeness: 1 / distance along
// `forward`, 0 where the object is not; row by row, x to the right. The outermost texels are 0.
typedef struct SnapshotInfo {
  Float3 center;                // the cube's, world space
  Float3 right, down, forward;  // unit vectors
  Float3 low, high;             // bounds of the object, relative to the centre
  float left, top;              // of the first texel's centre: right and down for 1 forward
  float texels;                 // for 1 right or down and 1 forward
  float texels_rad;             // no fewer than pass by in a radian's turn, on average of the picture
  float beyond_m;               // forward: behind the object
  uint size;                    // texels a side, a multiple of 8
  uint first_texel;             // among those of all snapshots
  uint object;
} SnapshotInfo;
SHARED_SIZE(SnapshotInfo, 104);

// Besides, by texel: the closeness of the object's farthest surface, SNAPSHOT_NO_BACK where the object is not; below 0
// where what is seen of it first is the open side of a single-sided surface, which shows something else.
#define SNAPSHOT_NO_BACK 1e30f

// Counters of what became of reflected rays.
#define NEAR_LEFT 0u             // to be traced
#define NEAR_LISTED 1u           // met a triangle of the list
#define NEAR_FAILED_CUBE 2u      // left, for the cube could not tell
#define NEAR_FAILED_SNAPSHOT 3u  // left, for a snapshot could not
#define NEAR_COUNTS 4

#endif
