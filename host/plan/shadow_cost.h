// What a light's shadows cost by rays and by hybrid maps, and which to take. No OpenCL.
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef struct ShadowCostFacts {
  uint64_t triangles, pixels;
  uint32_t samples;  // a pixel
  uint32_t maps;     // that hybrid shadows draw of the light: 1 of a spot light, 4 of a directional one, 6 of a point
  bool gpu;
  uint32_t frames;  // of the sequence, 0 for one picture
  double kept;      // share of the light's views, in the mean, that see what they saw in the frame before
} ShadowCostFacts;

// Milliseconds of one picture; hybrid: its maps drawn for it alone; kept: they are those of the frame before, of which
// no verdict is known. Sequence: by hybrid in the mean of the frames, the first of which draws all and the second of
// which is the first to keep verdicts.
typedef struct ShadowCost {
  double rays_ms, hybrid_ms, kept_ms, sequence_ms;
} ShadowCost;

// A pure function of the facts: models fitted to measurements, never the clock of the moment.
ShadowCost shadow_cost(const ShadowCostFacts *facts);

// Is hybrid so much quicker in the mean of the sequence that it is to be taken?
bool shadow_hybrid_gains(const ShadowCost *cost);
