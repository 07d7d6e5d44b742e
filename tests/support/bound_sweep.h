// Random mirrors in random rooms: is the error that a rung states before rendering that of the picture?
#pragma once

#include "plan/plan.h"

// Fails unless the bound covers what is measured in all pictures but 1 %, and one, and is within 4 times of it in the
// median. FRUGAL_SHOW_CASES prints each. So many pictures, a quarter of that by quick effort, 480 in full.
void bound_sweep(ReflectionMethod method, uint32_t samples, int usual_count);

// The same of a rung that expects no error, and states no more than `bound_most`: covered in all pictures but 1 %.
void bound_sweep_exact(ReflectionMethod method, double bound_most, int usual_count);

// The same of rough surfaces by each of the rungs up to the impostor, against many samples of their lobes.
void bound_sweep_rough(int usual_count);
