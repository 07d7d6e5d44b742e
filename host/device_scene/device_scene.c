#include "device_scene/device_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "device_scene/kept_scene.h"

static Status trees_make(DeviceScene *out, SceneTrees *trees, Device *device, const FlatScene *flat, bool movable,
                         Timeline *timeline, Log *log)
{
  Status status = STATUS_OK;
  double begin_ms = clock_ms();
  TRY(scene_trees_build(trees, device, flat, log));
  if (timeline) timeline_end(timeline, "build the BVH", begin_ms);
  begin_ms = clock_ms();
  TRY(movable ? scene_trees_put(out, device, trees, log) : scene_trees_give(out, device, trees, log));
  if (timeline) timeline_end(timeline, "upload the BVH", begin_ms);

done:
  return status;
}

enum { DECODE_TABLES = 512 };  // words of both

// [0, 256): sRGB byte to linear; [256, 512): byte / 255. DECODE_TABLES words behind each: the lower halves of its
// entries, and then the upper ones (cl/lib/texel.cl).
static void decode_tables(float tables[2 * DECODE_TABLES])
{
  for (int i = 0; i < 256; i++) {
    double s = i / 255.0;
    tables[i] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
    tables[256 + i] = (float)s;
  }
  uint16_t *halves = (uint16_t *)(tables + DECODE_TABLES);
  for (int i = 0; i < DECODE_TABLES; i++) {
    uint32_t bits;
    memcpy(&bits, &tables[i], sizeof bits);
    int place = i / 256 * 512 + i % 256;
    halves[place] = (uint16_t)bits;
    halves[place + 256] = (uint16_t)(bits >> 16);
  }
}

// With `give` nobody needs the flat scene's large arrays here any more: on a CPU device they become the buffers' own.
static Status arrays_upload(DeviceScene *out, Device *device, FlatScene *flat, const Environment *environment,
                            bool give, Log *log)
{
  enum { LARGE = 7 };  // the first of them
  Status status = STATUS_OK;
  float tables[2 * DECODE_TABLES];
  decode_tables(tables);
  const size_t vertices = flat->vertex_count, triangles = flat->triangle_count;
  const Image *image = &environment->image;
  const size_t pixels = environment->kind == ENVIRONMENT_IMAGE ? (size_t)image->width * image->height : 0;
  const struct {
    DeviceBuffer *buffer;
    size_t bytes;
    void *from;
    const char *what;
  } arrays[] = {
      {&out->positions, vertices * sizeof *flat->positions, flat->positions, "positions"},
      {&out->normals, vertices * sizeof *flat->normals, flat->normals, "normals"},
      {&out->tangents, flat->tangents ? vertices * sizeof *flat->tangents : 0, flat->tangents, "tangents"},
      {&out->uvs, vertices * flat->uv_set_count * sizeof *flat->uvs, flat->uvs, "texture coordinates"},
      {&out->colors, flat->colors ? vertices * sizeof *flat->colors : 0, flat->colors, "vertex colours"},
      {&out->corners, triangles * sizeof *flat->corners, flat->corners, "triangles"},
      {&out->texels, flat->texel_count * 4, flat->texels, "textures"},
      {&out->object_starts, (flat->object_count + 1) * sizeof *flat->object_starts, flat->object_starts, "objects"},
      {&out->materials, flat->material_count * sizeof *flat->materials, flat->materials, "materials"},
      {&out->textures, flat->texture_count * sizeof *flat->textures, flat->textures, "texture table"},
      {&out->linear_from_byte, sizeof tables, tables, "decoding tables"},
      {&out->lights, flat->light_count * sizeof *flat->lights, flat->lights, "lights"},
      {&out->environment, sizeof flat->environment, &flat->environment, "environment"},
      {&out->environment_pixels, pixels * 4 * sizeof *image->pixels, image->pixels, "environment image"},
  };
  for (size_t i = 0; give && i < LARGE; i++) {
    if (status)
      free(arrays[i].from);
    else
      status = buffer_adopt(arrays[i].buffer, device, arrays[i].bytes, arrays[i].from, arrays[i].what, log);
  }
  if (give) flat_scene_forget(flat);
  for (size_t i = give ? LARGE : 0; i < sizeof arrays / sizeof *arrays && !status; i++)
    status = buffer_create(arrays[i].buffer, device, arrays[i].bytes, arrays[i].from, arrays[i].what, log);
  return status;
}

static Status scene_make(DeviceScene *out, Device *device, const Scene *scene, bool movable, Timeline *timeline,
                         Log *log)
{
  Status status = STATUS_OK;
  FlatScene flat = {0};
  DeviceScene made = {0};
  SceneTrees trees = {0};
  double begin_ms = clock_ms();
  TRY(flat_scene_make(&flat, scene, log));
  if (timeline) timeline_end(timeline, "flatten the scene", begin_ms);
  TRY(trees_make(&made, &trees, device, &flat, movable, timeline, log));
  begin_ms = clock_ms();
  TRY(arrays_upload(&made, device, &flat, &scene->environment, !movable, log));
  if (timeline) timeline_end(timeline, "upload the scene", begin_ms);
  made.vertex_count = flat.vertex_count;
  made.triangle_count = flat.triangle_count;
  made.object_count = flat.object_count;
  made.light_count = flat.light_count;
  made.light_infos = flat.lights;
  flat.lights = NULL;
  made.material_count = flat.material_count;
  device_scene_features(&made, scene);
  made.has_mirrors = flat.has_mirrors;
  made.environment_lights = flat.environment_lights;
  made.source = scene;
  made.least_roughness = flat.least_roughness;
  if (movable) {
    TRY(kept_scene_make(&made.kept, &flat, &trees, scene, log));
    made.movers = calloc((size_t)made.object_count + 1, sizeof *made.movers);
    if (!made.movers) {
      status = log_no_memory(log, scene->path);
      goto done;
    }
  }
  *out = made;
  made = (DeviceScene){0};

done:
  scene_trees_free(&trees);
  flat_scene_free(&flat);
  device_scene_free(&made);
  return status;
}

Status device_scene_make(DeviceScene *out, Device *device, const Scene *scene, Timeline *timeline, Log *log)
{
  return scene_make(out, device, scene, false, timeline, log);
}

Status device_scene_make_movable(DeviceScene *out, Device *device, const Scene *scene, Timeline *timeline, Log *log)
{
  return scene_make(out, device, scene, true, timeline, log);
}

void device_scene_free(DeviceScene *scene)
{
  DeviceBuffer *buffers[] = {&scene->positions,   &scene->normals,        &scene->uvs,
                             &scene->colors,      &scene->corners,        &scene->object_starts,
                             &scene->materials,   &scene->textures,       &scene->texels,
                             &scene->lights,      &scene->environment,    &scene->environment_pixels,
                             &scene->bvh2_nodes,  &scene->bvh8_nodes,     &scene->linear_from_byte,
                             &scene->bvh8_blocks, &scene->bvh2_triangles, &scene->tangents};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) buffer_free(buffers[i]);
  free(scene->light_infos);
  free(scene->movers);
  kept_scene_free(scene->kept);
  *scene = (DeviceScene){0};
}

void device_scene_features(DeviceScene *out, const Scene *scene)
{
  out->has_textures = scene->texture_count > 0;
  for (uint32_t i = 0; i < scene->material_count; i++) {
    out->has_masks |= scene->materials[i].alpha_mode == ALPHA_MASK;
    out->has_blends |= scene->materials[i].alpha_mode == ALPHA_BLEND;
  }
  for (uint32_t o = 0; o < scene->object_count; o++) {
    const Mesh *mesh = &scene->meshes[scene->objects[o].mesh];
    out->has_shadowless |= scene->objects[o].shadowless;
    for (uint32_t p = 0; p < mesh->primitive_count; p++) {
      out->has_second_uvs |= out->has_textures && mesh->primitives[p].uvs[1];
      out->has_colors |= mesh->primitives[p].colors != NULL;
      out->has_normal_maps |= primitive_has_normal_map(&mesh->primitives[p], scene);
    }
  }
}

void device_scene_options(const DeviceScene *scene, uint32_t uses, char *out, size_t size)
{
  const bool masks = scene->has_masks && uses & TESTS_MASKS, blends = scene->has_blends && uses & TESTS_BLENDS;
  const bool surfaces = uses & READS_SURFACES, samples = surfaces || masks || blends;
  snprintf(out, size, "%s%s%s%s%s%s%s", samples && scene->has_textures ? "-D HAS_TEXTURES " : "",
           samples && scene->has_second_uvs ? "-D HAS_SECOND_UVS " : "",
           samples && scene->has_colors ? "-D HAS_VERTEX_COLORS " : "", masks ? "-D HAS_MASK " : "",
           surfaces && scene->has_normal_maps ? "-D HAS_NORMAL_MAPS " : "", blends ? "-D HAS_BLEND " : "",
           scene->has_shadowless && uses & SKIPS_SHADOWLESS ? "-D HAS_SHADOWLESS " : "");
}

uint32_t object_of_triangle(const uint32_t *object_starts, uint32_t object_count, uint32_t triangle)
{
  uint32_t low = 0, high = object_count;
  while (high - low > 1) {
    uint32_t middle = (low + high) / 2;
    if (object_starts[middle] <= triangle)
      low = middle;
    else
      high = middle;
  }
  return low;
}
