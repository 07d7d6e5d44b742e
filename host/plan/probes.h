// Where a picture is checked: tiles of it, stratified. No OpenCL.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/log.h"

enum { PROBE_SIDE = 8 };  // pixels; a tile of shared/stream.h

// A tile of the picture, cut at its rim; `weight` is the share of the picture that it stands for.
typedef struct Probe {
  uint32_t x, y, width, height;
  double weight;
} Probe;

typedef struct ProbeSet {
  Probe *probes;
  uint32_t count;
  bool all;  // every tile, each for itself
} ProbeSet;

// About `pixels` pixels of a picture of width x height, in as many tiles as hold them (those at its rim hold fewer):
// the picture is cut into a grid of strata of equal size, in each a pixel is drawn by `seed`, and its tile is the
// probe. A tile is so drawn with a probability in proportion to its pixels: the mean of what is measured over the
// tile's pixels, weighted, is without bias. Where that takes every tile, each stands for itself.
//
// Errors: STATUS_NO_MEMORY.
Status probes_choose(ProbeSet *out, uint32_t width, uint32_t height, uint64_t pixels, uint32_t seed, Log *log);
void probes_free(ProbeSet *set);
