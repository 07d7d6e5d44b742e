#include "device_scene/part_bvh.h"

#include <stdlib.h>
#include <string.h>

#include "base/large_array.h"

const BvhOptions flat_bvh_options = {.max_leaf = 4, .traversal_cost = 1};

Status flat_bvh_make(Bvh2 *out, const FlatScene *flat, Log *log)
{
  // TriangleCorners is a triple of indices and a material: the builder takes the triples alone.
  uint32_t(*triples)[3] = large_array((size_t)flat->triangle_count + 1, sizeof *triples);
  if (!triples) return log_no_memory(log, "BVH");
  for (uint32_t i = 0; i < flat->triangle_count; i++) memcpy(triples[i], flat->corners[i].vertex, sizeof triples[i]);
  TriangleSoup soup = {.positions = (const float(*)[3])flat->positions,
                       .triangles = (const uint32_t(*)[3])triples,
                       .flags = flat->flags,
                       .vertex_count = flat->vertex_count,
                       .triangle_count = flat->triangle_count};
  Status status = bvh2_build(out, &soup, &flat_bvh_options, log);
  free(triples);
  return status;
}

// From ids among the triangles of some objects to those of the scene.
static void ids_restore(Bvh2 *bvh, uint32_t *scene_ids, const Scene *scene, const uint32_t *objects, uint32_t count)
{
  uint32_t first = 0, part = 0, next = 0;
  for (uint32_t i = 0; i < scene->object_count && next < count; i++) {
    uint32_t triangles = scene_object_triangles(scene, i);
    if (i == objects[next]) {
      for (uint32_t t = 0; t < triangles; t++) scene_ids[part++] = first + t;
      next++;
    }
    first += triangles;
  }
  for (uint32_t i = 0; i < bvh->triangle_count; i++) bvh->triangles[i].id = scene_ids[bvh->triangles[i].id];
}

Status part_bvh_make(Bvh2 *out, const Scene *scene, const uint32_t *objects, uint32_t object_count, Log *log)
{
  Status status = STATUS_OK;
  FlatScene flat = {0};
  Bvh2 bvh = {0};
  Scene part = *scene;
  uint32_t *scene_ids = NULL;
  part.object_count = object_count;
  part.objects = calloc((size_t)object_count + 1, sizeof *part.objects);
  if (!part.objects) return log_no_memory(log, "BVH");
  for (uint32_t i = 0; i < object_count; i++) part.objects[i] = scene->objects[objects[i]];
  TRY(flat_geometry_make(&flat, &part, log));
  scene_ids = malloc(((size_t)flat.triangle_count + 1) * sizeof *scene_ids);
  if (!scene_ids) {
    status = log_no_memory(log, "BVH");
    goto done;
  }
  TRY(flat_bvh_make(&bvh, &flat, log));
  ids_restore(&bvh, scene_ids, scene, objects, object_count);
  *out = bvh;
  bvh = (Bvh2){0};

done:
  free(part.objects);
  free(scene_ids);
  bvh2_free(&bvh);
  flat_scene_free(&flat);
  return status;
}
