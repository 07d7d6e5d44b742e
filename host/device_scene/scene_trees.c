#include "device_scene/scene_trees.h"

#include <math.h>

#include "device_scene/part_bvh.h"

Status scene_trees_build(Bvh2 *bvh2, Bvh8 *bvh8, const Device *device, const FlatScene *flat, Log *log)
{
  Status status = STATUS_OK;
  TRY(flat_bvh_make(bvh2, flat, log));
  if (device_traits(device)->wide_bvh) TRY(bvh8_from_bvh2(bvh8, bvh2, log));

done:
  return status;
}

// A buffer of exactly so many bytes: what is there tells how many elements there are.
static Status exact_put(DeviceBuffer *buffer, Device *device, size_t bytes, const void *from, const char *what,
                        Log *log)
{
  if (buffer->memory && buffer->bytes == bytes) return buffer_write(device, buffer, from, bytes, log);
  buffer_free(buffer);
  return buffer_create(buffer, device, bytes, from, what, log);
}

Status scene_trees_put(DeviceScene *scene, Device *device, const Bvh2 *bvh2, const Bvh8 *bvh8, Log *log)
{
  Status status = STATUS_OK;
  TRY(exact_put(&scene->bvh2_nodes, device, (size_t)bvh2->node_count * sizeof *bvh2->nodes, bvh2->nodes, "BVH nodes",
                log));
  TRY(exact_put(&scene->bvh2_triangles, device, (size_t)bvh2->triangle_count * sizeof *bvh2->triangles, bvh2->triangles,
                "BVH triangles", log));
  TRY(exact_put(&scene->bvh8_nodes, device, (size_t)bvh8->node_count * sizeof *bvh8->nodes, bvh8->nodes,
                "wide BVH nodes", log));
  TRY(exact_put(&scene->bvh8_blocks, device, (size_t)bvh8->block_count * sizeof *bvh8->blocks, bvh8->blocks,
                "wide BVH blocks", log));
  scene_trees_bounds(scene, bvh2);

done:
  return status;
}

void scene_trees_bounds(DeviceScene *scene, const Bvh2 *bvh2)
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
