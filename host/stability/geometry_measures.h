// How the rows of geometry_rows.c are measured; the method is SHADOWS_RAYS or of no account. The point's value is the
// row's parameter, named there.
#pragma once

#include "stability/stability.h"

// geometry_coverage.c: is every sample seen once, by raster and by rays?
Status measure_slivers(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_coplanar(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_coplanar_twins(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_shared_edges(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_fan(StabilityPoint *point, Lab *lab, ShadowMethod method);

// geometry_rounding.c: what rounding does far from the origin, and at other scales.
Status measure_self_hits(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_contact(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_scale(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_move(StabilityPoint *point, Lab *lab, ShadowMethod method);

// geometry_input.c: transforms and numbers as files may hold them.
Status measure_poison(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_mirrored(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_stretched(StabilityPoint *point, Lab *lab, ShadowMethod method);
Status measure_planner_flicker(StabilityPoint *point, Lab *lab, ShadowMethod method);
