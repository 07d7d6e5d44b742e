#include <stdlib.h>

#include "base/large_array.h"
#include "base/parallel.h"
#include "device_scene/flat_scene.h"
#include "shared/bvh.h"

enum { PART_SIZE = 16384 };

typedef struct Flattening {
  FlatScene *flat;
  const Scene *scene;
  const FlatPart *parts;
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

static const Primitive *part_primitive(const FlatPart *part, const Scene *scene)
{
  return &scene->meshes[scene->objects[part->object].mesh].primitives[part->primitive];
}

static void vertices_place(FlatScene *flat, const Scene *scene, const FlatPart *part)
{
  const Primitive *from = part_primitive(part, scene);
  const Mat4 *world_from_object = &scene->objects[part->object].world_from_object;
  double side = mat4_determinant3(world_from_object) < 0 ? -1 : 1;
  for (uint32_t at = part->vertices.begin; at < part->vertices.end; at++) {
    uint32_t i = at - part->first_vertex;
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
  }
}

void flat_part_place(FlatScene *flat, const Scene *scene, const FlatPart *part)
{
  const Primitive *from = part_primitive(part, scene);
  const bool mirrored = mat4_determinant3(&scene->objects[part->object].world_from_object) < 0;
  vertices_place(flat, scene, part);
  for (uint32_t at = part->triangles.begin; at < part->triangles.end; at++) {
    const uint32_t *corners = from->triangles[at - part->first_triangle];
    flat->corners[at] = (TriangleCorners){
        .vertex = {part->first_vertex + corners[0], part->first_vertex + corners[mirrored ? 2 : 1],
                   part->first_vertex + corners[mirrored ? 1 : 2]},
        .material = (uint32_t)from->material,
    };
  }
}

// What stays wherever the object moves.
static void attributes_copy(FlatScene *flat, const Primitive *from, const FlatPart *part)
{
  for (uint32_t at = part->vertices.begin; at < part->vertices.end; at++) {
    uint32_t i = at - part->first_vertex;
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

static uint32_t triangle_flags(const Material *material, const Object *object)
{
  return (material->double_sided ? 0 : TRIANGLE_SINGLE_SIDED) |
         (material->alpha_mode == ALPHA_MASK ? TRIANGLE_MASKED : 0) |
         (material->alpha_mode == ALPHA_BLEND ? TRIANGLE_BLENDED : 0) | (object->shadowless ? TRIANGLE_SHADOWLESS : 0);
}

static void part_flatten(void *context, size_t index)
{
  Flattening *work = context;
  FlatScene *flat = work->flat;
  const FlatPart *part = &work->parts[index];
  const Primitive *from = part_primitive(part, work->scene);
  const Material *material = &work->scene->materials[from->material];
  uint32_t flags = triangle_flags(material, &work->scene->objects[part->object]);
  flat_part_place(flat, work->scene, part);
  attributes_copy(flat, from, part);
  for (uint32_t at = part->triangles.begin; at < part->triangles.end; at++) flat->flags[at] = flags;
}

// Counts what the scene draws, checks the limits and allocates.
static Status geometry_allocate(FlatScene *flat, const Scene *scene, Log *log)
{
  uint64_t vertices = 0, triangles = 0;
  bool has_colors = false, has_normal_maps = false;
  flat->uv_set_count = 1;
  for (uint32_t o = 0; o < scene->object_count; o++) {
    const Mesh *mesh = &scene->meshes[scene->objects[o].mesh];
    for (uint32_t p = 0; p < mesh->primitive_count; p++) {
      const Primitive *primitive = &mesh->primitives[p];
      vertices += primitive->vertex_count;
      triangles += primitive->triangle_count;
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
  flat->positions = large_array(vertices + 1, sizeof *flat->positions);
  flat->normals = large_array(vertices + 1, sizeof *flat->normals);
  flat->tangents = has_normal_maps ? large_array(vertices + 1, sizeof *flat->tangents) : NULL;
  flat->uvs = large_array(flat->uv_set_count * vertices + 1, sizeof *flat->uvs);
  flat->colors = has_colors ? large_array(vertices + 1, sizeof *flat->colors) : NULL;
  flat->corners = large_array(triangles + 1, sizeof *flat->corners);
  flat->flags = large_array(triangles + 1, sizeof *flat->flags);
  flat->object_starts = malloc((scene->object_count + 1) * sizeof *flat->object_starts);
  bool failed = !flat->positions || !flat->normals || !flat->uvs || (has_colors && !flat->colors) || !flat->corners ||
                (has_normal_maps && !flat->tangents) || !flat->flags || !flat->object_starts;
  return failed ? log_no_memory(log, scene->path) : STATUS_OK;
}

static uint32_t part_border(uint32_t count, uint32_t part, uint32_t parts)
{
  return (uint32_t)((uint64_t)count * part / parts);
}

// Cuts a primitive into parts, written where `parts` is not NULL; returns how many.
static uint32_t primitive_parts(FlatPart *parts, const Primitive *primitive, FlatPart whole)
{
  const uint32_t vertices = primitive->vertex_count, triangles = primitive->triangle_count;
  const uint32_t count = 1 + (vertices > triangles ? vertices : triangles) / PART_SIZE;
  for (uint32_t i = 0; parts && i < count; i++) {
    parts[i] = whole;
    parts[i].vertices = (FlatRange){whole.first_vertex + part_border(vertices, i, count),
                                    whole.first_vertex + part_border(vertices, i + 1, count)};
    parts[i].triangles = (FlatRange){whole.first_triangle + part_border(triangles, i, count),
                                     whole.first_triangle + part_border(triangles, i + 1, count)};
  }
  return count;
}

static uint32_t scene_parts(FlatPart *parts, const Scene *scene)
{
  uint32_t count = 0;
  FlatPart next = {0};
  for (next.object = 0; next.object < scene->object_count; next.object++) {
    const Mesh *mesh = &scene->meshes[scene->objects[next.object].mesh];
    for (next.primitive = 0; next.primitive < mesh->primitive_count; next.primitive++) {
      const Primitive *primitive = &mesh->primitives[next.primitive];
      count += primitive_parts(parts ? parts + count : NULL, primitive, next);
      next.first_vertex += primitive->vertex_count;
      next.first_triangle += primitive->triangle_count;
    }
  }
  return count;
}

Status flat_parts_make(FlatPart **out, uint32_t *count, const Scene *scene, Log *log)
{
  *count = scene_parts(NULL, scene);
  *out = malloc(((size_t)*count + 1) * sizeof **out);
  if (!*out) return log_no_memory(log, scene->path);
  scene_parts(*out, scene);
  return STATUS_OK;
}

static void object_starts_fill(FlatScene *flat, const Scene *scene)
{
  uint32_t triangle = 0;
  for (uint32_t o = 0; o < scene->object_count; o++) {
    flat->object_starts[o] = triangle;
    triangle += scene_object_triangles(scene, o);
  }
  flat->object_starts[scene->object_count] = triangle;
}

Status flat_geometry_make(FlatScene *flat, const Scene *scene, Log *log)
{
  Status status = STATUS_OK;
  FlatPart *parts = NULL;
  uint32_t part_count = 0;
  TRY(geometry_allocate(flat, scene, log));
  TRY(flat_parts_make(&parts, &part_count, scene, log));
  object_starts_fill(flat, scene);
  Flattening work = {flat, scene, parts};
  parallel_for(part_count, part_flatten, &work);

done:
  free(parts);
  return status;
}
