#include <stdlib.h>

#include "base/parallel.h"
#include "device_scene/flat_scene.h"
#include "shared/bvh.h"

// One primitive of one object: where its vertices and triangles go.
typedef struct Draw {
  const Primitive *primitive;
  const Object *object;
  uint32_t first_vertex, first_triangle;
} Draw;

typedef struct Flattening {
  FlatScene *flat;
  const Scene *scene;
  Draw *draws;
} Flattening;

bool primitive_has_normal_map(const Primitive *primitive, const Scene *scene)
{
  return primitive->uvs[0] && scene->materials[primitive->material].normal_slot.texture != NONE;
}

static Float4 tangent_world(const Mat4 *world_from_object, const float tangent[4], double side)
{
  Vec3 world = vec3_unit_or(mat4_direction(world_from_object, vec3_from_floats(tangent)), vec3(0, 0, 0));
  return (Float4){(float)world.x, (float)world.y, (float)world.z, (float)(tangent[3] * side)};
}

static void vertices_flatten(FlatScene *flat, const Draw *draw)
{
  const Primitive *from = draw->primitive;
  const Mat4 *world_from_object = &draw->object->world_from_object;
  double side = mat4_determinant3(world_from_object) < 0 ? -1 : 1;
  for (uint32_t i = 0; i < from->vertex_count; i++) {
    size_t at = (size_t)draw->first_vertex + i;
    Vec3 position = mat4_point(world_from_object, vec3_from_floats(from->positions[i]));
    Vec3 normal = mat4_normal(world_from_object, vec3_from_floats(from->normals[i]));
    normal = vec3_scale(vec3_unit_or(normal, vec3(0, 0, 0)), side);
    flat->positions[at][0] = (float)position.x;
    flat->positions[at][1] = (float)position.y;
    flat->positions[at][2] = (float)position.z;
    flat->normals[at][0] = (float)normal.x;
    flat->normals[at][1] = (float)normal.y;
    flat->normals[at][2] = (float)normal.z;
    if (flat->tangents)
      flat->tangents[at] = from->tangents ? tangent_world(world_from_object, from->tangents[i], side) : (Float4){0};
    for (uint32_t set = 0; set < flat->uv_set_count; set++) {
      const float(*uvs)[2] = from->uvs[set] ? (const float(*)[2])from->uvs[set] : NULL;
      flat->uvs[(size_t)set * flat->vertex_count + at] = uvs ? (Float2){uvs[i][0], uvs[i][1]} : (Float2){0, 0};
    }
    if (flat->colors) {
      const float *c = from->colors ? from->colors[i] : (const float[4]){1, 1, 1, 1};
      flat->colors[at] = (Float4){c[0], c[1], c[2], c[3]};
    }
  }
}

static void draw_flatten(void *context, size_t index)
{
  Flattening *work = context;
  FlatScene *flat = work->flat;
  const Draw *draw = &work->draws[index];
  const Primitive *from = draw->primitive;
  const Material *material = &work->scene->materials[from->material];
  vertices_flatten(flat, draw);
  bool mirrored = mat4_determinant3(&draw->object->world_from_object) < 0;
  uint32_t flags =
      (material->double_sided ? 0 : TRIANGLE_SINGLE_SIDED) | (material->alpha_mode == ALPHA_MASK    ? TRIANGLE_MASKED
                                                              : material->alpha_mode == ALPHA_BLEND ? TRIANGLE_BLENDED
                                                                                                    : 0);
  for (uint32_t i = 0; i < from->triangle_count; i++) {
    const uint32_t *corners = from->triangles[i];
    size_t at = (size_t)draw->first_triangle + i;
    flat->corners[at] = (TriangleCorners){
        .vertex = {draw->first_vertex + corners[0], draw->first_vertex + corners[mirrored ? 2 : 1],
                   draw->first_vertex + corners[mirrored ? 1 : 2]},
        .material = (uint32_t)from->material,
    };
    flat->flags[at] = flags;
  }
}

// Counts what the scene draws, checks the limits and allocates.
static Status geometry_allocate(FlatScene *flat, const Scene *scene, uint32_t *draw_count, Log *log)
{
  uint64_t vertices = 0, triangles = 0, draws = 0;
  bool has_colors = false, has_normal_maps = false;
  flat->uv_set_count = 1;
  for (uint32_t o = 0; o < scene->object_count; o++) {
    const Mesh *mesh = &scene->meshes[scene->objects[o].mesh];
    for (uint32_t p = 0; p < mesh->primitive_count; p++) {
      const Primitive *primitive = &mesh->primitives[p];
      vertices += primitive->vertex_count;
      triangles += primitive->triangle_count;
      draws++;
      has_colors |= primitive->colors != NULL;
      has_normal_maps |= primitive_has_normal_map(primitive, scene);
      if (primitive->uvs[1]) flat->uv_set_count = 2;
    }
  }
  if (triangles >= 1u << 28 || vertices >= 1u << 30)
    return log_fail(log, STATUS_TOO_LARGE, "%s: %.0f million triangles: at most 268 million can be drawn", scene->path,
                    1e-6 * (double)triangles);
  flat->vertex_count = (uint32_t)vertices;
  flat->triangle_count = (uint32_t)triangles;
  flat->object_count = scene->object_count;
  *draw_count = (uint32_t)draws;
  flat->positions = malloc((vertices + 1) * sizeof *flat->positions);
  flat->normals = malloc((vertices + 1) * sizeof *flat->normals);
  flat->tangents = has_normal_maps ? malloc((vertices + 1) * sizeof *flat->tangents) : NULL;
  flat->uvs = malloc((flat->uv_set_count * vertices + 1) * sizeof *flat->uvs);
  flat->colors = has_colors ? malloc((vertices + 1) * sizeof *flat->colors) : NULL;
  flat->corners = malloc((triangles + 1) * sizeof *flat->corners);
  flat->flags = malloc((triangles + 1) * sizeof *flat->flags);
  flat->object_starts = malloc((scene->object_count + 1) * sizeof *flat->object_starts);
  bool failed = !flat->positions || !flat->normals || !flat->uvs || (has_colors && !flat->colors) || !flat->corners ||
                (has_normal_maps && !flat->tangents) || !flat->flags || !flat->object_starts;
  return failed ? log_no_memory(log, scene->path) : STATUS_OK;
}

Status flat_geometry_make(FlatScene *flat, const Scene *scene, Log *log)
{
  Status status = STATUS_OK;
  Draw *draws = NULL;
  uint32_t draw_count = 0;
  TRY(geometry_allocate(flat, scene, &draw_count, log));
  draws = malloc((draw_count + 1) * sizeof *draws);
  if (!draws) {
    status = log_no_memory(log, scene->path);
    goto done;
  }
  uint32_t next = 0, vertex = 0, triangle = 0;
  for (uint32_t o = 0; o < scene->object_count; o++) {
    const Mesh *mesh = &scene->meshes[scene->objects[o].mesh];
    flat->object_starts[o] = triangle;
    for (uint32_t p = 0; p < mesh->primitive_count; p++) {
      draws[next++] = (Draw){&mesh->primitives[p], &scene->objects[o], vertex, triangle};
      vertex += mesh->primitives[p].vertex_count;
      triangle += mesh->primitives[p].triangle_count;
    }
  }
  flat->object_starts[scene->object_count] = triangle;
  Flattening work = {flat, scene, draws};
  parallel_for(draw_count, draw_flatten, &work);

done:
  free(draws);
  return status;
}
