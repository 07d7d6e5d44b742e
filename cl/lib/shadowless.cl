// Triangles that cast no shadow: code for them is there where the scene has some (HAS_SHADOWLESS).

#include "lib/lanes.cl"
#include "shared/bvh.h"

// Lanes whose triangle shadow rays pass, by its flags (TRIANGLE_*).
static inline IntL lanes_shadowless(UintL flags)
{
#ifdef HAS_SHADOWLESS
  return (flags & UINTL(TRIANGLE_SHADOWLESS)) != UINTL(0);
#else
  return INTL(0);
#endif
}

static inline bool is_shadowless(uint flags)
{
#ifdef HAS_SHADOWLESS
  return flags & TRIANGLE_SHADOWLESS;
#else
  return false;
#endif
}
