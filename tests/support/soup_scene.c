#include "support/soup_scene.h"

#include <stdlib.h>
#include <string.h>

#include "shared/bvh.h"
#include "support/oracle_scene.h"

enum { MATERIALS = 4, TEXELS = 8 };

static void masks_make(Scene *scene, Random *random)
{
  scene->image_count = scene->texture_count = 2;
  scene->images = oracle_array(2, sizeof *scene->images);
  scene->textures = oracle_array(2, sizeof *scene->textures);
  for (int i = 0; i < 2; i++) {
    scene->images[i] = (Image){.width = TEXELS, .height = TEXELS, .texels = oracle_array(TEXELS * TEXELS, 4)};
    for (int texel = 0; texel < TEXELS * TEXELS; texel++)
      scene->images[i].texels[4 * texel + 3] = random_next(random) >> 31 ? 255 : 0;
    scene->textures[i] = (Texture){.image = i,
                                   .wrap_u = i ? WRAP_MIRROR : WRAP_REPEAT,
                                   .wrap_v = i ? WRAP_MIRROR : WRAP_REPEAT,
                                   .nearest = i == 0};
  }
}

static void materials_make(Scene *scene)
{
  const TextureSlot none = {.texture = NONE, .uv_from_uv = {1, 0, 0, 0, 1, 0}};
  scene->material_count = MATERIALS;
  scene->materials = oracle_array(MATERIALS, sizeof *scene->materials);
  for (unsigned flags = 0; flags < MATERIALS; flags++) {
    bool single_sided = flags & TRIANGLE_SINGLE_SIDED, masked = flags & TRIANGLE_MASKED;
    Material *material = &scene->materials[flags];
    *material = (Material){.base_color = {1, 1, 1, 1},
                           .roughness = 1,
                           .alpha_mode = masked ? ALPHA_MASK : ALPHA_OPAQUE,
                           .alpha_cutoff = 0.5f,
                           .double_sided = !single_sided,
                           .normal_scale = 1,
                           .occlusion_strength = 1,
                           .base_color_slot = none,
                           .metallic_roughness_slot = none,
                           .emission_slot = none,
                           .normal_slot = none,
                           .occlusion_slot = none};
    if (masked) material->base_color_slot.texture = single_sided;
  }
}

// Triangles [first, end) of the soup, which have the same flags.
static Primitive primitive_make(const Soup *soup, uint32_t first, uint32_t end, Random *random)
{
  uint32_t vertices = 3 * (end - first);
  Primitive primitive = {.vertex_count = vertices,
                         .triangle_count = end - first,
                         .positions = oracle_array(vertices, sizeof *primitive.positions),
                         .normals = oracle_array(vertices, sizeof *primitive.normals),
                         .triangles = oracle_array(end - first, sizeof *primitive.triangles),
                         .material = (int)soup->flags[first]};
  if (soup->flags[first] & TRIANGLE_MASKED) primitive.uvs[0] = oracle_array(vertices, sizeof *primitive.uvs[0]);
  for (uint32_t i = 0; i < vertices; i++) {
    const float *position = soup->positions[soup->triangles[first + i / 3][i % 3]];
    memcpy(primitive.positions[i], position, sizeof primitive.positions[i]);
    primitive.triangles[i / 3][i % 3] = i;
    for (int axis = 0; primitive.uvs[0] && axis < 2; axis++)
      primitive.uvs[0][i][axis] = 0.25f * ((float)(random_next(random) % 17) - 8);
  }
  return primitive;
}

Scene scene_from_soup(const Soup *soup)
{
  Random random = random_make(soup->triangle_count);
  Scene scene = {.path = strdup("soup"), .mesh_count = 1, .object_count = 1};
  uint32_t runs = 0, masked = 0;
  for (uint32_t i = 0; i < soup->triangle_count; i++) {
    runs += i == 0 || soup->flags[i] != soup->flags[i - 1];
    masked |= soup->flags[i] & TRIANGLE_MASKED;
  }
  if (masked) masks_make(&scene, &random);
  materials_make(&scene);
  // A scene without masks must not ask for the kernels that know them.
  if (!masked) scene.material_count = 2;
  scene.objects = oracle_array(1, sizeof *scene.objects);
  scene.objects[0].world_from_object = mat4_identity();
  scene.meshes = oracle_array(1, sizeof *scene.meshes);
  scene.meshes[0].primitives = oracle_array(runs, sizeof *scene.meshes[0].primitives);
  for (uint32_t first = 0, end; first < soup->triangle_count; first = end) {
    for (end = first + 1; end < soup->triangle_count && soup->flags[end] == soup->flags[first];) end++;
    scene.meshes[0].primitives[scene.meshes[0].primitive_count++] = primitive_make(soup, first, end, &random);
  }
  return scene;
}
