// Traverse + intersect passes: cl/rays/trace_packet.cl and cl/rays/trace_single.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/ray_stream.h"

// Rays whose neighbours go the same way walk in packets; others walk alone, where the device has the wide tree.
typedef enum Coherence { RAYS_COHERENT, RAYS_INCOHERENT } Coherence;

typedef struct Tracer {
  Program *packet_program, *single_program;
  Kernel packet_closest, packet_any, packet_open;
  Kernel single_closest, single_any, single_open;  // only where the scene has the wide tree
} Tracer;

Status tracer_make(Tracer *out, Device *device, const DeviceScene *scene, Log *log);
void tracer_free(Tracer *tracer);

// Nearest hit of rays [0, count) with t_min < t <= t_max; back faces of single-sided triangles are open.
Status trace_closest(const Tracer *tracer, Device *device, const DeviceScene *scene, const RayStream *stream,
                     uint32_t count, float t_min, const HitStream *hits, Coherence coherence, const char *sentence,
                     Log *log);

// Adds the weight of each ray of [0, count) in segment `segment` to radiance[slot] if nothing lies in 0 < t < t_max.
Status trace_any(const Tracer *tracer, Device *device, const DeviceScene *scene, const RayStream *stream,
                 uint32_t segment, uint32_t count, const DeviceBuffer *radiance, Coherence coherence,
                 const char *sentence, Log *log);

// The same for rays that pass single-sided triangles from behind, as those of trace_closest do.
Status trace_open(const Tracer *tracer, Device *device, const DeviceScene *scene, const RayStream *stream,
                  uint32_t segment, uint32_t count, const DeviceBuffer *radiance, Coherence coherence,
                  const char *sentence, Log *log);
