#include "device_scene/device_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "device_scene/part_bvh.h"

// The root's box.
static void bvh2_bounds(DeviceScene *out, const Bvh2 *bvh)
{
  Vec3 low = vec3(INFINITY, INFINITY, INFINITY), high = vec3(-INFINITY, -INFINITY, -INFINITY);
  for (int child = 0; child < 2 && bvh->node_count > 0; child++) {
    const float(*bounds)[2] = bvh->nodes[0].bounds[child];
    low = vec3_min(low, vec3(bounds[0][0], bounds[1][0], bounds[2][0]));
    high = vec3_max(high, vec3(bounds[0][1], bounds[1][1], bounds[2][1]));
  }
  Vec3 size = vec3_sub(high, low);
  if (!vec3_is_finite(size)) return;
  out->low = low;
  out->high = high;
  out->extent_m = vec3_length(size);
}

static Status bvh_upload(DeviceScene *out, Device *device, const FlatScene *flat, Timeline *timeline, Log *log)
{
  Status status = STATUS_OK;
  Bvh2 bvh2 = {0};
  Bvh8 bvh8 = {0};
  double begin_ms = clock_ms();
  TRY(flat_bvh_make(&bvh2, flat, log));
  bvh2_bounds(out, &bvh2);
  if (device_traits(device)->wide_bvh) TRY(bvh8_from_bvh2(&bvh8, &bvh2, log));
  if (timeline) timeline_end(timeline, "build the BVH", begin_ms);

  begin_ms = clock_ms();
  TRY(buffer_create(&out->bvh2_nodes, device, (size_t)bvh2.node_count * sizeof *bvh2.nodes, bvh2.nodes, "BVH nodes",
                    log));
  TRY(buffer_create(&out->bvh2_triangles, device, (size_t)bvh2.triangle_count * sizeof *bvh2.triangles, bvh2.triangles,
                    "BVH triangles", log));
  TRY(buffer_create(&out->bvh8_nodes, device, (size_t)bvh8.node_count * sizeof *bvh8.nodes, bvh8.nodes,
                    "wide BVH nodes", log));
  TRY(buffer_create(&out->bvh8_blocks, device, (size_t)bvh8.block_count * sizeof *bvh8.blocks, bvh8.blocks,
                    "wide BVH blocks", log));
  if (timeline) timeline_end(timeline, "upload the BVH", begin_ms);

done:
  bvh2_free(&bvh2);
  bvh8_free(&bvh8);
  return status;
}

// [0, 256): sRGB byte to linear; [256, 512): byte / 255.
static void decode_tables(float tables[512])
{
  for (int i = 0; i < 256; i++) {
    double s = i / 255.0;
    tables[i] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
    tables[256 + i] = (float)s;
  }
}

static Status arrays_upload(DeviceScene *out, Device *device, const FlatScene *flat, const Environment *environment,
                            Log *log)
{
  Status status = STATUS_OK;
  float tables[512];
  decode_tables(tables);
  const size_t vertices = flat->vertex_count, triangles = flat->triangle_count;
  const Image *image = &environment->image;
  const size_t pixels = environment->kind == ENVIRONMENT_IMAGE ? (size_t)image->width * image->height : 0;
  const struct {
    DeviceBuffer *buffer;
    size_t bytes;
    const void *from;
    const char *what;
  } arrays[] = {
      {&out->positions, vertices * sizeof *flat->positions, flat->positions, "positions"},
      {&out->normals, vertices * sizeof *flat->normals, flat->normals, "normals"},
      {&out->tangents, flat->tangents ? vertices * sizeof *flat->tangents : 0, flat->tangents, "tangents"},
      {&out->uvs, vertices * flat->uv_set_count * sizeof *flat->uvs, flat->uvs, "texture coordinates"},
      {&out->colors, flat->colors ? vertices * sizeof *flat->colors : 0, flat->colors, "vertex colours"},
      {&out->corners, triangles * sizeof *flat->corners, flat->corners, "triangles"},
      {&out->object_starts, (flat->object_count + 1) * sizeof *flat->object_starts, flat->object_starts, "objects"},
      {&out->materials, flat->material_count * sizeof *flat->materials, flat->materials, "materials"},
      {&out->textures, flat->texture_count * sizeof *flat->textures, flat->textures, "texture table"},
      {&out->texels, flat->texel_count * 4, flat->texels, "textures"},
      {&out->linear_from_byte, sizeof tables, tables, "decoding tables"},
      {&out->lights, flat->light_count * sizeof *flat->lights, flat->lights, "lights"},
      {&out->environment, sizeof flat->environment, &flat->environment, "environment"},
      {&out->environment_pixels, pixels * 4 * sizeof *image->pixels, image->pixels, "environment image"},
  };
  for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
    TRY(buffer_create(arrays[i].buffer, device, arrays[i].bytes, arrays[i].from, arrays[i].what, log));

done:
  return status;
}

Status device_scene_make(DeviceScene *out, Device *device, const Scene *scene, Timeline *timeline, Log *log)
{
  Status status = STATUS_OK;
  FlatScene flat = {0};
  DeviceScene made = {0};
  double begin_ms = clock_ms();
  TRY(flat_scene_make(&flat, scene, log));
  if (timeline) timeline_end(timeline, "flatten the scene", begin_ms);
  TRY(bvh_upload(&made, device, &flat, timeline, log));
  begin_ms = clock_ms();
  TRY(arrays_upload(&made, device, &flat, &scene->environment, log));
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
  *out = made;
  made = (DeviceScene){0};

done:
  flat_scene_free(&flat);
  device_scene_free(&made);
  return status;
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
    for (uint32_t p = 0; p < mesh->primitive_count; p++) {
      out->has_colors |= mesh->primitives[p].colors != NULL;
      out->has_normal_maps |= primitive_has_normal_map(&mesh->primitives[p], scene);
    }
  }
}

void device_scene_options(const DeviceScene *scene, char *out, size_t size)
{
  snprintf(out, size, "%s%s%s%s%s", scene->has_textures ? "-D HAS_TEXTURES " : "",
           scene->has_colors ? "-D HAS_VERTEX_COLORS " : "", scene->has_masks ? "-D HAS_MASK " : "",
           scene->has_normal_maps ? "-D HAS_NORMAL_MAPS " : "", scene->has_blends ? "-D HAS_BLEND " : "");
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
