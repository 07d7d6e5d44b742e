// How the sums of a picture become its values. Written by host/passes, read by cl/shade/resolve.cl.
#ifndef SHARED_RESOLVE_H
#define SHARED_RESOLVE_H

#include "shared/types.h"

#define TONE_CURVE_NONE 0u
#define TONE_CURVE_FILMIC 1u
#define TONE_CURVE_PBR_NEUTRAL 2u

typedef struct ResolveInfo {
  uint pixel_count;
  float scale;           // of radiance: 2^exposure / samples
  float coverage_scale;  // of coverage: 1 / samples
  uint tone;             // TONE_CURVE_*
  uint display;          // 1: tone curve and sRGB, straight alpha; 0: linear radiance, premultiplied
  uint opaque;           // 1: alpha is 1 everywhere
  uint has_background;   // 1 (with opaque): `background` shows through where coverage is below 1
  Float3 background;     // linear, as displayed: neither scaled nor through the tone curve
} ResolveInfo;
SHARED_SIZE(ResolveInfo, 40);

#endif
