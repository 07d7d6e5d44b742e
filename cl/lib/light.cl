// Light of a punctual light at a point, as if nothing stood before it.

#include "lib/area_light.cl"
#include "lib/surface_samples.cl"

typedef struct Lighting {
  Vec3L to_light;  // from the offset origin to the light; t = 1 is the light
  Vec3L unit;
  Vec3L irradiance;  // on a surface that faces the light
  FloatL t_max;
} Lighting;

// Light that arrives at `origin`, unblocked. KHR_lights_punctual: inverse square, range window, spot cone.
static inline Lighting light_arriving(global const LightInfo *light, Vec3L origin)
{
  Lighting out;
  FloatL zero = FLOATL(0), one = FLOATL(1), factor = one;
  Vec3L beam = vec3l(FLOATL(light->direction.x), FLOATL(light->direction.y), FLOATL(light->direction.z));
  if (light->kind == LIGHT_KIND_DIRECTIONAL) {
    out.to_light = out.unit = sub3(vec3l(zero, zero, zero), beam);
    out.t_max = FLOATL(INFINITY);
  } else {
    Vec3L position = vec3l(FLOATL(light->position.x), FLOATL(light->position.y), FLOATL(light->position.z));
    out.to_light = sub3(position, origin);
    out.unit = unit3(out.to_light);
    out.t_max = one;
    FloatL squared = dot3(out.to_light, out.to_light);
    if (light->range_m < INFINITY) {
      FloatL ratio = squared / FLOATL(light->range_m) / FLOATL(light->range_m);
      factor = max_lane(one - ratio * ratio, zero);
    }
    factor = squared > zero ? factor / squared : zero;
    if (light->kind == LIGHT_KIND_SPOT) {
      FloatL cosine = zero - dot3(beam, out.unit);
      FloatL cone = max_lane(min_lane(cosine * FLOATL(light->spot_scale) + FLOATL(light->spot_offset), one), zero);
      factor = factor * cone * cone;
    }
  }
  out.irradiance =
      vec3l(FLOATL(light->radiant.x) * factor, FLOATL(light->radiant.y) * factor, FLOATL(light->radiant.z) * factor);
  return out;
}

#ifdef HAS_AREA_LIGHTS
// Aims at a point of the light by chance. Returns the lanes inside it.
static inline IntL light_point_choose(Lighting *light, uint kind, const ShadeInfo *shade, uint number, UintL slot)
{
  RandomSource random = random_source(shade, slot);
  FloatL x, y, versine;
  random_point(random.key + UINTL(RANDOM_AREA + number), random.sample, &x, &y);
  if (kind != LIGHT_KIND_DIRECTIONAL) return sphere_point(&light->to_light, &light->unit, shade->light_radius_m, x, y);
  light->unit = cone_direction(light->unit, FLOATL(shade->light_sine), x, y, &versine);
  light->to_light = light->unit;
  return INTL(0);
}
#endif
