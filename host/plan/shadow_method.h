// How a light's shadows are found, and sets of such methods.
#pragma once

#include <stdint.h>

// shared/shadow.h and cl/lib/shadow_lookup.cl have the errors of each.
typedef enum ShadowMethod {
  SHADOWS_NONE,    // light arrives unblocked
  SHADOWS_MAP,     // the nearest texel of a shadow map
  SHADOWS_PCF,     // the share of a few texels: the 2007 system's
  SHADOWS_PCSS,    // that of a disc as wide as the light's half-shadow would be
  SHADOWS_HYBRID,  // what the map knows for sure, and rays for the rest: the picture of SHADOWS_RAYS
  SHADOWS_RAYS,
  SHADOWS_AREA,  // rays to points of a light that has a radius
  SHADOWS_AUTO,  // of settings alone: HYBRID or RAYS, whichever is quicker, light by light
} ShadowMethod;

// The word for each; ends with NULL.
extern const char *const shadow_words[];

// Sets of methods.
#define SHADOW_SET(method) (1u << (method))
#define SHADOW_SET_LOOKED_UP (SHADOW_SET(SHADOWS_MAP) | SHADOW_SET(SHADOWS_PCF) | SHADOW_SET(SHADOWS_PCSS))
#define SHADOW_SET_TRACED (SHADOW_SET(SHADOWS_RAYS) | SHADOW_SET(SHADOWS_AREA))
#define SHADOW_SET_SHARP (SHADOW_SET(SHADOWS_NONE) | SHADOW_SET(SHADOWS_HYBRID) | SHADOW_SET(SHADOWS_RAYS))

// The method itself where it is in the set, else what is most like it: AREA for PCSS, if that is there, or RAYS.
ShadowMethod shadow_method_within(uint32_t set, ShadowMethod method);
