// Sample positions within a pixel.
#pragma once

#include <stdint.h>

// Writes the first `count` positions, x and y in [0, 1) from the pixel's top left: 1 is the centre; 2, 4, 8 and 16 are
// the standard multisample patterns of Direct3D and Vulkan; other counts the first points of Halton (2, 3).
void sample_pattern(float (*out)[2], uint32_t count);
