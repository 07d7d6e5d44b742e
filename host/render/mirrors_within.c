#include "render/mirrors_within.h"

#include <stdlib.h>
#include <string.h>

#include "render/bounce.h"
#include "shared/stream.h"

// Sends on what mirrors reflect where rays hit, and neither lights, the environment nor samples of lobes.
static Status hits_reflect(uint32_t *count, Frame *frame, const RayStream *from, uint32_t rays, uint32_t depth,
                           const Wave *wave, const CameraInfo *picture, const RayStream *to, Log *log)
{
  Status status = STATUS_OK;
  RayStream *transmitted = &frame->no_rays;
  uint32_t counts[STREAM_COUNTS];
  ShadeInfo info = bounce_shade_info(frame, wave, &(Bounce){.depth = depth});
  TRY(stream_take(&transmitted, frame, frame->request.plan.transmitted_rays, log));
  const ShadeStreams streams = {.rays = from,
                                .hits = &frame->hits,
                                .shadow = &frame->shadow,
                                .reflected = to,
                                .transmitted = transmitted,
                                .radiance = &frame->radiance,
                                .maps = &frame->shadow_maps,
                                .camera = &frame->camera};
  info.environment_light = info.environment_table = info.from_camera = 0;
  info.max_roughness = info.map_roughness = 0;
  info.receivers = 1;
  info.tiles_per_row = picture->tiles_per_row;
  info.tile_rows = (picture->height + TILE_SIZE - 1) / TILE_SIZE;
  TRY(shade(&frame->shader, frame->device, frame->scene, &streams, rays, &info, counts, "look for reflectors", log));
  *count = counts[STREAM_COUNT_REFLECTED];

done:
  stream_give_back(frame, transmitted);
  return status;
}

// The triangles on which rays [0, count) start, in the order of their slots, [rays]: that in a stream varies.
static Status sources_read(uint32_t *triangles, Frame *frame, const RayStream *stream, uint32_t count, uint32_t rays,
                           Log *log)
{
  Status status = STATUS_OK;
  uint32_t *sources = malloc(count * sizeof *sources), *slots = malloc(count * sizeof *slots);
  const size_t first = (size_t)RAY_DENSITY * stream->capacity * sizeof(float);
  if (!sources || !slots) {
    status = log_no_memory(log, "reflectors");
    goto done;
  }
  TRY(buffer_read_part(frame->device, &stream->rays, first, sources, count * sizeof *sources, log));
  TRY(buffer_read(frame->device, &stream->slots, slots, count * sizeof *slots, log));
  for (uint32_t i = 0; i < rays; i++) triangles[i] = HIT_NONE;
  for (uint32_t i = 0; i < count; i++)
    if (slots[i] < rays && sources[i] & RAY_FROM_MIRROR) triangles[slots[i]] = sources[i] & ~RAY_FROM_MIRROR;

done:
  free(sources);
  free(slots);
  return status;
}

Status mirrors_within_see(Reflector *within, Frame *frame, const uint32_t *starts, const Wave *wave,
                          const CameraInfo *picture, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t rays = wave_rays(wave);
  RayStream *reflected, *onward;
  uint32_t *triangles = malloc(rays * sizeof *triangles), count = 0;
  if (!triangles) return log_no_memory(log, "reflectors");
  memset(frame->taken, 0, sizeof frame->taken);
  frame->taken[0] = true;
  TRY(stream_take(&reflected, frame, true, log));
  TRY(stream_take(&onward, frame, true, log));
  TRY(buffer_zero(frame->device, &frame->radiance, log));
  TRY(hits_reflect(&count, frame, &frame->streams[0], rays, 0, wave, picture, reflected, log));
  if (count == 0) goto done;
  TRY(trace_closest(&frame->tracer, frame->device, frame->scene, reflected, count, 0, &frame->hits, RAYS_COHERENT,
                    "look for reflectors", log));
  TRY(hits_reflect(&count, frame, reflected, count, 1, wave, picture, onward, log));
  if (count == 0) goto done;
  TRY(sources_read(triangles, frame, onward, count, rays, log));
  for (uint32_t slot = 0; slot < rays; slot++)
    if (triangles[slot] != HIT_NONE) reflector_see(within, frame, starts, triangles[slot], NULL);

done:
  memset(frame->taken, 0, sizeof frame->taken);
  free(triangles);
  return status;
}
