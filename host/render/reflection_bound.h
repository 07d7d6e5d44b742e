// How wrong maps make what mirrors show, told before the picture is rendered.
#pragma once

#include "render/frame.h"
#include "shared/cube.h"

// Rungs of which it is told.
// In the order of ReflectionMethod from REFLECTIONS_ENVIRONMENT on.
typedef enum BoundRung {
  BOUND_ENVIRONMENT,
  BOUND_CUBE,
  BOUND_BOX,
  BOUND_IMPOSTOR,
  BOUND_SNAPSHOT,  // from here on render/list_bound.h
  BOUND_PLANAR,
  BOUND_CANDIDATES,
  BOUND_MIXED,
  BOUND_HYBRID,
  BOUND_RUNGS
} BoundRung;

// Share of the picture's pixels that are off by more than 2/255 in some displayed channel.
typedef struct BoundShare {
  double expected, bound;
} BoundShare;

typedef struct ReflectorBound {
  uint32_t object;
  double share;  // of the picture's pixels that show it
  BoundShare rungs[BOUND_RUNGS];
} ReflectorBound;

typedef struct ReflectionBound {
  ReflectorBound *reflectors;  // [count], by object: those that the probes saw
  uint32_t count;
  uint64_t probes;
  BoundShare rungs[BOUND_RUNGS];  // of all of them
} ReflectionBound;

// Sums over probes, of one reflector.
typedef struct BoundSums {
  double shown, wrong[BOUND_RUNGS], squares[BOUND_RUNGS];
} BoundSums;

// From the cube's centre to where a ray leaves its box; the ray's direction where it starts outside. `at` is relative
// to the centre.
Vec3 cube_box_end(const CubeInfo *cube, Vec3 at, Vec3 direction);

// What a linear value is on a display.
double displayed(double linear);

// Sends the camera's rays through about BOUND_PROBES pixels in place of all, and through the next to the right and
// below of each, reflects them by rays, and asks of each reflected ray how far off a map would show what it meets:
//
//   eps     as seen from the cube's centre, from what the ray meets to what the map shows. Cube: the ray's own
//           direction, which is sin(eps) = (o / D) sin(phi) off (plan/cube_error.h); box: where the ray leaves the box;
//           impostor: nothing, as its march ends within a hundredth of a texel
//   shift   pixels to the right and down by which the picture so moves: eps is solved for in the steps that the
//           reflected ray takes from the probe to its two neighbours, whatever the mirror's curvature. A texel more,
//           times 0.8: an edge is smeared over one (map resolution; for the impostor it is all there is)
//   wrong   where the picture changes by more than 2/255 to the next pixel, an edge lies between and sweeps `shift`
//           pixels (of both sides of it the greater); elsewhere the pixel is wrong where what it changes times `shift`
//           is more than 2/255. The same is asked from block to block, where the change is not as steady as to the
//           next pixel: an edge somewhere in a block has the share of the block's width. Of a reflector the greater
//           sum counts: edges along the picture's columns are seen by all next pixels or by none, and of several edges
//           in a block one is seen. Outlines the impostor traces, but for 0.6 % (by trial). Environment: every ray
//           that meets something is wrong
//
// The mean over the probes is expected, no more than what shows the reflector; `bound` is 1.3 (expected + z s), s its
// standard error over the probes, z = 2.576 (99 %): the rest of the factor is for what is hidden from the centre, and
// was found by trial. `frame` is made; `scale` is what its radiance is multiplied by for display.
//
// What rough surfaces reflect comes on top of it, as render/rough_bound.h has it.
//
// Fails where a surface looks different from the centre: shiny ones, and other mirrors, which a map shows as they look
// from there; and where wires lie between probes.
//
// Cost: that of 5 BOUND_PROBES pixels more by rays. Errors: those of frame_make and frame_render.
enum { BOUND_PROBES = 4096 };
Status reflection_bound_make(ReflectionBound *out, const Frame *frame, float scale, Log *log);
void reflection_bound_free(ReflectionBound *bound);
