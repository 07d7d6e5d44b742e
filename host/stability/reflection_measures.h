// How the rows of reflection_rows.c are measured, each by the rung that it names; the shadows' method is of no account.
// The point's value is the row's parameter, named there.
#pragma once

#include "stability/stability.h"

Status measure_cube_parallax(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_impostor_parallax(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_cube_seam(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_self_reflection(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_bounds_crossing(StabilityPoint *point, Lab *lab, ShadowMethod method);

// reflection_near.c
Status measure_radius_crossing(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_snapshot_disocclusion(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_reflection_occluder(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_snapshot_overflow(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_facing_mirrors(StabilityPoint *point, Lab *lab, ShadowMethod method);

// reflection_rough.c
Status measure_roughness(StabilityPoint *point, Lab *lab, ShadowMethod method);
