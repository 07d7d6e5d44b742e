// A point on a light that has a size, as its shadow ray's goal: uniform over the solid angle that it subtends. Light
// and BRDF stay those of its centre.
//
//   A point inside a sphere sees all of it. A direction below the geometric plane sees nothing.
//   From  Pharr, Jakob, Humphreys, "Physically Based Rendering", 3rd edition, 2016, section 14.2.2.

#include "lib/lobe.cl"

// Direction within the cone about the unit vector `axis` whose half angle has this sine, by (x, y) in [0, 1)^2;
// *versine is 1 - its cosine to the axis.
static inline Vec3L cone_direction(Vec3L axis, FloatL sine, FloatL x, FloatL y, FloatL *versine)
{
  FloatL one = FLOATL(1), squared = sine * sine, angle = FLOATL(6.2831853f) * y;
  *versine = x * squared / (one + sqrt(one - squared));
  FloatL across = sqrt(max_lane(*versine * (FLOATL(2) - *versine), FLOATL(0)));
  Vec3L tangent, bitangent;
  frame_about(axis, &tangent, &bitangent);
  return from_frame(tangent, bitangent, axis, cos(angle) * across, sin(angle) * across, one - *versine);
}

// Turns *to_light (to the sphere's centre; t = 1 there) to the near side of the sphere along a direction of the cone.
// Returns the lanes that lie inside it.
static inline IntL sphere_point(Vec3L *to_light, Vec3L *unit, float radius, FloatL x, FloatL y)
{
  FloatL distance = sqrt(dot3(*to_light, *to_light)), sine = FLOATL(radius) / distance, versine, one = FLOATL(1);
  IntL inside = !(sine < one);
  Vec3L direction = cone_direction(*unit, inside ? FLOATL(0) : sine, x, y, &versine);
  FloatL along = distance * (one - versine), across = distance * distance * versine * (FLOATL(2) - versine);
  FloatL reach = along - sqrt(max_lane(FLOATL(radius * radius) - across, FLOATL(0)));
  *unit = select3(inside, *unit, direction);
  *to_light = select3(inside, *to_light, scale3(direction, reach));
  return inside;
}
