// What a light's shadows cost by rays and by hybrid maps, and which to take. No OpenCL.
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef struct ShadowCostFacts {
  uint64_t triangles, pixels;
  uint32_t samples;  // a pixel
  uint32_t maps;     // that hybrid shadows draw of the light: 1 of a spot light, 4 of a directional one, 6 of a point
  bool gpu;
} ShadowCostFacts;

// Milliseconds of one picture; hybrid: its maps drawn for it alone.
typedef struct ShadowCost {
  double rays_ms, hybrid_ms;
} ShadowCost;

// A pure function of the facts: models fitted to measurements, never the clock of the moment.
ShadowCost shadow_cost(const ShadowCostFacts *facts);

// Is hybrid clearly the quicker, by more than what the model may be off by?
bool shadow_hybrid_gains(const ShadowCost *cost);
