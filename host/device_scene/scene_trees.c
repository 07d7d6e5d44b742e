#include "device_scene/scene_trees.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "device_scene/part_bvh.h"

Status scene_trees_build(SceneTrees *out, const Device *device, const FlatScene *flat, Log *log)
{
  Status status = STATUS_OK;
  SceneTrees trees = {0};
  TRY(flat_bvh_make(&trees.two, flat, log));
  if (device_traits(device)->wide_bvh) TRY(bvh8_from_bvh2(&trees.eight, &trees.two, log));
  *out = trees;
  trees = (SceneTrees){0};

done:
  scene_trees_free(&trees);
  return status;
}

void scene_trees_free(SceneTrees *trees)
{
  bvh_refit_free(&trees->refit);
  bvh2_free(&trees->two);
  bvh8_free(&trees->eight);
}

Status scene_trees_link(SceneTrees *trees, uint32_t triangle_count, Log *log)
{
  return bvh_refit_make(&trees->refit, &trees->two, trees->eight.nodes ? &trees->eight : NULL, triangle_count,
                        flat_bvh_options.traversal_cost, log);
}

static void bounds_set(DeviceScene *scene, const Bvh2 *bvh2)
{
  Vec3 low = vec3(INFINITY, INFINITY, INFINITY), high = vec3(-INFINITY, -INFINITY, -INFINITY);
  for (int child = 0; child < 2 && bvh2->node_count > 0; child++) {
    const float(*bounds)[2] = bvh2->nodes[0].bounds[child];
    low = vec3_min(low, vec3(bounds[0][0], bounds[1][0], bounds[2][0]));
    high = vec3_max(high, vec3(bounds[0][1], bounds[1][1], bounds[2][1]));
  }
  const bool drawn = vec3_is_finite(vec3_sub(high, low));
  scene->low = drawn ? low : vec3(0, 0, 0);
  scene->high = drawn ? high : vec3(0, 0, 0);
  scene->extent_m = vec3_length(vec3_sub(scene->high, scene->low));
}

// One array of the trees: where it goes, what it holds, and which elements the last refit changed.
typedef struct TreeArray {
  DeviceBuffer *buffer;
  void *elements;
  size_t count, element_bytes;
  const uint8_t *moved;
  const char *what;
} TreeArray;

enum { TREE_ARRAYS = 4 };

static void arrays_list(TreeArray out[TREE_ARRAYS], DeviceScene *scene, const SceneTrees *trees)
{
  const Bvh2 *two = &trees->two;
  const Bvh8 *eight = &trees->eight;
  const BvhRefit *refit = &trees->refit;
  const TreeArray arrays[TREE_ARRAYS] = {
      {&scene->bvh2_nodes, two->nodes, two->node_count, sizeof *two->nodes, refit->nodes_moved, "BVH nodes"},
      {&scene->bvh2_triangles, two->triangles, two->triangle_count, sizeof *two->triangles, refit->triangles_moved,
       "BVH triangles"},
      {&scene->bvh8_nodes, eight->nodes, eight->node_count, sizeof *eight->nodes, refit->wide_nodes_moved,
       "wide BVH nodes"},
      {&scene->bvh8_blocks, eight->blocks, eight->block_count, sizeof *eight->blocks, refit->blocks_moved,
       "wide BVH blocks"},
  };
  memcpy(out, arrays, sizeof arrays);
}

// Of exactly so many bytes: a buffer's size tells how many elements there are.
static Status array_put(const TreeArray *array, Device *device, Log *log)
{
  const size_t bytes = array->count * array->element_bytes;
  DeviceBuffer *buffer = array->buffer;
  if (buffer->memory && buffer->bytes == bytes) return buffer_write(device, buffer, array->elements, bytes, log);
  buffer_free(buffer);
  return buffer_create(buffer, device, bytes, array->elements, array->what, log);
}

// Runs of changed elements; what lies between two near ones is written along.
static Status array_write_moved(const TreeArray *array, Device *device, Log *log)
{
  enum { NEAR_BYTES = 16384 };
  Status status = STATUS_OK;
  const size_t near = NEAR_BYTES / array->element_bytes;
  const uint8_t *moved = array->moved, *end = moved + array->count;
  for (const uint8_t *next = array->count ? memchr(moved, 1, array->count) : NULL; next;) {
    const uint8_t *first = next, *last = next;
    while ((next = memchr(last + 1, 1, (size_t)(end - last - 1))) != NULL && (size_t)(next - last) <= near) last = next;
    const size_t offset = (size_t)(first - moved) * array->element_bytes;
    TRY(buffer_write_part(device, array->buffer, offset, (const char *)array->elements + offset,
                          (size_t)(last + 1 - first) * array->element_bytes, log));
  }

done:
  return status;
}

typedef Status (*ArrayWrite)(const TreeArray *array, Device *device, Log *log);

static Status arrays_write(DeviceScene *scene, Device *device, const SceneTrees *trees, ArrayWrite write, Log *log)
{
  Status status = STATUS_OK;
  TreeArray arrays[TREE_ARRAYS];
  arrays_list(arrays, scene, trees);
  for (int i = 0; i < TREE_ARRAYS; i++) TRY(write(&arrays[i], device, log));
  bounds_set(scene, &trees->two);

done:
  return status;
}

Status scene_trees_put(DeviceScene *scene, Device *device, const SceneTrees *trees, Log *log)
{
  return arrays_write(scene, device, trees, array_put, log);
}

Status scene_trees_give(DeviceScene *scene, Device *device, SceneTrees *trees, Log *log)
{
  Status status = STATUS_OK;
  TreeArray arrays[TREE_ARRAYS];
  arrays_list(arrays, scene, trees);
  bounds_set(scene, &trees->two);
  trees->two.nodes = NULL;
  trees->two.triangles = NULL;
  trees->eight.nodes = NULL;
  trees->eight.blocks = NULL;
  for (int i = 0; i < TREE_ARRAYS; i++) {
    const TreeArray *array = &arrays[i];
    if (status)
      free(array->elements);
    else
      status =
          buffer_adopt(array->buffer, device, array->count * array->element_bytes, array->elements, array->what, log);
  }
  return status;
}

Status scene_trees_write_moved(DeviceScene *scene, Device *device, const SceneTrees *trees, Log *log)
{
  return arrays_write(scene, device, trees, array_write_moved, log);
}
