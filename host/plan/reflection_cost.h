// Do hybrid reflections of one reflector take less time than rays? No OpenCL here.
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef struct ReflectionFacts {
  double rays;       // that the reflector sends out in the whole picture
  uint32_t size_px;  // of its cube map's faces
  uint64_t triangles;
  uint32_t lights;  // to which each hit sends a shadow ray
  bool gpu;
} ReflectionFacts;

// Predicted milliseconds, for a single frame: the map is drawn for it alone. Of the map, as hybrid reflections ask it,
// 10 % of the rays are taken to be traced and 50 % to be shaded, as in room and chrome.
typedef struct ReflectionCost {
  double rays_ms, hybrid_ms;
} ReflectionCost;
ReflectionCost reflection_cost(const ReflectionFacts *facts);
