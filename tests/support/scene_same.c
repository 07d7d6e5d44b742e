#include "support/scene_same.h"

#include <string.h>

static bool array_same(const void *a, const void *b, uint64_t count, size_t element_bytes)
{
  return !a == !b && (!a || memcmp(a, b, count * element_bytes) == 0);
}

static bool primitives_same(const Primitive *a, const Primitive *b)
{
  uint64_t count = a->vertex_count;
  return a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count && a->material == b->material &&
         array_same(a->positions, b->positions, count, sizeof *a->positions) &&
         array_same(a->normals, b->normals, count, sizeof *a->normals) &&
         array_same(a->tangents, b->tangents, count, sizeof *a->tangents) &&
         array_same(a->uvs[0], b->uvs[0], count, sizeof *a->uvs[0]) &&
         array_same(a->uvs[1], b->uvs[1], count, sizeof *a->uvs[1]) &&
         array_same(a->colors, b->colors, count, sizeof *a->colors) &&
         array_same(a->triangles, b->triangles, a->triangle_count, sizeof *a->triangles);
}

static bool meshes_same(const Mesh *a, const Mesh *b)
{
  bool same = a->primitive_count == b->primitive_count;
  for (uint32_t i = 0; same && i < a->primitive_count; i++)
    same = primitives_same(&a->primitives[i], &b->primitives[i]);
  return same;
}

static bool matrices_same(const Mat4 *a, const Mat4 *b) { return memcmp(a, b, sizeof *a) == 0; }

static bool lights_same(const Light *a, const Light *b)
{
  return memcmp(&a->position_world, &b->position_world, sizeof a->position_world) == 0 &&
         memcmp(&a->direction_world, &b->direction_world, sizeof a->direction_world) == 0;
}

bool scenes_same(const Scene *a, const Scene *b)
{
  bool same = a->object_count == b->object_count && a->mesh_count == b->mesh_count &&
              a->camera_count == b->camera_count && a->light_count == b->light_count;
  for (uint32_t i = 0; same && i < a->mesh_count; i++) same = meshes_same(&a->meshes[i], &b->meshes[i]);
  for (uint32_t i = 0; same && i < a->object_count; i++)
    same = a->objects[i].mesh == b->objects[i].mesh &&
           matrices_same(&a->objects[i].world_from_object, &b->objects[i].world_from_object);
  for (uint32_t i = 0; same && i < a->camera_count; i++)
    same = matrices_same(&a->cameras[i].world_from_camera, &b->cameras[i].world_from_camera);
  for (uint32_t i = 0; same && i < a->light_count; i++) same = lights_same(&a->lights[i], &b->lights[i]);
  return same;
}
