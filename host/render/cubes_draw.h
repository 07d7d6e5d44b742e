// What cube maps show.
#pragma once

#include "render/frame.h"

// Draws the cubes of frame->cubes_drawn, or what of them does not stay from the frame before, with the frame's own
// streams and shader, and what is made of them: levels, hulls and cells, doubts, snapshots. The frame is put back as it
// was. Errors: those of rendering; STATUS_NO_MEMORY.
Status cubes_draw(Frame *frame, Log *log);

// Are cubes marched through by a plan's methods?
bool cubes_are_marched(const Plan *plan);
