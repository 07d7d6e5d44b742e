// alpha MASK: does a hit count?

#include "lib/texture.cl"

// Lanes of `accept` whose alpha at barycentrics (u, v) of triangle `id` reaches the material's cutoff.
static inline IntL alpha_passes(const AttributeSources *from, uint id, IntL accept, FloatL u, FloatL v)
{
  TriangleCorners corners = from->corners[id];
  float cutoff = from->materials[corners.material].alpha_cutoff;
  FloatL alpha = FLOATL(-1);
  for (uint bits = lane_bits(accept); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    LANE_FLOAT(alpha, lane) = base_color_sample(from, &corners, LANE_FLOAT(u, lane), LANE_FLOAT(v, lane)).w;
  }
  return alpha >= FLOATL(cutoff);
}
