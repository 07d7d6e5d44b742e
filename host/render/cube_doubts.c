#include "render/cube_doubts.h"

#include <math.h>
#include <string.h>

#include "render/bounce.h"
#include "shared/stream.h"

// Streams of a wave: rays from the centre, the same seen from beside it, what hits send on.
typedef struct DoubtStreams {
  RayStream *rays, *turned, *reflected, *transmitted;
} DoubtStreams;

static Status hits_shade(Frame *frame, const DoubtStreams *streams, const RayStream *rays, const Wave *wave,
                         const DeviceBuffer *radiance, uint32_t counts[STREAM_COUNTS], Log *log)
{
  Status status = STATUS_OK;
  DeviceBuffer cleared = *radiance;
  ShadeInfo info = bounce_shade_info(frame, wave, &(Bounce){.first = true});
  ShadeStreams to = {.rays = rays,
                     .hits = &frame->hits,
                     .shadow = &frame->shadow,
                     .reflected = streams->reflected,
                     .transmitted = streams->transmitted,
                     .radiance = radiance,
                     .maps = &frame->shadow_maps,
                     .camera = &frame->camera};
  info.reflect = 1;
  info.casting_lights = 0;
  TRY(buffer_zero(frame->device, &cleared, log));
  TRY(bounce_shade(frame, &to, wave_rays(wave), &info, RAYS_COHERENT, counts, log));

done:
  return status;
}

static Status wave_doubt(Frame *frame, const CubeDoubt *doubt, const DoubtStreams *streams, const Wave *wave,
                         float aside_m, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  const CubeCapture *capture = &frame->cube_capture;
  DeviceBuffer changes = doubt->changes;
  uint32_t rays = wave_rays(wave), counts[STREAM_COUNTS];
  TRY(buffer_zero(device, &changes, log));
  TRY(cube_capture_rays(capture, device, wave, 0, streams->turned, log));
  TRY(cube_capture_rays(capture, device, wave, 0, streams->rays, log));
  TRY(cube_capture_trace(capture, &frame->tracer, device, frame->scene, false, streams->rays, rays, &frame->hits,
                         (RayStream[2]){*streams->reflected, *streams->transmitted}, log));
  TRY(hits_shade(frame, streams, streams->rays, wave, &frame->radiance, counts, log));
  TRY(cube_doubt_flag(doubt, device, streams->reflected, counts[STREAM_COUNT_REFLECTED], log));
  TRY(cube_doubt_flag(doubt, device, streams->transmitted, counts[STREAM_COUNT_TRANSMITTED], log));
  for (int eye = 0; eye < DOUBT_EYES; eye++) {
    TRY(cube_doubt_turn(doubt, device, &capture->info, aside_m, 2 * M_PI * eye / DOUBT_EYES, streams->rays, rays,
                        &frame->hits, streams->turned, log));
    TRY(hits_shade(frame, streams, streams->turned, wave, &doubt->seen_aside, counts, log));
    TRY(cube_doubt_change(doubt, device, rays, &frame->radiance, log));
  }
  TRY(cube_doubt_keep(doubt, device, &capture->info, wave, &frame->hits, &frame->hybrid_reflect.names, log));

done:
  return status;
}

Status cube_doubts_draw(Frame *frame, const CubeDoubt *doubt, const CubeInfo *cube, Log *log)
{
  Status status = STATUS_OK;
  DoubtStreams streams;
  RayStream **all[] = {&streams.rays, &streams.turned, &streams.reflected, &streams.transmitted};
  uint32_t tiles = CUBE_TEXELS(cube->size) / TILE_PIXELS, most = frame->capacity / TILE_PIXELS;
  memset(frame->taken, 0, sizeof frame->taken);
  for (size_t i = 0; i < sizeof all / sizeof *all; i++) TRY(stream_take(all[i], frame, true, log));
  for (uint32_t tile = 0; tile < tiles; tile += most) {
    Wave wave = {tile, tiles - tile < most ? tiles - tile : most, 0, 1};
    TRY(wave_doubt(frame, doubt, &streams, &wave, cube->reach_m, log));
  }
  TRY(cube_doubt_fill(doubt, frame->device, &frame->cube_capture.info, cube->size, &frame->cube_reflect.texels,
                      &frame->hybrid_reflect.doubts, log));

done:
  return status;
}
