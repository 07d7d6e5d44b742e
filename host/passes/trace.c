#include "passes/trace.h"

#include "passes/scene_args.h"

Status tracer_make(Tracer *out, Device *device, const DeviceScene *scene, Log *log)
{
  Status status = STATUS_OK;
  Tracer tracer = {0};
  char options[128];
  device_scene_options(scene, TESTS_MASKS | TESTS_BLENDS | SKIPS_SHADOWLESS, options, sizeof options);
  TRY(program_build(&tracer.packet_program, device, "rays/trace_packet.cl", options, log));
  TRY(program_kernel(&tracer.packet_closest, tracer.packet_program, "trace_closest", log));
  TRY(program_kernel(&tracer.packet_any, tracer.packet_program, "trace_any", log));
  TRY(program_kernel(&tracer.packet_open, tracer.packet_program, "trace_open", log));
  if (device_traits(device)->wide_bvh) {
    TRY(program_build(&tracer.single_program, device, "rays/trace_single.cl", options, log));
    TRY(program_kernel(&tracer.single_closest, tracer.single_program, "trace_closest", log));
    TRY(program_kernel(&tracer.single_any, tracer.single_program, "trace_any", log));
    TRY(program_kernel(&tracer.single_open, tracer.single_program, "trace_open", log));
  }
  *out = tracer;
  tracer = (Tracer){0};

done:
  tracer_free(&tracer);
  return status;
}

void tracer_free(Tracer *tracer)
{
  Kernel *kernels[] = {&tracer->packet_closest, &tracer->packet_any, &tracer->packet_open,
                       &tracer->single_closest, &tracer->single_any, &tracer->single_open};
  for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++) kernel_free(kernels[i]);
  *tracer = (Tracer){0};
}

static bool walks_alone(const Tracer *tracer, Coherence coherence)
{
  return coherence == RAYS_INCOHERENT && tracer->single_program;
}

Status trace_closest(const Tracer *tracer, Device *device, const DeviceScene *scene, const RayStream *stream,
                     uint32_t count, float t_min, const HitStream *hits, Coherence coherence, const char *sentence,
                     Log *log)
{
  bool alone = walks_alone(tracer, coherence);
  const DeviceBuffer *nodes = alone ? &scene->bvh8_nodes : &scene->bvh2_nodes;
  const DeviceBuffer *leaves = alone ? &scene->bvh8_blocks : &scene->bvh2_triangles;
  return device_launch(
      device, alone ? &tracer->single_closest : &tracer->packet_closest, work_items(device, count), count, sentence,
      ARGS(ARG_BUFFER(*nodes), ARG_BUFFER(*leaves), ARG_BUFFER(stream->rays), ARG(stream->capacity), ARG(count),
           ARG(t_min), ARG_BUFFER(hits->hits), ARG_BUFFER(hits->ids), ATTRIBUTE_ARGS(scene)),
      log);
}

static Status trace_segment(const Kernel *kernel, bool alone, Device *device, const DeviceScene *scene,
                            const RayStream *stream, uint32_t segment, uint32_t count, const DeviceBuffer *radiance,
                            const char *sentence, Log *log)
{
  const DeviceBuffer *nodes = alone ? &scene->bvh8_nodes : &scene->bvh2_nodes;
  const DeviceBuffer *leaves = alone ? &scene->bvh8_blocks : &scene->bvh2_triangles;
  return device_launch(
      device, kernel, work_items(device, count), count, sentence,
      ARGS(ARG_BUFFER(*nodes), ARG_BUFFER(*leaves), ARG_BUFFER(stream->rays), ARG(stream->capacity), ARG(count),
           ARG(segment), ARG_BUFFER(stream->slots), ARG_BUFFER(*radiance), ATTRIBUTE_ARGS(scene)),
      log);
}

Status trace_any(const Tracer *tracer, Device *device, const DeviceScene *scene, const RayStream *stream,
                 uint32_t segment, uint32_t count, const DeviceBuffer *radiance, Coherence coherence,
                 const char *sentence, Log *log)
{
  bool alone = walks_alone(tracer, coherence);
  return trace_segment(alone ? &tracer->single_any : &tracer->packet_any, alone, device, scene, stream, segment, count,
                       radiance, sentence, log);
}

Status trace_open(const Tracer *tracer, Device *device, const DeviceScene *scene, const RayStream *stream,
                  uint32_t segment, uint32_t count, const DeviceBuffer *radiance, Coherence coherence,
                  const char *sentence, Log *log)
{
  bool alone = walks_alone(tracer, coherence);
  return trace_segment(alone ? &tracer->single_open : &tracer->packet_open, alone, device, scene, stream, segment,
                       count, radiance, sentence, log);
}
