// Alpha at a hit: MASK, does it count; BLEND, how much of a shadow ray's light does it let through?

#include "lib/texture.cl"

static inline FloatL alpha_at(const AttributeSources *from, const TriangleCorners *corners, IntL mask, FloatL u,
                              FloatL v)
{
  Attributes at = attributes_none();
  attributes_load(&at, from, corners, mask, u, v);
  return base_color_sample(from, &from->materials[corners->material], &at, mask).a;
}

// Lanes whose alpha at barycentrics (u, v) of triangle `id` reaches the material's cutoff, of those of `accept`.
static inline IntL alpha_passes(const AttributeSources *from, uint id, IntL accept, FloatL u, FloatL v)
{
  TriangleCorners corners = from->corners[id];
  return alpha_at(from, &corners, accept, u, v) >= FLOATL(from->materials[corners.material].alpha_cutoff);
}

// Units of absorption in an octave. Sums of whole units are the same in whatever order the surfaces are met, which
// products of floats are not; their rounding is 3e-7 of the light a surface.
#define ABSORPTION_UNITS 1048576.0f
#define ABSORPTION_ALL (1 << 29)

// Absorption of the lanes of `accept` at one BLEND surface: -log2(1 - alpha) in units; ABSORPTION_ALL where all is
// stopped.
static inline IntL alpha_absorption(const AttributeSources *from, uint id, IntL accept, FloatL u, FloatL v)
{
  TriangleCorners corners = from->corners[id];
  FloatL through = FLOATL(1) - alpha_at(from, &corners, accept, u, v);
  IntL some = through > FLOATL(1e-6f);
  FloatL units = FLOATL(-ABSORPTION_UNITS) * log2(min_lane(some ? through : FLOATL(1), FLOATL(1)));
  return accept ? (some ? LANE_CONVERT_INT(units + FLOATL(0.5f)) : INTL(ABSORPTION_ALL)) : INTL(0);
}

// Share of the light that is left.
static inline FloatL absorption_through(IntL absorption)
{
  return exp2(LANE_CONVERT_FLOAT(absorption) * FLOATL(-1 / ABSORPTION_UNITS));
}
