// Verdicts of shadow rays that frames of a sequence keep: cl/lib/kept_verdicts.cl.
#pragma once

#include "passes/sure_maps.h"

// Of the hits of a picture's camera rays; slots of 0: there are none.
typedef struct KeptVerdicts {
  DeviceBuffer words;  // [VERDICT_FIELDS][slots]
  uint32_t slots;      // of the picture, sample by sample
  uint32_t stayed;     // bit SHADOW_VIEWS_MOST x light + view: what the view sees is what it saw in the frame before
} KeptVerdicts;

// Makes room for a frame's where views of the first lights stayed (SureMaps.stayed), if it takes `bytes_most` at most.
// `before`, which may be NULL, are those of the frame before, which are lost to it. Errors: those of buffer_create.
Status kept_verdicts_make(KeptVerdicts *out, KeptVerdicts *before, Device *device, const SureMaps *maps, uint64_t slots,
                          uint64_t bytes_most, Log *log);
void kept_verdicts_free(KeptVerdicts *kept);
