#include "support/soup_scene.h"

#include <stdlib.h>
#include <string.h>

#include "scene/scene_build.h"
#include "shared/bvh.h"
#include "support/oracle_scene.h"

enum { TEXELS = 8 };

// Textures 0 and 1.
static void masks_make(Scene *scene, Random *random)
{
  for (int i = 0; i < 2; i++) {
    uint8_t texels[TEXELS * TEXELS][4] = {{0}};
    for (int texel = 0; texel < TEXELS * TEXELS; texel++) texels[texel][3] = random_next(random) >> 31 ? 255 : 0;
    int index = scene_add_texture(scene, TEXELS, TEXELS, (const uint8_t(*)[4])texels);
    Texture *texture = &scene->textures[index];
    texture->wrap_u = texture->wrap_v = i ? WRAP_MIRROR : WRAP_REPEAT;
    texture->nearest = i == 0;
  }
}

static void materials_make(Scene *scene, unsigned count)
{
  for (unsigned flags = 0; flags < count; flags++) {
    Material material = material_plain(vec3(1, 1, 1), 0, 1);
    material.double_sided = !(flags & TRIANGLE_SINGLE_SIDED);
    if (flags & TRIANGLE_MASKED) {
      material.alpha_mode = ALPHA_MASK;
      material.base_color_slot.texture = material.double_sided ? 0 : 1;
    }
    scene_add_material(scene, material);
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
  Scene scene = scene_empty();
  uint32_t runs = 0, masked = 0;
  for (uint32_t i = 0; i < soup->triangle_count; i++) {
    runs += i == 0 || soup->flags[i] != soup->flags[i - 1];
    masked |= soup->flags[i] & TRIANGLE_MASKED;
  }
  if (masked) masks_make(&scene, &random);
  materials_make(&scene, masked ? 4 : 2);  // without masks, kernels without their code
  scene.object_count = scene.mesh_count = 1;
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
