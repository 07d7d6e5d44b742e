#include "support/moved_scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "accel/bvh_validate.h"
#include "device_scene/kept_scene.h"
#include "support/oracle_scene.h"
#include "support/picture_fixture.h"

void *buffer_copied(Device *device, const DeviceBuffer *buffer)
{
  void *copy = oracle_array(buffer->bytes + 1, 1);
  picture_assert_ok(buffer_read(device, buffer, copy, buffer->bytes, &picture_log));
  return copy;
}

static void assert_buffers_equal(Device *device, const DeviceBuffer *a, const DeviceBuffer *b, const char *what)
{
  if (a->bytes != b->bytes) fail_msg("%s: %zu bytes, %zu in the scene made anew", what, a->bytes, b->bytes);
  void *x = buffer_copied(device, a), *y = buffer_copied(device, b);
  if (memcmp(x, y, a->bytes)) fail_msg("%s: not those of the scene made anew", what);
  free(x);
  free(y);
}

static int by_id(const void *a, const void *b)
{
  const BvhTriangle *x = a, *y = b;
  return x->id < y->id ? -1 : x->id > y->id;
}

void moved_scene_assert_trees(Device *device, const DeviceScene *scene)
{
  FlatScene flat = {0};
  picture_assert_ok(flat_scene_make(&flat, scene->source, &picture_log));
  uint32_t(*triples)[3] = oracle_array(flat.triangle_count + 1, sizeof *triples);
  for (uint32_t i = 0; i < flat.triangle_count; i++) memcpy(triples[i], flat.corners[i].vertex, sizeof *triples);
  TriangleSoup soup = {.positions = (const float(*)[3])flat.positions,
                       .triangles = (const uint32_t(*)[3])triples,
                       .flags = flat.flags,
                       .vertex_count = flat.vertex_count,
                       .triangle_count = flat.triangle_count};
  Bvh2 two = {.nodes = buffer_copied(device, &scene->bvh2_nodes),
              .triangles = buffer_copied(device, &scene->bvh2_triangles),
              .node_count = (uint32_t)(scene->bvh2_nodes.bytes / sizeof *two.nodes),
              .triangle_count = (uint32_t)(scene->bvh2_triangles.bytes / sizeof *two.triangles),
              .depth = scene->kept->trees.two.depth};
  picture_assert_ok(bvh2_validate(&two, &soup, 4, &picture_log));
  if (device_traits(device)->wide_bvh) {
    Bvh8 eight = {.nodes = buffer_copied(device, &scene->bvh8_nodes),
                  .blocks = buffer_copied(device, &scene->bvh8_blocks),
                  .node_count = (uint32_t)(scene->bvh8_nodes.bytes / sizeof *eight.nodes),
                  .block_count = (uint32_t)(scene->bvh8_blocks.bytes / sizeof *eight.blocks),
                  .depth = scene->kept->trees.eight.depth};
    picture_assert_ok(bvh8_validate(&eight, &soup, &picture_log));
    bvh8_free(&eight);
  }
  bvh2_free(&two);
  free(triples);
  flat_scene_free(&flat);
}

void moved_scene_assert_as_new(Device *device, const DeviceScene *scene)
{
  DeviceScene fresh;
  picture_assert_ok(device_scene_make(&fresh, device, scene->source, NULL, &picture_log));
  assert_buffers_equal(device, &scene->positions, &fresh.positions, "positions");
  assert_buffers_equal(device, &scene->normals, &fresh.normals, "normals");
  assert_buffers_equal(device, &scene->tangents, &fresh.tangents, "tangents");
  assert_buffers_equal(device, &scene->uvs, &fresh.uvs, "texture coordinates");
  assert_buffers_equal(device, &scene->corners, &fresh.corners, "corners");
  assert_buffers_equal(device, &scene->object_starts, &fresh.object_starts, "objects");
  assert_buffers_equal(device, &scene->materials, &fresh.materials, "materials");
  assert_buffers_equal(device, &scene->lights, &fresh.lights, "lights");
  assert_int_equal(scene->bvh2_triangles.bytes, fresh.bvh2_triangles.bytes);
  BvhTriangle *a = buffer_copied(device, &scene->bvh2_triangles), *b = buffer_copied(device, &fresh.bvh2_triangles);
  qsort(a, fresh.bvh2_triangles.bytes / sizeof *a, sizeof *a, by_id);
  qsort(b, fresh.bvh2_triangles.bytes / sizeof *b, sizeof *b, by_id);
  assert_memory_equal(a, b, fresh.bvh2_triangles.bytes);
  assert_memory_equal(&scene->low, &fresh.low, sizeof fresh.low);
  assert_memory_equal(&scene->high, &fresh.high, sizeof fresh.high);
  assert_true(scene->extent_m == fresh.extent_m);
  assert_memory_equal(scene->light_infos, fresh.light_infos, fresh.light_count * sizeof *fresh.light_infos);
  free(a);
  free(b);
  device_scene_free(&fresh);
  moved_scene_assert_trees(device, scene);
}
