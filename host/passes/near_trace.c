#include "passes/near_trace.h"

#include <stdlib.h>
#include <string.h>

#include "passes/scene_args.h"

// Puts trees one behind the other.
static Status trees_join(NearTrace *out, Device *device, const Bvh2 *trees, NearInfo *nears, uint32_t count, Log *log)
{
  Status status = STATUS_OK;
  size_t node_count = 0, triangle_count = 0;
  for (uint32_t i = 0; i < count; i++) {
    nears[i].first_node = (uint32_t)node_count;
    nears[i].first_triangle = (uint32_t)triangle_count;
    node_count += trees[i].node_count;
    triangle_count += trees[i].triangle_count;
  }
  Bvh2Node *nodes = malloc((node_count + 1) * sizeof *nodes);
  BvhTriangle *triangles = malloc((triangle_count + 1) * sizeof *triangles);
  if (!nodes || !triangles) {
    status = log_no_memory(log, "objects near reflectors");
    goto done;
  }
  for (uint32_t i = 0; i < count; i++) {
    memcpy(nodes + nears[i].first_node, trees[i].nodes, trees[i].node_count * sizeof *nodes);
    if (trees[i].triangle_count)
      memcpy(triangles + nears[i].first_triangle, trees[i].triangles, trees[i].triangle_count * sizeof *triangles);
  }
  TRY(buffer_create(&out->nears, device, count * sizeof *nears, nears, "objects near reflectors", log));
  TRY(buffer_create(&out->nodes, device, node_count * sizeof *nodes, nodes, "objects near reflectors", log));
  TRY(buffer_create(&out->triangles, device, triangle_count * sizeof *triangles, triangles, "objects near reflectors",
                    log));

done:
  free(nodes);
  free(triangles);
  return status;
}

Status near_trace_make(NearTrace *out, Device *device, const DeviceScene *scene, const Bvh2 *trees, NearInfo *nears,
                       uint32_t cube_count, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  NearTrace trace = {0};
  Program *program = NULL;
  char options[128];
  device_scene_options(scene, TESTS_MASKS, options, sizeof options);
  TRY(program_build(&program, device, "capture/near_trace.cl", options, log));
  TRY(program_kernel(&trace.kernel, program, "near_trace", log));
  TRY(trees_join(&trace, device, trees, nears, cube_count, log));
  TRY(hit_stream_make(&trace.hits, device, capacity, log));
  *out = trace;
  trace = (NearTrace){0};

done:
  near_trace_free(&trace);
  return status;
}

void near_trace_free(NearTrace *trace)
{
  kernel_free(&trace->kernel);
  buffer_free(&trace->nears);
  buffer_free(&trace->nodes);
  buffer_free(&trace->triangles);
  hit_stream_free(&trace->hits);
  *trace = (NearTrace){0};
}

Status near_trace(const NearTrace *trace, Device *device, const DeviceScene *scene, const DeviceBuffer *cube_of_object,
                  const RayStream *rays, uint32_t count, Log *log)
{
  return device_launch(device, &trace->kernel, work_items(device, count), count, "trace what is near reflectors",
                       ARGS(ARG_BUFFER(scene->object_starts), ARG(scene->object_count), ARG_BUFFER(*cube_of_object),
                            ARG_BUFFER(trace->nears), ARG_BUFFER(trace->nodes), ARG_BUFFER(trace->triangles),
                            ARG_BUFFER(rays->rays), ARG(rays->capacity), ARG(count), ARG_BUFFER(trace->hits.hits),
                            ARG_BUFFER(trace->hits.ids), ATTRIBUTE_ARGS(scene)),
                       log);
}
