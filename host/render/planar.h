// Which flat mirrors have a picture of their own.
#pragma once

#include "render/frame.h"
#include "render/reflector_shape.h"

// A mirror of which most that is seen lies in a plane.
typedef struct FlatMirror {
  uint32_t object;
  MirrorPlane plane;
} FlatMirror;

// Draws what the first of `count` mirrors show (passes/planar.h), mirrors in one plane together, once everything else
// of the frame is there; up to PLANES_MOST planes, and as many as fit into plan->cubes.max_bytes. The others are
// traced, with a warning; so is what is not flat, and all that deeper bounces reflect.
//
// Errors: those of rendering; STATUS_NO_MEMORY.
Status planar_prepare(Frame *frame, const FlatMirror *mirrors, uint32_t count, Log *log);
