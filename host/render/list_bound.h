// How wrong the rungs beyond the impostor make what mirrors show, told before the picture is rendered: those that ask
// lists of what is near, and those that are exact. Part of render/reflection_bound.h, whose probes they share.
#pragma once

#include "plan/near_list.h"
#include "render/reflection_bound.h"

// What is near each reflector, and how its snapshots' texels compare with those of its cube.
typedef struct ListBound {
  NearList *lists;  // [object_count], by reflector; empty where the probes saw none
  double **texels;  // of each object of a list: a snapshot's texel in texels of the cube
  uint32_t object_count, complex_from;
} ListBound;

// A probe and a neighbour: what the impostor's texels smear between both.
typedef struct ProbeEdge {
  bool is_there;            // the neighbour shows the same reflector
  double weight;            // edges between them, by pixel; 0: none
  double change;            // displayed, to the next pixel, where there is none
  double own_px, other_px;  // by which what the probe sees is smeared towards the neighbour, and what that sees
  bool outline;             // what they see stands behind each other
  uint32_t met;             // object that the neighbour's ray meets; LIST_MET_NOTHING
} ProbeEdge;

#define LIST_MET_NOTHING 0xffffffffu

// `cubes`: [object_count], those of size 0 are not seen. On failure *out is to be freed too. Errors: STATUS_NO_MEMORY.
Status list_bound_make(ListBound *out, const Frame *frame, const CubeInfo *cubes, Log *log);
void list_bound_free(ListBound *bound);

// Pixels that a probe finds wrong, for the rungs from BOUND_SNAPSHOT on; `met` is the object that its own ray meets.
//
//   candidates  what is listed is found by rays, and so is the edge between it and what is not: nothing is wrong there.
//               Where the probe and its neighbour both see what is left in the cube: as the impostor
//   snapshot    likewise, but a listed object that can be photographed shows the texels of its snapshot: within one
//               object the impostor's smear times the snapshot's texel in texels of the cube. Its outline is traced but
//               for a share, as that of the impostor. What cannot be photographed is found by rays
//   mixed       as snapshot for objects of complex_from triangles or more, else as candidates
//   planar, hybrid   nothing: both meet what rays meet. A cube's texels answer hybrid rays only where they are off by
//               no more than half of what is seen; EXACT_SHARE is for the rest of both
//
// Fails as the impostor's where surfaces look different from the centre; where memory leaves objects out of lists.
void list_bound_wrong(double wrong[BOUND_RUNGS], const ListBound *bound, uint32_t reflector, uint32_t met,
                      const ProbeEdge *edges, int edge_count, double outline_share, double threshold);

// The bound that a rung from BOUND_SNAPSHOT on states, from what the probes say and the share of the pixels that show
// reflectors. Outlines of what is photographed are few and thin beside the probes: with snapshots it is PHOTO_FACTOR of
// that, and PHOTO_SHARE of the pixels more, both found by trial.
double list_bound_stated(int rung, double bound, double share);
#define PHOTO_FACTOR 1.25
#define PHOTO_SHARE 1.5e-3

// Of the pixels that show reflectors, what rounding leaves: it turns over which of two things is nearer, or hides a
// shadow's tip between texels. Measured: none of 157 048 (room) and of 26 602 (chrome), one sample a pixel; one or none
// of 11 000 with 16.
#define EXACT_SHARE 1e-4
