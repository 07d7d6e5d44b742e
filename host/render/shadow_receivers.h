// Which parts of hybrid shadows' maps a picture asks.
#pragma once

#include "render/frame.h"

// Marks, by the shadow rays of one pixel in each 8 x 8, where the frame's receivers are on the lights' maps, what
// mirrors show of them included, and draws the maps there. Errors: STATUS_DEVICE, those of buffer_create.
Status shadow_receivers_prepare(Frame *frame, Log *log);
