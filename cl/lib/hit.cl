// Which hits count, and which of two is seen: the rules that raster and rays share.

#include "lib/alpha.cl"
#include "lib/shadowless.cl"
#include "lib/slab.cl"
#include "lib/triangle.cl"

// The distance of a sliver, or of a triangle seen edge on, may be off by more than the boxes of a tree are padded by,
// and then what is nearest would hang on which boxes a tracer had looked into. Where t is in doubt
// (TriangleHit.doubtful) it is not taken to be before the ray enters the triangle's own box, which lies in every box
// that holds the triangle; a ray that misses that box, or leaves it before t_min, does not hit. `slab` is the ray's; a,
// b and c are the triangle's vertices in world space.
static inline void hit_hold(TriangleHit *hit, FloatL t_min, const SlabAxis slab[3], const FloatL a[3],
                            const FloatL b[3], const FloatL c[3])
{
  FloatL enter = FLOATL(-INFINITY), leave = FLOATL(INFINITY);
#pragma unroll
  for (uint axis = 0; axis < 3; axis++) {
    FloatL low = min_lane(min_lane(a[axis], b[axis]), c[axis]), high = max_lane(max_lane(a[axis], b[axis]), c[axis]);
    IntL backwards = slab[axis].inverse < FLOATL(0);
    enter = max_lane(slab_near(&slab[axis], backwards ? high : low), enter);
    leave = min_lane(slab_far(&slab[axis], backwards ? low : high), leave);
  }
  FloatL padded = leave * FLOATL(BOX_PADDING);
  hit->inside = hit->inside & !(hit->doubtful & ((enter > padded) | (t_min > padded)));
  hit->t = hit->doubtful ? max_lane(hit->t, enter) : hit->t;
}

// Lanes that see a single-sided triangle (flags: TRIANGLE_*) from behind. `positive_kz`: the direction's component kz
// is positive.
static inline IntL hit_is_open(const TriangleHit *hit, uint flags, IntL positive_kz)
{
  IntL back = (hit->determinant_positive != INTL(0)) != (positive_kz != INTL(0));
  return back & INTL(flags & TRIANGLE_SINGLE_SIDED ? -1 : 0);
}

// Lanes of `lanes` in which `hit` on triangle `id` (flags: TRIANGLE_*) lies beyond t_min and beats what was closest so
// far: the nearer wins, of equals the lower id. Back faces of single-sided triangles are open.
static inline IntL hit_is_closest(const TriangleHit *hit, IntL lanes, FloatL t_min, FloatL closest_t, UintL closest_id,
                                  uint id, uint flags, IntL positive_kz)
{
  return hit->inside & lanes & !hit_is_open(hit, flags, positive_kz) & (hit->t > t_min) &
         ((hit->t < closest_t) | ((hit->t == closest_t) & (UINTL(id) < closest_id)));
}

// Lanes of `lanes` whose hit is there where MASK cuts.
static inline IntL hit_passes(const TriangleHit *hit, IntL lanes, uint id, uint flags,
                              const AttributeSources *attributes)
{
#ifdef HAS_MASK
  if (flags & TRIANGLE_MASKED) lanes = lanes & alpha_passes(attributes, id, lanes, hit->u, hit->v);
#endif
  return lanes;
}

// Lanes whose hit is more than rounding away from the end of a shadow ray: what a light lies on does not stand before
// it. At that end the roundings of the direction and of the shear count too, which t_error leaves out: with them it is
// 3 times as much at most.
static inline IntL hit_before_end(const TriangleHit *hit, FloatL t_max)
{
  return hit->t + FLOATL(3) * hit->t_error < t_max;
}

// Lanes of `lanes` whose hit is more than rounding away from the ray's start, and is there where MASK cuts. What is not
// doubtful is: t_error is then at most 1.01 HIT_DOUBT t.
static inline IntL hit_counts(const TriangleHit *hit, IntL lanes, uint id, uint flags,
                              const AttributeSources *attributes)
{
  return hit_passes(hit, lanes & (hit->t > hit->t_error), id, flags, attributes);
}
