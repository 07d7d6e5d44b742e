#include "support/oracle_surface.h"

static long texel_wrapped(long index, long size, WrapMode wrap)
{
  if (wrap == WRAP_CLAMP) return index < 0 ? 0 : index >= size ? size - 1 : index;
  long period = wrap == WRAP_MIRROR ? 2 * size : size, at = (index % period + period) % period;
  return at < size ? at : period - 1 - at;
}

// IEC 61966-2-1.
static double linear_from_srgb(double value)
{
  return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
}

static void texel_add(double out[4], const Scene *model, const Texture *texture, long x, long y, bool srgb,
                      double share)
{
  const Image *image = &model->images[texture->image];
  long column = texel_wrapped(x, image->width, texture->wrap_u), row = texel_wrapped(y, image->height, texture->wrap_v);
  const uint8_t *texel = image->texels + 4 * ((size_t)row * image->width + (size_t)column);
  for (int channel = 0; channel < 4; channel++) {
    double value = texel[channel] / 255.0;
    out[channel] += share * (srgb && channel < 3 ? linear_from_srgb(value) : value);
  }
}

void oracle_texture_at(double out[4], const Scene *model, int texture, double u, double v, bool srgb, double *margin)
{
  const Texture *from = &model->textures[texture];
  double x = u * model->images[from->image].width, y = v * model->images[from->image].height;
  for (int channel = 0; channel < 4; channel++) out[channel] = 0;
  if (from->nearest) {
    double border = fmin(fabs(x - round(x)), fabs(y - round(y)));
    *margin = fmin(*margin, border * 0.01);
    texel_add(out, model, from, (long)floor(x), (long)floor(y), srgb, 1);
    return;
  }
  double left = floor(x - 0.5), top = floor(y - 0.5), right_share = x - 0.5 - left, low_share = y - 0.5 - top;
  for (int corner = 0; corner < 4; corner++) {
    int right = corner & 1, low = corner >> 1;
    double share = (right ? right_share : 1 - right_share) * (low ? low_share : 1 - low_share);
    texel_add(out, model, from, (long)left + right, (long)top + low, srgb, share);
  }
}

// Weights of the three corners at a point of a triangle, and its arrays.
typedef struct Blend {
  const OracleScene *scene;
  const Primitive *primitive;
  const uint32_t *corners;
  double weights[3];
  double *margin;
} Blend;

static Blend blend_make(const OracleScene *scene, uint32_t triangle, double u, double v, double *margin)
{
  return (Blend){.scene = scene,
                 .primitive = oracle_primitive(scene, triangle),
                 .corners = scene->triangles[triangle].corners,
                 .weights = {1 - u - v, u, v},
                 .margin = margin};
}

// The slot's texture at the point; `absent` in every channel where there is none.
static void slot_at(double out[4], const Blend *at, const TextureSlot *slot, bool srgb, double absent)
{
  const float(*uvs)[2] = (const float(*)[2])at->primitive->uvs[slot->uv_set ? 1 : 0];
  for (int channel = 0; channel < 4; channel++) out[channel] = absent;
  if (slot->texture == NONE) return;
  double u = 0, v = 0;
  for (int corner = 0; uvs && corner < 3; corner++) {
    u += at->weights[corner] * uvs[at->corners[corner]][0];
    v += at->weights[corner] * uvs[at->corners[corner]][1];
  }
  const float *m = slot->uv_from_uv;
  oracle_texture_at(out, at->scene->model, slot->texture, m[0] * u + m[1] * v + m[2], m[3] * u + m[4] * v + m[5], srgb,
                    at->margin);
}

// Base colour and alpha: factor x texture x vertex colour.
static void base_at(double out[4], const Blend *at, const Material *material)
{
  slot_at(out, at, &material->base_color_slot, true, 1);
  for (int channel = 0; channel < 4; channel++) {
    double vertex = at->primitive->colors ? 0 : 1;
    for (int corner = 0; at->primitive->colors && corner < 3; corner++)
      vertex += at->weights[corner] * at->primitive->colors[at->corners[corner]][channel];
    out[channel] *= material->base_color[channel] * vertex;
  }
}

double oracle_surface_coverage(const OracleScene *scene, uint32_t triangle, double u, double v, double *margin)
{
  const Material *material = oracle_material(scene, triangle);
  Blend at = blend_make(scene, triangle, u, v, margin);
  double base[4];
  base_at(base, &at, material);
  if (material->alpha_mode == ALPHA_OPAQUE) return 1;
  if (material->alpha_mode == ALPHA_BLEND) return fmax(0, fmin(1, base[3]));
  *margin = fmin(*margin, fabs(base[3] - material->alpha_cutoff) * 0.01);
  return base[3] >= material->alpha_cutoff ? 1 : 0;
}

// World-space tangent of the triangle along the u of a uv set, and on which side v lies, for a mesh without tangents.
static Vec3 triangle_tangent(const Blend *at, uint32_t triangle, uint32_t uv_set, Vec3 geometric, double *side)
{
  const float(*uvs)[2] = (const float(*)[2])at->primitive->uvs[uv_set ? 1 : 0];
  const float *a = uvs[at->corners[0]], *b = uvs[at->corners[1]], *c = uvs[at->corners[2]];
  Vec3 origin = oracle_vertex(at->scene, triangle, 0);
  Vec3 to_b = vec3_sub(oracle_vertex(at->scene, triangle, 1), origin);
  Vec3 to_c = vec3_sub(oracle_vertex(at->scene, triangle, 2), origin);
  double bu = b[0] - a[0], bv = b[1] - a[1], cu = c[0] - a[0], cv = c[1] - a[1], det = bu * cv - cu * bv;
  double sign = det < 0 ? -1 : 1;
  Vec3 tangent = vec3_scale(vec3_sub(vec3_scale(to_b, cv), vec3_scale(to_c, bv)), sign);
  Vec3 bitangent = vec3_scale(vec3_sub(vec3_scale(to_c, bu), vec3_scale(to_b, cu)), sign);
  *side = vec3_dot(vec3_cross(geometric, tangent), bitangent) < 0 ? -1 : 1;
  return vec3_unit_or(tangent, vec3(0, 0, 0));
}

// glTF 2.0, sections 3.7.2.1 and 3.9.3: bitangent = cross(normal, tangent) x w.
static Vec3 normal_mapped(const Blend *at, uint32_t triangle, Vec3 normal, Vec3 geometric, const Material *material)
{
  const Mat4 *world_from_object = &at->scene->model->objects[at->scene->triangles[triangle].object].world_from_object;
  const TextureSlot *slot = &material->normal_slot;
  Vec3 tangent = {0};
  double side = 1, texel[4];
  if (slot->texture == NONE || !at->primitive->uvs[slot->uv_set ? 1 : 0]) return normal;
  if (at->primitive->tangents) {
    for (int corner = 0; corner < 3; corner++) {
      const float *own = at->primitive->tangents[at->corners[corner]];
      Vec3 world = vec3_unit_or(mat4_direction(world_from_object, vec3_from_floats(own)), vec3(0, 0, 0));
      tangent = vec3_add(tangent, vec3_scale(world, at->weights[corner]));
    }
    side = at->primitive->tangents[at->corners[0]][3] * (mat4_determinant3(world_from_object) < 0 ? -1 : 1);
  } else {
    tangent = triangle_tangent(at, triangle, slot->uv_set, geometric, &side);
  }
  slot_at(texel, at, slot, false, 0);
  Vec3 bitangent = vec3_scale(vec3_cross(normal, tangent), side);
  Vec3 mapped = vec3_scale(tangent, (2 * texel[0] - 1) * material->normal_scale);
  mapped = vec3_add(mapped, vec3_scale(bitangent, (2 * texel[1] - 1) * material->normal_scale));
  return vec3_unit_or(vec3_add(mapped, vec3_scale(normal, 2 * texel[2] - 1)), normal);
}

static Vec3 interpolated_normal(const Blend *at, uint32_t triangle, Vec3 geometric)
{
  const Mat4 *world_from_object = &at->scene->model->objects[at->scene->triangles[triangle].object].world_from_object;
  double sign = mat4_determinant3(world_from_object) < 0 ? -1 : 1;
  Vec3 sum = {0};
  for (int corner = 0; corner < 3; corner++) {
    Vec3 normal_object = vec3_from_floats(at->primitive->normals[at->corners[corner]]);
    Vec3 world = vec3_unit_or(mat4_normal(world_from_object, normal_object), vec3(0, 0, 0));
    sum = vec3_add(sum, vec3_scale(world, sign * at->weights[corner]));
  }
  return vec3_unit_or(sum, geometric);
}

static OracleSurface surface_at(const Blend *at, const Material *material)
{
  double base[4], metal_rough[4], emission[4], occlusion[4];
  base_at(base, at, material);
  slot_at(metal_rough, at, &material->metallic_roughness_slot, false, 1);
  slot_at(emission, at, &material->emission_slot, true, 1);
  slot_at(occlusion, at, &material->occlusion_slot, false, 1);
  return (OracleSurface){
      .base = vec3(base[0], base[1], base[2]),
      .alpha = material->alpha_mode == ALPHA_BLEND ? fmax(0, fmin(1, base[3])) : 1,
      .metallic = material->metallic * metal_rough[2],
      .roughness = material->roughness * metal_rough[1],
      .emission = vec3_mul(vec3_from_floats(material->emission), vec3(emission[0], emission[1], emission[2])),
      .occlusion = 1 + material->occlusion_strength * (occlusion[0] - 1),
      .unlit = material->unlit,
  };
}

OraclePoint oracle_surface_at(const OracleScene *scene, const OracleRay *ray, const OracleHit *hit)
{
  OraclePoint point = {.material = oracle_material(scene, hit->triangle), .margin = ORACLE_MARGIN_MAX};
  Blend at = blend_make(scene, hit->triangle, hit->u, hit->v, &point.margin);
  Vec3 corners[3];
  for (int corner = 0; corner < 3; corner++) {
    corners[corner] = oracle_vertex(scene, hit->triangle, corner);
    point.position_world = vec3_add(point.position_world, vec3_scale(corners[corner], at.weights[corner]));
  }
  Vec3 front = vec3_cross(vec3_sub(corners[1], corners[0]), vec3_sub(corners[2], corners[0]));
  front = vec3_unit_or(front, vec3(0, 0, 0));
  double side = vec3_dot(front, ray->direction) > 0 ? -1 : 1;
  Vec3 normal = interpolated_normal(&at, hit->triangle, front);
  normal = normal_mapped(&at, hit->triangle, normal, front, point.material);
  point.normal_world = vec3_scale(normal, side);
  point.geometric_world = vec3_scale(front, side);
  point.surface = surface_at(&at, point.material);
  return point;
}
