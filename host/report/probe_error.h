// How far a picture is from the right one at probes, in the project's currency: the share of pixels off by more than
// IMAGE_THRESHOLD in any displayed channel.
#pragma once

#include "plan/probes.h"
#include "report/proportion.h"

// A pixel that is off is too dark or too light by the mean of R, G and B.
typedef struct ProbeError {
  uint64_t pixels;  // looked at
  Proportion off, dark, light;
} ProbeError;

// Pictures: [height][width][4], as displayed, in [0, 1]. What is not finite is off. Errors: STATUS_NO_MEMORY.
Status probe_error_make(ProbeError *out, const float *picture, const float *reference, uint32_t width,
                        const ProbeSet *set, Log *log);
