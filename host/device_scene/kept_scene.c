#include "device_scene/kept_scene.h"

#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"

typedef struct Following {
  KeptScene *kept;
  const Scene *scene;
} Following;

// The arrays of a mesh that may move, one after the other: calls visit for each.
typedef bool (*ArrayVisit)(float *kept, const void *array, size_t bytes);

static bool array_keep(float *kept, const void *array, size_t bytes)
{
  memcpy(kept, array, bytes);
  return true;
}

static bool array_follow(float *kept, const void *array, size_t bytes)
{
  return memcmp(kept, array, bytes) != 0 && array_keep(kept, array, bytes);
}

// Whether any visit said so.
static bool mesh_visit(float *kept, const Mesh *mesh, ArrayVisit visit)
{
  bool any = false;
  for (uint32_t p = 0; p < mesh->primitive_count; p++) {
    const Primitive *primitive = &mesh->primitives[p];
    const void *arrays[] = {primitive->positions, primitive->normals, primitive->tangents};
    for (int i = 0; i < 3; i++) {
      size_t floats = arrays[i] ? (size_t)primitive->vertex_count * (i == 2 ? 4 : 3) : 0;
      if (floats) any |= visit(kept, arrays[i], floats * sizeof *kept);
      kept += floats;
    }
  }
  return any;
}

static size_t mesh_floats(const Mesh *mesh)
{
  size_t floats = 0;
  for (uint32_t p = 0; p < mesh->primitive_count; p++)
    floats += (size_t)mesh->primitives[p].vertex_count * (mesh->primitives[p].tangents ? 10 : 6);
  return floats;
}

static Status meshes_keep(KeptScene *kept, const Scene *scene, Log *log)
{
  kept->meshes = calloc((size_t)scene->mesh_count + 1, sizeof *kept->meshes);
  kept->mesh_moved = calloc((size_t)scene->mesh_count + 1, sizeof *kept->mesh_moved);
  if (!kept->meshes || !kept->mesh_moved) return log_no_memory(log, scene->path);
  kept->mesh_count = scene->mesh_count;
  for (uint32_t m = 0; m < scene->mesh_count; m++) {
    kept->meshes[m] = malloc((mesh_floats(&scene->meshes[m]) + 1) * sizeof **kept->meshes);
    if (!kept->meshes[m]) return log_no_memory(log, scene->path);
    mesh_visit(kept->meshes[m], &scene->meshes[m], array_keep);
  }
  return STATUS_OK;
}

static Status before_allocate(KeptScene *kept, const Scene *scene, Log *log)
{
  const FlatScene *flat = &kept->flat;
  FlatScene *before = &kept->before;
  const size_t vertices = (size_t)flat->vertex_count + 1, triangles = (size_t)flat->triangle_count + 1;
  before->positions = malloc(vertices * sizeof *before->positions);
  before->normals = malloc(vertices * sizeof *before->normals);
  before->tangents = flat->tangents ? malloc(vertices * sizeof *before->tangents) : NULL;
  before->corners = malloc(triangles * sizeof *before->corners);
  kept->triples = malloc(triangles * sizeof *kept->triples);
  kept->parts_moved = calloc((size_t)kept->part_count + 1, sizeof *kept->parts_moved);
  kept->candidates = calloc((size_t)kept->part_count + 1, sizeof *kept->candidates);
  kept->boxes = malloc(((size_t)kept->part_count + 1) * sizeof *kept->boxes);
  kept->moved = calloc((size_t)scene->object_count + 1, sizeof *kept->moved);
  kept->transforms = malloc(((size_t)scene->object_count + 1) * sizeof *kept->transforms);
  bool failed = !before->positions || !before->normals || (flat->tangents && !before->tangents) || !before->corners ||
                !kept->triples || !kept->parts_moved || !kept->candidates || !kept->boxes || !kept->moved ||
                !kept->transforms;
  return failed ? log_no_memory(log, scene->path) : STATUS_OK;
}

static void triples_copy(KeptScene *kept, FlatRange triangles)
{
  for (uint32_t i = triangles.begin; i < triangles.end; i++)
    memcpy(kept->triples[i], kept->flat.corners[i].vertex, sizeof kept->triples[i]);
}

Status kept_scene_make(KeptScene **out, FlatScene *flat, SceneTrees *trees, const Scene *scene, Log *log)
{
  Status status = STATUS_OK;
  KeptScene *kept = calloc(1, sizeof *kept);
  if (!kept) return log_no_memory(log, scene->path);
  kept->flat = (FlatScene){.positions = flat->positions,
                           .normals = flat->normals,
                           .tangents = flat->tangents,
                           .corners = flat->corners,
                           .flags = flat->flags,
                           .object_starts = flat->object_starts,
                           .vertex_count = flat->vertex_count,
                           .triangle_count = flat->triangle_count,
                           .object_count = flat->object_count};
  flat->positions = flat->normals = NULL, flat->tangents = NULL;
  flat->corners = NULL, flat->flags = NULL, flat->object_starts = NULL;
  kept->trees = *trees;
  *trees = (SceneTrees){0};
  TRY(flat_parts_make(&kept->parts, &kept->part_count, scene, log));
  TRY(before_allocate(kept, scene, log));
  TRY(meshes_keep(kept, scene, log));
  for (uint32_t o = 0; o < scene->object_count; o++) kept->transforms[o] = scene->objects[o].world_from_object;
  triples_copy(kept, (FlatRange){0, kept->flat.triangle_count});
  TRY(scene_trees_link(&kept->trees, kept->flat.triangle_count, log));
  *out = kept;
  kept = NULL;

done:
  kept_scene_free(kept);
  return status;
}

void kept_scene_free(KeptScene *kept)
{
  if (!kept) return;
  for (uint32_t m = 0; m < kept->mesh_count; m++) free(kept->meshes[m]);
  free(kept->meshes);
  free(kept->mesh_moved);
  free(kept->transforms);
  free(kept->parts);
  free(kept->parts_moved);
  free(kept->candidates);
  free(kept->boxes);
  free(kept->triples);
  flat_scene_free(&kept->flat);
  flat_scene_free(&kept->before);
  free(kept->moved);
  scene_trees_free(&kept->trees);
  free(kept);
}

static void vertices_copy(FlatScene *to, const FlatScene *from, const FlatPart *part)
{
  const size_t first = part->vertices.begin, vertices = part->vertices.end - first;
  memcpy(to->positions[first], from->positions[first], vertices * sizeof *to->positions);
  memcpy(to->normals[first], from->normals[first], vertices * sizeof *to->normals);
  if (to->tangents) memcpy(&to->tangents[first], &from->tangents[first], vertices * sizeof *to->tangents);
}

static int part_compare(const FlatScene *a, const FlatScene *b, const FlatPart *part)
{
  const size_t v = part->vertices.begin, vertices = part->vertices.end - v;
  const size_t t = part->triangles.begin, triangles = part->triangles.end - t;
  bool shape = memcmp(a->positions + v, b->positions + v, vertices * sizeof *a->positions) ||
               memcmp(a->corners + t, b->corners + t, triangles * sizeof *a->corners);
  bool shading = memcmp(a->normals + v, b->normals + v, vertices * sizeof *a->normals) ||
                 (a->tangents && memcmp(a->tangents + v, b->tangents + v, vertices * sizeof *a->tangents));
  return (shape ? MOVED_SHAPE : 0) | (shading ? MOVED_SHADING : 0);
}

static void part_follow(void *context, size_t index)
{
  Following *following = context;
  KeptScene *kept = following->kept;
  const uint32_t at = kept->candidates[index];
  const FlatPart *part = &kept->parts[at];
  const size_t first = part->triangles.begin, triangles = part->triangles.end - first;
  vertices_copy(&kept->before, &kept->flat, part);
  memcpy(&kept->before.corners[first], &kept->flat.corners[first], triangles * sizeof *kept->flat.corners);
  flat_part_place(&kept->flat, following->scene, part);
  kept->parts_moved[at] = (uint8_t)part_compare(&kept->flat, &kept->before, part);
  if (kept->parts_moved[at] & MOVED_SHAPE) triples_copy(kept, part->triangles);
}

static Box triangle_box(const FlatScene *flat, uint32_t triangle)
{
  Box box = box_empty();
  F4 zero = {0};
  for (int corner = 0; corner < 3; corner++) {
    const float *position = flat->positions[flat->corners[triangle].vertex[corner]];
    F4 point = {position[0], position[1], position[2], 0};
    box = box_with_point(box, point);
    zero += point * 0;
  }
  return zero[0] + zero[1] + zero[2] == 0 ? box : box_empty();  // infinity and NaN times 0 are NaN
}

static void part_bounds(void *context, size_t index)
{
  Following *following = context;
  const KeptScene *kept = following->kept;
  const FlatPart *part = &kept->parts[kept->candidates[index]];
  Box box = box_empty();
  for (uint32_t i = part->triangles.begin; i < part->triangles.end; i++)
    box = box_union(box, box_union(triangle_box(&kept->flat, i), triangle_box(&kept->before, i)));
  kept->boxes[index] = box;
}

static void candidates_find(KeptScene *kept, const Scene *scene)
{
  uint8_t object_moved = 0;
  for (uint32_t m = 0; m < scene->mesh_count; m++)
    kept->mesh_moved[m] = mesh_visit(kept->meshes[m], &scene->meshes[m], array_follow);
  kept->candidate_count = 0;
  for (uint32_t p = 0; p < kept->part_count; p++) {
    uint32_t object = kept->parts[p].object;
    const Mat4 *transform = &scene->objects[object].world_from_object;
    if (p == 0 || object != kept->parts[p - 1].object) {
      object_moved = kept->mesh_moved[scene->objects[object].mesh] ||
                     memcmp(&kept->transforms[object], transform, sizeof *transform) != 0;
      kept->transforms[object] = *transform;
    }
    kept->parts_moved[p] = 0;
    if (object_moved) kept->candidates[kept->candidate_count++] = p;
  }
}

// Leaves the candidates that are parts of objects of which some part moved.
static void candidates_keep_movers(KeptScene *kept)
{
  uint32_t left = 0;
  for (uint32_t begin = 0, end; begin < kept->candidate_count; begin = end) {
    uint32_t object = kept->parts[kept->candidates[begin]].object;
    bool moved = false;
    for (end = begin; end < kept->candidate_count && kept->parts[kept->candidates[end]].object == object; end++)
      moved |= kept->parts_moved[kept->candidates[end]] != 0;
    for (uint32_t i = begin; moved && i < end; i++) kept->candidates[left++] = kept->candidates[i];
  }
  kept->candidate_count = left;
}

uint32_t kept_scene_follow(KeptScene *kept, Mover *movers, const Scene *scene)
{
  Following following = {kept, scene};
  candidates_find(kept, scene);
  parallel_for(kept->candidate_count, part_follow, &following);
  candidates_keep_movers(kept);
  parallel_for(kept->candidate_count, part_bounds, &following);

  uint32_t count = 0;
  for (uint32_t i = 0; i < kept->candidate_count;) {
    const uint32_t object = kept->parts[kept->candidates[i]].object;
    Box box = box_empty();
    for (; i < kept->candidate_count && kept->parts[kept->candidates[i]].object == object; i++)
      box = box_union(box, kept->boxes[i]);
    movers[count++] = (Mover){.object = object,
                              .low = vec3(box.low[0], box.low[1], box.low[2]),
                              .high = vec3(box.high[0], box.high[1], box.high[2])};
  }
  return count;
}

bool kept_scene_refit(KeptScene *kept)
{
  const FlatScene *flat = &kept->flat;
  const TriangleSoup soup = {.positions = (const float(*)[3])flat->positions,
                             .triangles = (const uint32_t(*)[3])kept->triples,
                             .flags = flat->flags,
                             .vertex_count = flat->vertex_count,
                             .triangle_count = flat->triangle_count};
  uint32_t count = 0, object = UINT32_MAX;
  for (uint32_t i = 0; i < kept->candidate_count; i++) {
    const uint32_t part = kept->candidates[i];
    if (!(kept->parts_moved[part] & MOVED_SHAPE) || kept->parts[part].object == object) continue;
    object = kept->parts[part].object;
    kept->moved[count++] = (BvhIds){flat->object_starts[object], flat->object_starts[object + 1]};
  }
  return bvh_refit(&kept->trees.refit, &soup, kept->moved, count) && !bvh_refit_is_worn(&kept->trees.refit);
}
