#include "support/oracle_scene.h"

#include <stdio.h>
#include <stdlib.h>

void *oracle_array(size_t count, size_t element_bytes)
{
  void *array = calloc(count ? count : 1, element_bytes);
  if (array) return array;
  fprintf(stderr, "oracle: out of memory\n");
  abort();
}

static OracleScene scene_make(uint32_t triangle_count)
{
  OracleScene scene = {.triangle_count = triangle_count,
                       .block_count = (triangle_count + ORACLE_BLOCK - 1) / ORACLE_BLOCK};
  scene.triangles = oracle_array(triangle_count, sizeof *scene.triangles);
  scene.blocks = oracle_array(scene.block_count, sizeof *scene.blocks);
  for (uint32_t i = triangle_count; i < scene.block_count * ORACLE_BLOCK; i++)
    for (int corner = 0; corner < 3; corner++)
      for (int axis = 0; axis < 3; axis++)
        scene.blocks[i / ORACLE_BLOCK].vertices[corner][axis][i % ORACLE_BLOCK] = NAN;
  return scene;
}

static void vertex_set(OracleScene *scene, uint32_t triangle, int corner, Vec3 position)
{
  float(*vertex)[ORACLE_BLOCK] = scene->blocks[triangle / ORACLE_BLOCK].vertices[corner];
  vertex[0][triangle % ORACLE_BLOCK] = (float)position.x;
  vertex[1][triangle % ORACLE_BLOCK] = (float)position.y;
  vertex[2][triangle % ORACLE_BLOCK] = (float)position.z;
}

static void lengths_measure(OracleScene *scene)
{
  Vec3 low = vec3(INFINITY, INFINITY, INFINITY), high = vec3_neg(low);
  for (uint32_t i = 0; i < scene->triangle_count; i++) {
    double longest = 0;
    for (int corner = 0; corner < 3; corner++) {
      Vec3 from = oracle_vertex(scene, i, corner), to = oracle_vertex(scene, i, (corner + 1) % 3);
      longest = fmax(longest, vec3_length(vec3_sub(to, from)));
      low = vec3_min(low, from);
      high = vec3_max(high, from);
    }
    scene->blocks[i / ORACLE_BLOCK].longest_m[i % ORACLE_BLOCK] = (float)(longest * 1.0001);
  }
  scene->scale_m = scene->triangle_count ? vec3_length(vec3_sub(high, low)) : 0;
}

Vec3 oracle_vertex(const OracleScene *scene, uint32_t triangle, int corner)
{
  const float(*vertex)[ORACLE_BLOCK] = scene->blocks[triangle / ORACLE_BLOCK].vertices[corner];
  uint32_t slot = triangle % ORACLE_BLOCK;
  return vec3(vertex[0][slot], vertex[1][slot], vertex[2][slot]);
}

const Primitive *oracle_primitive(const OracleScene *scene, uint32_t triangle)
{
  const OracleTriangle *at = &scene->triangles[triangle];
  return &scene->model->meshes[scene->model->objects[at->object].mesh].primitives[at->primitive];
}

const Material *oracle_material(const OracleScene *scene, uint32_t triangle)
{
  return &scene->model->materials[oracle_primitive(scene, triangle)->material];
}

static void primitive_bake(OracleScene *scene, uint32_t first, uint32_t object, uint32_t number)
{
  const Mat4 *world_from_object = &scene->model->objects[object].world_from_object;
  const Primitive *primitive = &scene->model->meshes[scene->model->objects[object].mesh].primitives[number];
  const Material *material = &scene->model->materials[primitive->material];
  bool mirrored = mat4_determinant3(world_from_object) < 0;
  for (uint32_t i = 0; i < primitive->triangle_count; i++) {
    const uint32_t *corners = primitive->triangles[i];
    OracleTriangle *triangle = &scene->triangles[first + i];
    *triangle = (OracleTriangle){.object = object,
                                 .primitive = number,
                                 .index = i,
                                 .corners = {corners[0], corners[mirrored ? 2 : 1], corners[mirrored ? 1 : 2]},
                                 .flags = (material->double_sided ? 0 : ORACLE_SINGLE_SIDED) |
                                          (material->alpha_mode == ALPHA_OPAQUE ? 0 : ORACLE_SEE_THROUGH)};
    for (int corner = 0; corner < 3; corner++) {
      Vec3 position_object = vec3_from_floats(primitive->positions[triangle->corners[corner]]);
      vertex_set(scene, first + i, corner, mat4_point(world_from_object, position_object));
    }
  }
}

OracleScene oracle_scene_from_model(const Scene *model)
{
  uint32_t count = 0;
  for (uint32_t o = 0; o < model->object_count; o++) {
    const Mesh *mesh = &model->meshes[model->objects[o].mesh];
    for (uint32_t p = 0; p < mesh->primitive_count; p++) count += mesh->primitives[p].triangle_count;
  }
  OracleScene scene = scene_make(count);
  scene.model = model;
  uint32_t first = 0;
  for (uint32_t o = 0; o < model->object_count; o++) {
    const Mesh *mesh = &model->meshes[model->objects[o].mesh];
    for (uint32_t p = 0; p < mesh->primitive_count; first += mesh->primitives[p++].triangle_count)
      primitive_bake(&scene, first, o, p);
  }
  lengths_measure(&scene);
  return scene;
}

void oracle_scene_free(OracleScene *scene)
{
  free(scene->triangles);
  free(scene->blocks);
  *scene = (OracleScene){0};
}
