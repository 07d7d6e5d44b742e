// How the rows of shadow_rows.c are measured. The point's value is the row's parameter, named there.
#pragma once

#include "stability/stability.h"

// shadow_surfaces.c: what a map does to the surfaces that it was drawn from.
Status measure_acne(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_peter_panning(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_fold(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_bleeding(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_zero_size(StabilityPoint *point, Lab *lab, ShadowMethod method);

// shadow_projection.c: where a map looks.
Status measure_frustum_edge(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_depth_range(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_near_caster(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_light_in_view(StabilityPoint *point, Lab *lab, ShadowMethod method);

// shadow_sampling.c: how finely it looks.
Status measure_perspective_aliasing(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_projective_aliasing(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_shimmer(StabilityPoint *point, Lab *lab, ShadowMethod method);

// Texels from an edge within which a method may be wrong: half a texel's diagonal, half a kernel more. 0 where it asks
// rays.
double shadow_reach_texels(ShadowMethod method, uint32_t kernel_px);
