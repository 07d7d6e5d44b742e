// How far a picture is from the right one at probes, in the project's currency: the share of pixels off by more than
// IMAGE_THRESHOLD in any displayed channel.
#pragma once

#include <stdbool.h>

#include "plan/probes.h"
#include "report/proportion.h"

// A pixel that is off is too dark or too light by the mean of R, G and B.
typedef struct ProbeError {
  uint64_t pixels;  // looked at
  Proportion off, dark, light;
} ProbeError;

// Pictures: [height][width][4], as displayed, in [0, 1]. What is not finite is off. `counted`, [height][width]: which
// pixels are looked at; NULL: all. Errors: STATUS_NO_MEMORY.
Status probe_error_make(ProbeError *out, const float *picture, const float *reference, const bool *counted,
                        uint32_t width, const ProbeSet *set, Log *log);

// Which pixels are at the edge of a shadow, of those in the probes: where the share of the direct light that arrives,
// `lit` [height][width], differs by more than PROBE_EDGE from that of one of the eight neighbours in the same tile. So
// do half-shadows up to 50 pixels wide, and the outlines of what is lit before what is not.
#define PROBE_EDGE 0.02f
void probe_edges(bool *out, const float *lit, uint32_t width, const ProbeSet *set);
