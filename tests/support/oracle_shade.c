#include "support/oracle_shade.h"

static Vec3 grey(double value) { return vec3(value, value, value); }
static Vec3 mix(Vec3 a, Vec3 b, double share) { return vec3_add(vec3_scale(a, 1 - share), vec3_scale(b, share)); }
static Vec3 one_minus(Vec3 a) { return vec3_sub(grey(1), a); }
static double alpha_of(const OracleSurface *surface) { return surface->roughness * surface->roughness; }

bool oracle_is_mirror(const OracleSurface *surface) { return surface->roughness <= 0; }

// Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994.
static Vec3 schlick(const OracleSurface *surface, double cosine)
{
  Vec3 f0 = mix(grey(0.04), surface->base, surface->metallic);
  return vec3_add(f0, vec3_scale(one_minus(f0), pow(1 - fabs(cosine), 5)));
}

double oracle_ggx(double n_dot_h, double alpha)
{
  if (n_dot_h <= 0) return 0;
  double a2 = alpha * alpha, c = n_dot_h * n_dot_h * (a2 - 1) + 1;
  return a2 / (M_PI * c * c);
}

// Heitz, equation 99, as 1 / (1 + Lambda(v) + Lambda(l)) over 4 N.L N.V.
double oracle_smith(double n_dot_l, double n_dot_v, double alpha)
{
  double a2 = alpha * alpha, l2 = n_dot_l * n_dot_l, v2 = n_dot_v * n_dot_v;
  double lambda_l = (sqrt(1 + a2 * (1 - l2) / l2) - 1) / 2, lambda_v = (sqrt(1 + a2 * (1 - v2) / v2) - 1) / 2;
  return 1 / ((1 + lambda_l + lambda_v) * 4 * n_dot_l * n_dot_v);
}

// The 2007 formula's kd, ks and exponent.
static Vec3 phong_kd(const OracleSurface *surface) { return vec3_scale(surface->base, 1 - surface->metallic); }
static Vec3 phong_ks(const OracleSurface *surface) { return mix(grey(0.04), surface->base, surface->metallic); }
static double phong_exponent(const OracleSurface *surface)
{
  double alpha = alpha_of(surface);
  return 2 / (alpha * alpha) - 2;
}

OracleBrdf oracle_brdf(OracleModel model, const OracleSurface *surface, Vec3 n, Vec3 v, Vec3 l)
{
  OracleBrdf f = {0};
  double n_dot_l = vec3_dot(n, l), n_dot_v = fabs(vec3_dot(n, v));
  if (n_dot_l <= 0) return f;
  Vec3 h = vec3_unit_or(vec3_add(l, v), n);
  double n_dot_h = vec3_dot(n, h);
  if (model == ORACLE_PHONG) {
    double exponent = phong_exponent(surface), lobe = (exponent + 8) / (8 * M_PI) * pow(fmax(0, n_dot_h), exponent);
    f.diffuse = vec3_scale(phong_kd(surface), 1 / M_PI);
    if (!oracle_is_mirror(surface)) f.specular = vec3_scale(phong_ks(surface), lobe);
    return f;
  }
  Vec3 fresnel = schlick(surface, vec3_dot(v, h)), diffuse_color = vec3_scale(surface->base, 1 - surface->metallic);
  f.diffuse = vec3_scale(vec3_mul(one_minus(fresnel), diffuse_color), 1 / M_PI);
  if (!oracle_is_mirror(surface) && n_dot_v > 0) {
    double alpha = alpha_of(surface);
    f.specular = vec3_scale(fresnel, oracle_ggx(n_dot_h, alpha) * oracle_smith(n_dot_l, n_dot_v, alpha));
  }
  return f;
}

Vec3 oracle_reflectance(OracleModel model, const OracleSurface *surface, double n_dot_v)
{
  return model == ORACLE_PHONG ? phong_ks(surface) : schlick(surface, n_dot_v);
}

Vec3 oracle_own_light(OracleModel model, const OracleSurface *surface, double ambient)
{
  if (surface->unlit) return surface->base;
  Vec3 ambient_light = vec3_scale(surface->base, model == ORACLE_PHONG ? ambient : 0);
  return vec3_add(surface->emission, ambient_light);
}

// KHR_lights_punctual: 1 over the distance squared, windowed where the light has a range.
static double falloff(const Light *light, double distance_m)
{
  double window = isfinite(light->range_m) ? 1 - pow(distance_m / light->range_m, 4) : 1;
  return fmax(fmin(window, 1), 0) / (distance_m * distance_m);
}

// KHR_lights_punctual, "Inner and outer cone angles": the attenuation it recommends.
static double cone(const Light *light, Vec3 direction_to_light)
{
  double scale = 1 / fmax(0.001, cos(light->inner_cone_rad) - cos(light->outer_cone_rad));
  double offset = -cos(light->outer_cone_rad) * scale;
  double cosine = vec3_dot(light->direction_world, vec3_neg(direction_to_light));
  double attenuation = fmax(0, fmin(1, cosine * scale + offset));
  return attenuation * attenuation;
}

OracleArrival oracle_light_at(const Light *light, Vec3 position_world)
{
  OracleArrival arrival = {.direction = vec3_neg(light->direction_world), .distance_m = INFINITY};
  double strength = light->intensity;
  if (light->kind != LIGHT_DIRECTIONAL) {
    Vec3 way = vec3_sub(light->position_world, position_world);
    arrival.distance_m = vec3_length(way);
    arrival.direction = vec3_unit_or(way, vec3(0, 1, 0));
    strength *= falloff(light, arrival.distance_m);
    if (light->kind == LIGHT_SPOT) strength *= cone(light, arrival.direction);
  }
  arrival.irradiance = vec3_scale(vec3_from_floats(light->color), strength);
  return arrival;
}

Vec3 oracle_direct(OracleModel model, const OracleSurface *surface, Vec3 n, Vec3 geometric, Vec3 v,
                   const OracleArrival *arrival)
{
  double n_dot_l = vec3_dot(n, arrival->direction);
  if (surface->unlit || n_dot_l <= 0 || vec3_dot(geometric, arrival->direction) <= 0) return grey(0);
  OracleBrdf f = oracle_brdf(model, surface, n, v, arrival->direction);
  return vec3_scale(vec3_mul(vec3_add(f.diffuse, f.specular), arrival->irradiance), n_dot_l);
}

static Vec3 direction_at(double cosine, double phi)
{
  double sine = sqrt(fmax(0, 1 - cosine * cosine));
  return vec3(sine * cos(phi), sine * sin(phi), cosine);
}

double oracle_half_vector(OracleModel model, const OracleSurface *surface, double share, double *density)
{
  if (model == ORACLE_PHONG) {
    double exponent = phong_exponent(surface), cosine = pow(share, 1 / (exponent + 1));
    *density = (exponent + 1) / (2 * M_PI) * pow(cosine, exponent);
    return cosine;
  }
  double alpha = alpha_of(surface), cosine = sqrt((1 - share) / (1 + (alpha * alpha - 1) * share));
  *density = oracle_ggx(cosine, alpha) * cosine;
  return cosine;
}

OracleBrdf oracle_albedo(OracleModel model, const OracleSurface *surface, double n_dot_v, int cells)
{
  OracleBrdf albedo = {0};
  Vec3 n = vec3(0, 0, 1), v = direction_at(n_dot_v, 0);
  double cell = 1.0 / ((double)cells * cells);
  for (int i = 0; i < cells; i++) {
    for (int j = 0; j < cells; j++) {
      double share = (i + 0.5) / cells, phi = 2 * M_PI * (j + 0.5) / cells;
      Vec3 l = direction_at(sqrt(share), phi);
      albedo.diffuse = vec3_add(albedo.diffuse, vec3_scale(oracle_brdf(model, surface, n, v, l).diffuse, M_PI * cell));
      if (oracle_is_mirror(surface)) continue;
      double density, cosine = oracle_half_vector(model, surface, share, &density);
      Vec3 h = direction_at(cosine, phi);
      double v_dot_h = vec3_dot(v, h);
      l = vec3_sub(vec3_scale(h, 2 * v_dot_h), v);
      if (v_dot_h <= 0 || l.z <= 0 || !(density > 0)) continue;
      double weight = l.z * 4 * v_dot_h / density * cell;
      albedo.specular = vec3_add(albedo.specular, vec3_scale(oracle_brdf(model, surface, n, v, l).specular, weight));
    }
  }
  if (oracle_is_mirror(surface)) albedo.specular = oracle_reflectance(model, surface, n_dot_v);
  return albedo;
}
