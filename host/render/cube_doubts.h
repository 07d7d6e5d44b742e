// What a cube map may show wrong, for hybrid reflections.
#pragma once

#include "render/frame.h"

// Fills the doubts of a cube (shared/cube.h) whose texels are drawn and which frame->cube_capture is aimed at, while
// the frame is capturing: what its texels show is shaded once more as seen from DOUBT_EYES places beside the centre, as
// far off as the reflector reaches, without shadows. Cost: a ray a texel, and shading 1 + DOUBT_EYES times.
enum { DOUBT_EYES = 3 };
Status cube_doubts_draw(Frame *frame, const CubeDoubt *doubt, const CubeInfo *cube, Log *log);
