// Slab test of a ray against the planes of a box, with one multiply-add a plane: t = plane * inverse - origin *
// inverse.
//
// The product origin * inverse is rounded, and that of the plane where there is no fused multiply-add; both are off by
// at most one rounding of |origin * inverse| and one of t. So the near planes are moved back and the far planes on by
// that: no box that the ray meets is missed, whatever the origin. Directions below 1e-30 count as that, and a box is
// 1e-18 wider on each side, so that a ray within the plane of its side stays inside.
//
//   From  Ize, "Robust BVH Ray Traversal", JCGT 2013; Williams, Barrus, Morley, Shirley, "An Efficient and Robust
//   Ray-Box
//         Intersection Algorithm", 2005.

#include "lib/lanes.cl"

// A box is entered if the ray meets it within this factor: the rounding of t itself, and of hits whose distance is not
// in doubt (HIT_DOUBT of lib/triangle.cl).
#define BOX_PADDING 1.00002f

typedef struct SlabAxis {
  FloatL inverse;
  FloatL near_shift, far_shift;  // origin * inverse, moved by its rounding
} SlabAxis;

static inline SlabAxis slab_axis(FloatL origin, FloatL direction)
{
  FloatL inverse = FLOATL(1) / direction, limit = FLOATL(1e30f);
  inverse = inverse > limit ? limit : inverse < -limit ? -limit : inverse;
  FloatL shift = origin * inverse;
  FloatL error = fabs(inverse) * (fabs(origin) * FLOATL(2.4e-7f) + FLOATL(1e-18f));
  SlabAxis axis = {inverse, shift + error, shift - error};
  return axis;
}

// FAST_FMA: the processor has it. PoCL does not fuse mad where contraction is off, and emulates fma where it must.
#ifdef FAST_FMA
#define MULTIPLY_ADD fma
#else
#define MULTIPLY_ADD mad
#endif

static inline FloatL slab_near(const SlabAxis *axis, FloatL plane)
{
  return MULTIPLY_ADD(plane, axis->inverse, -axis->near_shift);
}

static inline FloatL slab_far(const SlabAxis *axis, FloatL plane)
{
  return MULTIPLY_ADD(plane, axis->inverse, -axis->far_shift);
}
