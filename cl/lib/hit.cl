// Which hits count, and which of two is seen: the rules that raster and rays share.

#include "lib/alpha.cl"
#include "lib/triangle.cl"

// Lanes of `lanes` in which `hit` on triangle `id` (flags: TRIANGLE_*) lies beyond t_min and beats what was closest so
// far: the nearer wins, of equals the lower id. Back faces of single-sided triangles are open. `positive_kz`: the
// direction's component kz is positive.
static inline IntL hit_is_closest(const TriangleHit *hit, IntL lanes, FloatL t_min, FloatL closest_t, UintL closest_id,
                                  uint id, uint flags, IntL positive_kz)
{
  IntL back = (hit->determinant_positive != INTL(0)) != (positive_kz != INTL(0));
  IntL open = back & INTL(flags & TRIANGLE_SINGLE_SIDED ? -1 : 0);
  return hit->inside & lanes & (!open) & (hit->t > t_min) &
         ((hit->t < closest_t) | ((hit->t == closest_t) & (UINTL(id) < closest_id)));
}

// Lanes of `lanes` whose hit is more than rounding away from the ray's start, and is there where MASK cuts.
static inline IntL hit_counts(const TriangleHit *hit, IntL lanes, uint id, uint flags,
                              const AttributeSources *attributes)
{
  lanes = lanes & (hit->t > hit->t_error);
#ifdef HAS_MASK
  if (flags & TRIANGLE_MASKED) lanes = lanes & alpha_passes(attributes, id, lanes, hit->u, hit->v);
#endif
  return lanes;
}
