#include "passes/near_reflect.h"

#include "passes/scene_args.h"
#include "shared/stream.h"

Status near_reflect_make(NearReflect *out, Device *device, const DeviceScene *scene, const NearSources *sources,
                         uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  NearReflect near = {.cube_count = sources->cube_count};
  Program *program = NULL;
  const size_t texels = sources->snapshot_texels;
  const struct {
    DeviceBuffer *buffer;
    size_t bytes;
    const void *from;
  } buffers[] = {
      {&near.snapshots, sources->snapshot_count * sizeof *sources->snapshots, sources->snapshots},
      {&near.photos, texels * sizeof(Float4), NULL},
      {&near.backs, texels * sizeof(float), NULL},
      {&near.cells, texels / (CUBE_CELL * CUBE_CELL) * sizeof(float), NULL},
      {&near.counts, NEAR_COUNTS * sizeof(uint32_t), NULL},
  };
  TRY(program_build(&program, device, "capture/near_reflect.cl", "", log));
  TRY(program_kernel(&near.reflect, program, "near_reflect", log));
  TRY(near_trace_make(&near.trace, device, scene, sources->trees, sources->nears, sources->cube_count, capacity, log));
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
    TRY(buffer_create(buffers[i].buffer, device, buffers[i].bytes, buffers[i].from, "objects near reflectors", log));
  *out = near;
  near = (NearReflect){0};

done:
  near_reflect_free(&near);
  return status;
}

void near_reflect_free(NearReflect *near)
{
  DeviceBuffer *buffers[] = {&near->snapshots, &near->photos, &near->backs, &near->cells, &near->counts};
  near_trace_free(&near->trace);
  kernel_free(&near->reflect);
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) buffer_free(buffers[i]);
  *near = (NearReflect){0};
}

Status near_reflect_set(NearReflect *near, Device *device, const NearInfo *nears, Log *log)
{
  return buffer_write(device, &near->trace.nears, nears, near->cube_count * sizeof *nears, log);
}

Status near_reflect(NearReflect *near, const CubeReflect *cubes, Device *device, const DeviceScene *scene,
                    ReflectionMethod method, float invisible, const NearStreams *streams, uint32_t count, LeftRays *out,
                    Log *log)
{
  Status status = STATUS_OK;
  const RayStream *rays = streams->rays, *left = streams->left, *listed = &streams->known->rays;
  const HitStream *listed_hits = &streams->known->hits, *hits = &near->trace.hits;
  uint32_t map = method == REFLECTIONS_CUBE  ? REFLECT_BY_CUBE
                 : method == REFLECTIONS_BOX ? REFLECT_BY_BOX
                                             : REFLECT_BY_IMPOSTOR;
  uint32_t counts[NEAR_COUNTS];
  TRY(near_trace(&near->trace, device, scene, &cubes->cube_of_object, rays, count, log));
  TRY(buffer_zero(device, &near->counts, log));
  TRY(device_launch(
      device, &near->reflect, work_items(device, count), count, "look up cube maps and snapshots",
      ARGS(ARG(map), ARG(invisible), ARG_BUFFER(rays->rays), ARG_BUFFER(rays->slots), ARG(rays->capacity), ARG(count),
           ARG_BUFFER(hits->hits), ARG_BUFFER(hits->ids), ARG_BUFFER(scene->object_starts), ARG(scene->object_count),
           ARG_BUFFER(cubes->cube_of_object), ARG_BUFFER(cubes->cubes), ARG_BUFFER(cubes->texels),
           ARG_BUFFER(cubes->cells), ARG_BUFFER(near->trace.nears), ARG_BUFFER(near->snapshots),
           ARG_BUFFER(near->photos), ARG_BUFFER(near->backs), ARG_BUFFER(near->cells), ARG_BUFFER(*streams->radiance),
           ARG_BUFFER(listed->rays), ARG_BUFFER(listed->slots), ARG_BUFFER(listed_hits->hits),
           ARG_BUFFER(listed_hits->ids), ARG_BUFFER(left->rays), ARG_BUFFER(left->slots), ARG_BUFFER(near->counts)),
      log));
  TRY(buffer_read(device, &near->counts, counts, sizeof counts, log));
  *out = (LeftRays){.traced = counts[NEAR_LEFT], .known = counts[NEAR_LISTED]};
  near->looked_up += count;
  for (int i = 0; i < NEAR_COUNTS; i++) near->totals[i] += counts[i];

done:
  return status;
}
