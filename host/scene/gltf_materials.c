#include "scene/gltf_materials.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "scene/gltf_uri.h"

enum { SLOT_COUNT = 5 };

static void slots_of(TextureSlot *out[SLOT_COUNT], Material *material)
{
  out[0] = &material->base_color_slot;
  out[1] = &material->metallic_roughness_slot;
  out[2] = &material->emission_slot;
  out[3] = &material->normal_slot;
  out[4] = &material->occlusion_slot;
}

static float clamped(float x, float low, float high) { return fminf(fmaxf(x, low), high); }

// Into the ranges that glTF's schema gives; what is beyond a float's range is the largest float.
static void factors_clamp(Material *material)
{
  for (int c = 0; c < 4; c++) material->base_color[c] = clamped(material->base_color[c], 0, 1);
  for (int c = 0; c < 3; c++) material->emission[c] = clamped(material->emission[c], 0, 3.4e38f);
  material->metallic = clamped(material->metallic, 0, 1);
  material->roughness = clamped(material->roughness, 0, 1);
  material->alpha_cutoff = clamped(material->alpha_cutoff, 0, 3.4e38f);
  material->occlusion_strength = clamped(material->occlusion_strength, 0, 1);
}

static Status image_decode(Image *out, Gltf *gltf, uint32_t index)
{
  Status status = STATUS_OK;
  const GltfImageSource *from = &gltf->images[index];
  GltfBytes data = {0};
  char *path = NULL, name[600];
  snprintf(name, sizeof name, "%.500s: images[%u]", gltf->path, index);
  if (from->view != NONE) {
    const GltfView *view = &gltf->model->views[from->view];
    data.bytes = gltf->buffers[view->buffer].bytes + view->offset;
    data.size = view->size;
  } else if (!from->uri) {
    status = gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "images[%u] has neither uri nor bufferView", index);
    goto done;
  } else if (gltf_uri_is_data(from->uri)) {
    TRY(gltf_uri_decode_data(&data, gltf, from->uri));
  } else {
    TRY(gltf_uri_resolve(&path, gltf, from->uri));
  }
  TRY(image_read(out, gltf->images_helper, IMAGE_TEXTURE, path ? path : name, data.bytes, data.size, gltf->log));

done:
  free(data.owned);
  free(path);
  return status;
}

// Index of the scene's texture for the file's; NONE where the texture has no image that is read.
static void texture_use(int *texture, Scene *scene, Gltf *gltf, int *texture_of, int *image_of)
{
  const GltfTexture *from = &gltf->model->textures[*texture];
  int *known = &texture_of[*texture];
  if (*known == NONE && from->image == NONE)
    log_warn(gltf->log, "%s: textures[%d] has no image that is read: it is left out", gltf->path, *texture);
  if (*known == NONE && from->image != NONE) {
    int *image = &image_of[from->image];
    if (*image == NONE) {
      *image = (int)scene->image_count++;
    }
    *known = (int)scene->texture_count;
    scene->textures[scene->texture_count++] =
        (Texture){.image = *image, .wrap_u = from->wrap_u, .wrap_v = from->wrap_v, .nearest = from->nearest};
  }
  *texture = *known;
}

static void slots_convert(Material *material, bool used, Scene *scene, Gltf *gltf, int *texture_of, int *image_of)
{
  TextureSlot *slots[SLOT_COUNT];
  slots_of(slots, material);
  for (int i = 0; i < SLOT_COUNT; i++) {
    if (!used) slots[i]->texture = NONE;
    if (slots[i]->texture == NONE) continue;
    if (slots[i]->uv_set > 1) {
      log_warn(gltf->log, "%s: the material '%.64s' reads TEXCOORD_%u: TEXCOORD_0 is taken", gltf->path, material->name,
               slots[i]->uv_set);
      slots[i]->uv_set = 0;
    }
    texture_use(&slots[i]->texture, scene, gltf, texture_of, image_of);
  }
}

// used[i]: does a primitive of the scene have material i?
static void materials_mark(bool *used, const Scene *scene)
{
  for (uint32_t m = 0; m < scene->mesh_count; m++)
    for (uint32_t p = 0; p < scene->meshes[m].primitive_count; p++)
      used[scene->meshes[m].primitives[p].material] = true;
}

Status gltf_materials_read(Scene *scene, Gltf *gltf)
{
  Status status = STATUS_OK;
  const GltfModel *model = gltf->model;
  bool *used = NULL;
  int *texture_of = NULL, *image_of = NULL;
  TRY(gltf_allocate(&used, gltf, model->material_count + 1ull, sizeof *used));
  TRY(gltf_allocate(&texture_of, gltf, model->texture_count, sizeof *texture_of));
  TRY(gltf_allocate(&image_of, gltf, gltf->image_count, sizeof *image_of));
  TRY(gltf_allocate(&scene->materials, gltf, model->material_count + 1ull, sizeof *scene->materials));
  TRY(gltf_allocate(&scene->textures, gltf, model->texture_count, sizeof *scene->textures));
  TRY(gltf_allocate(&scene->images, gltf, gltf->image_count, sizeof *scene->images));
  for (uint32_t i = 0; i < model->texture_count; i++) texture_of[i] = NONE;
  for (uint32_t i = 0; i < gltf->image_count; i++) image_of[i] = NONE;
  materials_mark(used, scene);
  for (uint32_t i = 0; i < model->material_count + used[model->material_count]; i++) {
    Material material = i < model->material_count ? model->materials[i] : material_default();
    const char *name = material.name;
    slots_convert(&material, used[i], scene, gltf, texture_of, image_of);
    factors_clamp(&material);
    TRY(gltf_copy_name(&material.name, gltf, name));
    scene->materials[scene->material_count++] = material;
  }
  if (gltf->options->structure_known) gltf->options->structure_known(gltf->options->context, scene);
  for (uint32_t i = 0; i < gltf->image_count; i++)
    if (image_of[i] != NONE) TRY(image_decode(&scene->images[image_of[i]], gltf, i));

done:
  free(used);
  free(texture_of);
  free(image_of);
  return status;
}
