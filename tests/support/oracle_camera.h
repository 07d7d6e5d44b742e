// Camera rays and sample patterns in double precision.
#pragma once

#include "support/oracle_trace.h"

// The ray of the point (x_px, y_px) of a picture, from its top left corner (a pixel's centre is at + 0.5). t is the
// depth along the view axis, bounded by znear and zfar; culls.
OracleRay oracle_camera_ray(const Camera *camera, uint32_t width_px, uint32_t height_px, double x_px, double y_px);

// Positions within a pixel, in [0, 1)^2 from its top left: 1 is the centre; 2, 4, 8 and 16 the standard patterns of
// Direct3D and Vulkan ("Vulkan 1.3", section Multisampling); others the points 1 to n of Halton (2, 3).
void oracle_sample_pattern(double (*out)[2], uint32_t count);
