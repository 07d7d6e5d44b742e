#include "plan/shadow_method.h"

#include <stddef.h>

const char *const shadow_words[] = {"none", "map", "pcf", "pcss", "hybrid", "rays", "area", "auto", NULL};

ShadowMethod shadow_method_within(uint32_t set, ShadowMethod method)
{
  if (set & SHADOW_SET(method)) return method;
  return method == SHADOWS_PCSS && set & SHADOW_SET(SHADOWS_AREA) ? SHADOWS_AREA : SHADOWS_RAYS;
}
