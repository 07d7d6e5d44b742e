// alpha MASK: does a hit count?

#include "lib/texture.cl"

// Lanes whose alpha at barycentrics (u, v) of triangle `id` reaches the material's cutoff, of those of `accept`.
static inline IntL alpha_passes(const AttributeSources *from, uint id, IntL accept, FloatL u, FloatL v)
{
  TriangleCorners corners = from->corners[id];
  Color4L color = base_color_sample(from, &corners, accept, u, v);
  return color.a >= FLOATL(from->materials[corners.material].alpha_cutoff);
}
