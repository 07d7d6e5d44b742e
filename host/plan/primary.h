// Primary visibility: raster or rays? Both give the same hits bit for bit, so that cost alone decides.
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef enum PrimaryMethod { PRIMARY_AUTO, PRIMARY_RASTER, PRIMARY_RAYS } PrimaryMethod;

// "auto", "raster" or "rays".
const char *primary_name(PrimaryMethod method);

// What it depends on: triangles of the scene, pixels and samples of the picture, and the class of device.
typedef struct PrimaryFacts {
  uint64_t triangles, pixels;
  uint32_t samples;
  bool gpu;
} PrimaryFacts;

// Predicted milliseconds of the passes that find what camera rays see. They compare methods on the machine that the
// models were fitted on (primary.c); on another machine both are off, by much the same factor.
typedef struct PrimaryCost {
  double raster_ms, rays_ms;
} PrimaryCost;
PrimaryCost primary_cost(const PrimaryFacts *facts);

// The one asked for; for PRIMARY_AUTO the cheaper, and of equals rays.
PrimaryMethod primary_choose(PrimaryMethod asked, const PrimaryCost *cost);
