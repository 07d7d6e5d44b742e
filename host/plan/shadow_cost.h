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

// Milliseconds of one picture; hybrid: its maps drawn for it alone; kept: they are those of the frame before. From the
// next frame on, where verdicts are kept too, a CPU takes a third of that.
typedef struct ShadowCost {
  double rays_ms, hybrid_ms, kept_ms;
} ShadowCost;

// A pure function of the facts: models fitted to measurements, never the clock of the moment.
ShadowCost shadow_cost(const ShadowCostFacts *facts);

// Is hybrid so much quicker for a single picture that it is to be taken? That maps may be kept does not count: a plan
// is made before it is known what of the next frames moves.
bool shadow_hybrid_gains(const ShadowCost *cost);
