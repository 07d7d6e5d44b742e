// How wrong maps make what rough surfaces reflect, told before the picture is rendered.
#pragma once

#include "render/reflection_bound.h"

// Adds to `sums`, by object, the pixels that rough surfaces make wrong by each rung: those of about ROUGH_PROBES
// pixels, each of which stands for as many of `probes` as there are more of these.
//
// At each probe ROUGH_SAMPLES rays are sent along the lobe, and followed as the picture of rays would. Their mean is
// what is right. What a map shows is the mean of the same radiances by other weights: the map's lobe, round about its
// axis a' and of width alpha', as it is seen from the cube's centre C,
//
//   w_j = K(a' . d_j) (t_j / |C H_j|)^2 / p_j,   K(c) = c / (1 + (alpha'^2 - 1) (1 + c) / 2)^2,
//
// d_j the direction of what the j-th ray meets at H_j, from C; p_j the density with which the ray was chosen; the
// square the solid angle that a part of the surface there has from C over that which it has from the probe, but for its
// slant. So an object that is eps off as seen from C makes an error of about eps over the lobe's width, times what
// differs between the two ends of the lobe: a lobe forgives parallax, a narrow one as little as a mirror. The same
// weights hold what the split sum takes a lobe for (the eye at its normal, uncut at the horizon), and how levels are
// interpolated: the two of them are weighed one by one. Cube: a' the axis of the probe's lobe; box: where it leaves the
// box; impostor: where the nearest ray ended; of these two alpha' = alpha t / D. The environment's part is what its
// levels show there. A pixel is wrong where that differs by more than 2/255 in a displayed channel, also by a standard
// error of the mean of the weighted samples, and of the part of the lobe that is under the horizon, of which no ray
// tells.
//
// Over 60 pictures of rough balls, sheets and cans (tests/test_reflection_bound.c) none was beyond what is stated;
// stated over measured is 1.5 in the median for the environment, 2.3 to 2.7 for cubes, up to 12 for dielectrics.
//
// Fails where the map's lobe sees what no ray of the probe met: behind the reflector, or beside a narrow lobe from far
// beside the centre (fewer than ROUGH_LEAST samples' worth of weights: the pixel is taken for wrong); where C sees
// something else before H_j; and where lamps are so small that few rays meet them.
//
// Cost: that of ROUGH_PROBES x (ROUGH_SAMPLES + 1) pixels more by rays, and nothing where nothing rough is seen.
// Errors: those of frame_make and frame_render.
enum { ROUGH_PROBES = 1024, ROUGH_SAMPLES = 64, ROUGH_LEAST = 3 };
Status rough_bound_add(BoundSums *sums, const Frame *frame, const uint32_t *starts, double probes, float scale,
                       Log *log);
