#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/large_array.h"
#include "device_scene/flat_scene.h"

static TextureUse texture_use(const TextureSlot *slot, uint32_t uv_set_count)
{
  TextureUse use = {.texture = slot->texture == NONE ? TEXTURE_NONE : (uint32_t)slot->texture,
                    .uv_set = slot->uv_set < uv_set_count ? slot->uv_set : 0};
  memcpy(use.matrix, slot->uv_from_uv, sizeof use.matrix);
  return use;
}

static MaterialInfo material_info(const Material *from, uint32_t uv_set_count)
{
  MaterialInfo info = {
      .metallic = from->metallic,
      .roughness = from->roughness,
      .alpha_cutoff = from->alpha_cutoff,
      .normal_scale = from->normal_scale,
      .occlusion_strength = from->occlusion_strength,
      .flags = (from->unlit ? MATERIAL_UNLIT : 0) | (from->alpha_mode == ALPHA_MASK ? MATERIAL_MASKED : 0) |
               (from->alpha_mode == ALPHA_BLEND ? MATERIAL_BLENDED : 0) |
               (from->double_sided ? 0 : MATERIAL_SINGLE_SIDED),
      .base_color_use = texture_use(&from->base_color_slot, uv_set_count),
      .metallic_roughness_use = texture_use(&from->metallic_roughness_slot, uv_set_count),
      .emission_use = texture_use(&from->emission_slot, uv_set_count),
      .normal_use = texture_use(&from->normal_slot, uv_set_count),
      .occlusion_use = texture_use(&from->occlusion_slot, uv_set_count),
  };
  memcpy(info.base_color, from->base_color, sizeof info.base_color);
  memcpy(info.emission, from->emission, sizeof info.emission);
  return info;
}

// Can a ray find roughness 0 on it, and what is the least above that? A texture may hold 0 wherever the factor lets it
// through, and anything up to its other texels in between.
static void material_roughness(FlatScene *flat, const Material *material, const Scene *scene)
{
  if (material->unlit) return;
  bool texels[256] = {[255] = true};
  int texture = material->metallic_roughness_slot.texture;
  if (material->roughness > 0 && texture != NONE) {
    const Image *image = &scene->images[scene->textures[texture].image];
    texels[255] = false;
    for (size_t i = 0; i < (size_t)image->width * image->height; i++) texels[image->texels[4 * i + 1]] = true;
  }
  int least = 1;
  while (least < 256 && !texels[least]) least++;
  flat->has_mirrors |= material->roughness <= 0 || texels[0];
  if (material->roughness <= 0 || least == 256) return;
  flat->least_roughness = fminf(flat->least_roughness, texels[0] ? 0 : material->roughness * (float)least / 255);
}

static void material_mark_images(bool *used, const Material *material, const Scene *scene)
{
  const TextureSlot *slots[] = {&material->base_color_slot, &material->metallic_roughness_slot,
                                &material->emission_slot, &material->normal_slot, &material->occlusion_slot};
  for (size_t i = 0; i < sizeof slots / sizeof *slots; i++)
    if (slots[i]->texture != NONE) used[scene->textures[slots[i]->texture].image] = true;
}

static Status textures_make(FlatScene *flat, const Scene *scene, Log *log)
{
  Status status = STATUS_OK;
  bool *used = calloc(scene->image_count + 1, sizeof *used);
  uint64_t *first_texel = calloc(scene->image_count + 1, sizeof *first_texel);
  flat->textures = calloc(scene->texture_count + 1, sizeof *flat->textures);
  flat->texture_count = scene->texture_count;
  if (!used || !first_texel || !flat->textures) {
    status = log_no_memory(log, scene->path);
    goto done;
  }
  for (uint32_t m = 0; m < scene->material_count; m++) material_mark_images(used, &scene->materials[m], scene);
  for (uint32_t i = 0; i < scene->image_count; i++) {
    if (!used[i] || !scene->images[i].texels) continue;
    first_texel[i] = flat->texel_count;
    flat->texel_count += (uint64_t)scene->images[i].width * scene->images[i].height;
  }
  if (flat->texel_count >= 1u << 31) {
    status = log_fail(log, STATUS_TOO_LARGE, "%s: %.0f million texels: scale its textures down", scene->path,
                      1e-6 * (double)flat->texel_count);
    goto done;
  }
  flat->texels = large_array(flat->texel_count + 1, 4);
  if (!flat->texels) {
    status = log_no_memory(log, scene->path);
    goto done;
  }
  for (uint32_t i = 0; i < scene->image_count; i++) {
    const Image *image = &scene->images[i];
    if (used[i] && image->texels)
      memcpy(flat->texels + 4 * first_texel[i], image->texels, (size_t)4 * image->width * image->height);
  }
  for (uint32_t t = 0; t < scene->texture_count; t++) {
    const Texture *from = &scene->textures[t];
    flat->textures[t] = (TextureInfo){
        .first_texel = (uint32_t)first_texel[from->image],
        .width = scene->images[from->image].width,
        .height = scene->images[from->image].height,
        .wrap_u = from->wrap_u,
        .wrap_v = from->wrap_v,
        .nearest = from->nearest,
    };
  }

done:
  free(used);
  free(first_texel);
  return status;
}

static Float3 float3_from_vec3(Vec3 v) { return (Float3){(float)v.x, (float)v.y, (float)v.z}; }

static LightInfo light_info(const Light *from)
{
  double inner = cos(from->inner_cone_rad), outer = cos(from->outer_cone_rad);
  double scale = 1 / fmax(1e-3, inner - outer);  // as KHR_lights_punctual recommends
  return (LightInfo){
      .kind = from->kind == LIGHT_POINT  ? LIGHT_KIND_POINT
              : from->kind == LIGHT_SPOT ? LIGHT_KIND_SPOT
                                         : LIGHT_KIND_DIRECTIONAL,
      .position = float3_from_vec3(from->position_world),
      .direction = float3_from_vec3(from->direction_world),
      .radiant = {from->color[0] * from->intensity, from->color[1] * from->intensity, from->color[2] * from->intensity},
      .range_m = (float)from->range_m,
      .spot_scale = (float)scale,
      .spot_offset = (float)(-outer * scale),
  };
}

void flat_lights_fill(LightInfo *out, const Scene *scene)
{
  for (uint32_t i = 0; i < scene->light_count; i++) out[i] = light_info(&scene->lights[i]);
}

Status flat_materials_make(FlatScene *flat, const Scene *scene, Log *log)
{
  Status status = STATUS_OK;
  flat->material_count = scene->material_count;
  flat->light_count = scene->light_count;
  flat->least_roughness = INFINITY;
  flat->materials = calloc(scene->material_count + 1, sizeof *flat->materials);
  flat->lights = calloc(scene->light_count + 1, sizeof *flat->lights);
  if (!flat->materials || !flat->lights) {
    status = log_no_memory(log, scene->path);
    goto done;
  }
  for (uint32_t i = 0; i < scene->material_count; i++) {
    flat->materials[i] = material_info(&scene->materials[i], flat->uv_set_count);
    material_roughness(flat, &scene->materials[i], scene);
  }
  flat_lights_fill(flat->lights, scene);
  TRY(textures_make(flat, scene, log));

done:
  return status;
}
