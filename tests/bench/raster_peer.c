#include "bench/raster_peer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void out_of_memory(void)
{
  fprintf(stderr, "bench_raster: out of memory\n");
  exit(1);
}

// Number of each vertex among those with positions of their own, whose numbers `firsts` gets. Returns how many.
static uint32_t vertices_weld(const FlatScene *flat, uint32_t *numbers, uint32_t *firsts)
{
  uint32_t count = 0, size = 4;
  while (size < 2 * flat->vertex_count) size *= 2;
  uint32_t *table = calloc(size, sizeof *table);
  if (!table) out_of_memory();
  for (uint32_t i = 0; i < flat->vertex_count; i++) {
    uint32_t words[3];
    memcpy(words, flat->positions[i], sizeof words);
    uint64_t hash = (words[0] * 0x9e3779b97f4a7c15u + words[1]) * 0x9e3779b97f4a7c15u + words[2];
    uint32_t at = (uint32_t)((hash * 0x9e3779b97f4a7c15u) >> 32) & (size - 1);
    while (table[at] && memcmp(flat->positions[firsts[table[at] - 1]], words, sizeof words)) at = (at + 1) & (size - 1);
    if (!table[at]) {
      firsts[count++] = i;
      table[at] = count;
    }
    numbers[i] = table[at] - 1;
  }
  free(table);
  return count;
}

// Vertices welded by position, for what draws depth alone. Returns how many are left.
static uint32_t shape_give(GlPeer *peer, const FlatScene *flat)
{
  uint32_t *numbers = calloc(flat->vertex_count, sizeof *numbers), *firsts = calloc(flat->vertex_count, sizeof *firsts);
  float(*positions)[3] = calloc(flat->vertex_count, sizeof *positions);
  uint32_t(*triangles)[3] = calloc(flat->triangle_count, sizeof *triangles);
  if (!numbers || !firsts || !positions || !triangles) out_of_memory();
  uint32_t count = vertices_weld(flat, numbers, firsts);
  for (uint32_t i = 0; i < count; i++) memcpy(positions[i], flat->positions[firsts[i]], sizeof positions[i]);
  for (uint32_t i = 0; i < flat->triangle_count; i++)
    for (int k = 0; k < 3; k++) triangles[i][k] = numbers[flat->corners[i].vertex[k]];
  gl_peer_scene(peer, positions, count, triangles, flat->triangle_count);
  free(numbers);
  free(firsts);
  free(positions);
  free(triangles);
  return count;
}

// False where the peer's shader lacks something of the material.
static bool material_give(GlMaterial *out, const MaterialInfo *material, const FlatScene *flat)
{
  static const float identity[6] = {1, 0, 0, 0, 1, 0};
  const TextureUse *base = &material->base_color_use;
  const uint32_t others[] = {material->metallic_roughness_use.texture, material->emission_use.texture,
                             material->normal_use.texture, material->occlusion_use.texture};
  for (size_t i = 0; i < sizeof others / sizeof *others; i++)
    if (others[i] != TEXTURE_NONE) return false;
  bool textured = base->texture != TEXTURE_NONE;
  if (textured) {
    const TextureInfo *texture = &flat->textures[base->texture];
    if (base->uv_set || memcmp(base->matrix, identity, sizeof identity) || texture->wrap_u != WRAP_MODE_REPEAT ||
        texture->wrap_v != WRAP_MODE_REPEAT)
      return false;
  }
  *out = (GlMaterial){.metallic = material->metallic, .roughness = material->roughness};
  memcpy(out->base, material->base_color, sizeof out->base);
  memcpy(out->emission, material->emission, sizeof material->emission);
  return !(material->flags & MATERIAL_UNLIT);
}

static void surfaces_give(GlPeer *peer, const FlatScene *flat)
{
  GlMaterial materials[GL_PEER_MATERIALS];
  GlTexture textures[GL_PEER_TEXTURES];
  uint32_t *material_of_vertex = calloc(flat->vertex_count, sizeof *material_of_vertex);
  uint32_t(*triangles)[3] = calloc(flat->triangle_count, sizeof *triangles);
  float(*no_uvs)[2] = calloc(flat->vertex_count, sizeof *no_uvs);
  if (!material_of_vertex || !triangles || !no_uvs) out_of_memory();
  bool fits = flat->material_count <= GL_PEER_MATERIALS && flat->texture_count <= GL_PEER_TEXTURES;
  for (uint32_t i = 0; fits && i < flat->material_count; i++)
    fits = material_give(&materials[i], &flat->materials[i], flat);
  if (!fits) {
    fprintf(stderr, "bench_raster: the scene has maps or more materials than the peer's shader: choose another\n");
    exit(1);
  }
  for (uint32_t i = 0; i < flat->texture_count; i++) {
    const TextureInfo *info = &flat->textures[i];
    textures[i] = (GlTexture){flat->texels + 4 * (size_t)info->first_texel, info->width, info->height, info->nearest};
  }
  GlSurfaces surfaces = {
      (const float(*)[3])flat->positions,
      (const float(*)[3])flat->normals,
      flat->uv_set_count ? (const float(*)[2])flat->uvs : (const float(*)[2])no_uvs,
      (const float(*)[4])flat->colors,
      material_of_vertex,
      flat->vertex_count,
      (const uint32_t(*)[3])triangles,
      flat->triangle_count,
      {{0}},
      materials,
      flat->material_count,
      textures,
      flat->texture_count,
  };
  size_t at = 0;
  for (uint32_t range = 0; range <= flat->texture_count; range++) {
    surfaces.ranges[range].first = at;
    for (uint32_t i = 0; i < flat->triangle_count; i++) {
      const TriangleCorners *corners = &flat->corners[i];
      uint32_t texture = flat->materials[corners->material].base_color_use.texture;
      if ((texture == TEXTURE_NONE ? 0 : texture + 1) != range) continue;
      memcpy(triangles[at++], corners->vertex, sizeof *triangles);
      for (int k = 0; k < 3; k++) material_of_vertex[corners->vertex[k]] = corners->material;
    }
    surfaces.ranges[range].count = at - surfaces.ranges[range].first;
  }
  gl_peer_surfaces(peer, &surfaces);
  free(material_of_vertex);
  free(triangles);
  free(no_uvs);
}

uint32_t raster_peer_take(GlPeer *peer, const FlatScene *flat)
{
  uint32_t count = shape_give(peer, flat);
  surfaces_give(peer, flat);
  return count;
}
