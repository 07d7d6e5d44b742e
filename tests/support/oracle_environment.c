#include "support/oracle_environment.h"

#include <stdlib.h>

#include "support/oracle_scene.h"

static Vec3 image_texel(const Image *image, double column, double row)
{
  long width = image->width, height = image->height;
  long x = (((long)column % width) + width) % width, y = row < 0 ? 0 : row > height - 1 ? height - 1 : (long)row;
  return vec3_from_floats(image->pixels + 4 * ((size_t)y * width + x));
}

// Direction of point (u, v): (cos p sin t, cos t, sin p sin t), p = 2 pi (u - 1/2), t = pi v.
static Vec3 image_radiance(const Image *image, Vec3 direction)
{
  double u = atan2(direction.z, direction.x) / (2 * M_PI) + 0.5;
  double v = acos(fmax(-1, fmin(1, direction.y))) / M_PI;
  double x = u * image->width - 0.5, y = v * image->height - 0.5, left = floor(x), top = floor(y);
  double right_share = x - left, low_share = y - top;
  Vec3 sum = vec3_scale(image_texel(image, left, top), (1 - right_share) * (1 - low_share));
  sum = vec3_add(sum, vec3_scale(image_texel(image, left + 1, top), right_share * (1 - low_share)));
  sum = vec3_add(sum, vec3_scale(image_texel(image, left, top + 1), (1 - right_share) * low_share));
  return vec3_add(sum, vec3_scale(image_texel(image, left + 1, top + 1), right_share * low_share));
}

static Vec3 gradient_radiance(const Environment *environment, double y)
{
  Vec3 horizon = vec3_from_floats(environment->horizon);
  Vec3 pole = vec3_from_floats(y >= 0 ? environment->zenith : environment->ground);
  return vec3_add(horizon, vec3_scale(vec3_sub(pole, horizon), fabs(y)));
}

Vec3 oracle_environment(const Environment *environment, Vec3 direction_world)
{
  double c = cos(environment->rotation_rad), s = sin(environment->rotation_rad);
  Vec3 d = direction_world, direction = vec3(c * d.x - s * d.z, d.y, s * d.x + c * d.z);
  Vec3 radiance = vec3_from_floats(environment->constant);
  if (environment->kind == ENVIRONMENT_GRADIENT) radiance = gradient_radiance(environment, direction.y);
  if (environment->kind == ENVIRONMENT_IMAGE) radiance = image_radiance(&environment->image, direction);
  return vec3_scale(radiance, environment->intensity);
}

OracleDome oracle_dome_make(const Environment *environment, uint32_t rows, uint32_t inner)
{
  uint32_t columns = 2 * rows;
  OracleDome dome = {.cell_count = rows * columns};
  dome.cells = oracle_array(dome.cell_count, sizeof *dome.cells);
  double solid_angle = 4 * M_PI / dome.cell_count;
  for (uint32_t cell = 0; cell < dome.cell_count; cell++) {
    Vec3 direction = {0}, flux = {0};
    for (uint32_t point = 0; point < inner * inner; point++) {
      double along = cell % columns + (point % inner + 0.5) / inner,
             down = cell / columns + (point / inner + 0.5) / inner;
      double y = 1 - 2 * down / rows, phi = 2 * M_PI * along / columns, ring = sqrt(1 - y * y);
      Vec3 at = vec3(ring * cos(phi), y, ring * sin(phi));
      direction = vec3_add(direction, at);
      flux = vec3_add(flux, vec3_scale(oracle_environment(environment, at), solid_angle / (inner * inner)));
    }
    dome.cells[cell][0] = vec3_unit_or(direction, vec3(0, 1, 0));
    dome.cells[cell][1] = flux;
  }
  return dome;
}

void oracle_dome_free(OracleDome *dome)
{
  free(dome->cells);
  *dome = (OracleDome){0};
}

static Vec3 dome_diffuse(const OracleDome *dome, const OracleSurface *surface, Vec3 n, Vec3 v)
{
  Vec3 sum = {0};
  for (uint32_t i = 0; i < dome->cell_count; i++) {
    double cosine = vec3_dot(n, dome->cells[i][0]);
    if (cosine <= 0) continue;
    Vec3 diffuse = oracle_brdf(ORACLE_PBR, surface, n, v, dome->cells[i][0]).diffuse;
    sum = vec3_add(sum, vec3_scale(vec3_mul(diffuse, dome->cells[i][1]), cosine));
  }
  return vec3_scale(sum, surface->occlusion);
}

enum { LOBE_CELLS = 24 };

static Vec3 lobe_specular(const Environment *environment, const OracleSurface *surface, Vec3 n, Vec3 v)
{
  Vec3 sum = {0}, across = vec3_unit_or(vec3_cross(n, fabs(n.x) < 0.5 ? vec3(1, 0, 0) : vec3(0, 1, 0)), n);
  Vec3 along = vec3_cross(n, across);
  for (int i = 0; i < LOBE_CELLS * LOBE_CELLS; i++) {
    double density, phi = 2 * M_PI * (i % LOBE_CELLS + 0.5) / LOBE_CELLS;
    double cosine = oracle_half_vector(ORACLE_PBR, surface, (i / LOBE_CELLS + 0.5) / LOBE_CELLS, &density);
    double sine = sqrt(fmax(0, 1 - cosine * cosine));
    Vec3 h = vec3_add(vec3_scale(across, sine * cos(phi)), vec3_scale(along, sine * sin(phi)));
    h = vec3_add(h, vec3_scale(n, cosine));
    double v_dot_h = vec3_dot(v, h);
    Vec3 l = vec3_sub(vec3_scale(h, 2 * v_dot_h), v);
    double n_dot_l = vec3_dot(n, l);
    if (v_dot_h <= 0 || n_dot_l <= 0 || !(density > 0)) continue;
    Vec3 specular = oracle_brdf(ORACLE_PBR, surface, n, v, l).specular;
    double weight = n_dot_l * 4 * v_dot_h / density / (LOBE_CELLS * LOBE_CELLS);
    sum = vec3_add(sum, vec3_scale(vec3_mul(specular, oracle_environment(environment, l)), weight));
  }
  return sum;
}

Vec3 oracle_environment_light(const Environment *environment, const OracleDome *dome, OracleModel model,
                              const OracleSurface *surface, Vec3 n, Vec3 v)
{
  if (model == ORACLE_PHONG || surface->unlit || dome->cell_count == 0) return vec3(0, 0, 0);
  Vec3 light = dome_diffuse(dome, surface, n, v);
  return oracle_is_mirror(surface) ? light : vec3_add(light, lobe_specular(environment, surface, n, v));
}
