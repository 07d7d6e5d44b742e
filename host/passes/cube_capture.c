#include "passes/cube_capture.h"

#include "passes/scene_args.h"
#include "shared/stream.h"

Status cube_capture_make(CubeCapture *out, Device *device, const DeviceScene *scene, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  CubeCapture capture = {0};
  Program *program = NULL;
  TRY(program_build(&program, device, "capture/cube_capture.cl", "", log));
  TRY(program_kernel(&capture.rays, program, "cube_rays", log));
  TRY(program_kernel(&capture.peel, program, "cube_peel", log));
  TRY(program_kernel(&capture.keep, program, "cube_keep", log));
  TRY(program_kernel(&capture.hull, program, "cube_hull", log));
  TRY(program_kernel(&capture.cells, program, "cube_cells", log));
  TRY(buffer_create(&capture.info, device, sizeof(CubeInfo), NULL, "cube map", log));
  TRY(buffer_create(&capture.left_out, device, scene->object_count * sizeof(uint32_t), NULL, "cube map", log));
  TRY(buffer_create(&capture.closeness, device, capacity * sizeof(float), NULL, "cube map", log));
  TRY(buffer_create(&capture.count, device, sizeof(uint32_t), NULL, "cube map", log));
  TRY(hit_stream_make(&capture.hits, device, capacity, log));
  *out = capture;
  capture = (CubeCapture){0};

done:
  cube_capture_free(&capture);
  return status;
}

void cube_capture_free(CubeCapture *capture)
{
  kernel_free(&capture->rays);
  kernel_free(&capture->peel);
  kernel_free(&capture->keep);
  kernel_free(&capture->hull);
  kernel_free(&capture->cells);
  buffer_free(&capture->info);
  buffer_free(&capture->left_out);
  buffer_free(&capture->closeness);
  buffer_free(&capture->count);
  hit_stream_free(&capture->hits);
  *capture = (CubeCapture){0};
}

Status cube_capture_aim(CubeCapture *capture, Device *device, const DeviceScene *scene, const CubeInfo *cube,
                        const uint32_t *left_out, Log *log)
{
  Status status = STATUS_OK;
  TRY(buffer_write(device, &capture->info, cube, sizeof *cube, log));
  TRY(buffer_write(device, &capture->left_out, left_out, scene->object_count * sizeof *left_out, log));

done:
  return status;
}

Status cube_capture_rays(const CubeCapture *capture, Device *device, const Wave *wave, float inward_m,
                         const RayStream *stream, Log *log)
{
  uint32_t rays = wave_rays(wave);
  return device_launch(device, &capture->rays, work_items(device, rays), rays, "generate rays of a cube map",
                       ARGS(ARG_BUFFER(capture->info), ARG(wave->first_tile), ARG(wave->tile_count), ARG(rays),
                            ARG(inward_m), ARG_BUFFER(stream->rays), ARG(stream->capacity), ARG_BUFFER(stream->slots)),
                       log);
}

// Sends on what goes past objects that are left out; *count becomes its number.
static Status rays_peel(const CubeCapture *capture, Device *device, const DeviceScene *scene, bool inward,
                        const RayStream *rays, uint32_t *count, const HitStream *hits, const HitStream *to,
                        const RayStream *onward, Log *log)
{
  Status status = STATUS_OK;
  DeviceBuffer counter = capture->count;
  uint32_t back = inward;
  TRY(buffer_zero(device, &counter, log));
  TRY(device_launch(device, &capture->peel, work_items(device, *count), *count, "pass the reflector",
                    ARGS(ARG_BUFFER(capture->info), ARG(back), ARG_BUFFER(rays->rays), ARG_BUFFER(rays->slots),
                         ARG(rays->capacity), ARG(*count), ARG_BUFFER(hits->hits), ARG_BUFFER(hits->ids),
                         ARG_BUFFER(scene->object_starts), ARG(scene->object_count), ARG_BUFFER(capture->left_out),
                         ARG_BUFFER(to->hits), ARG_BUFFER(to->ids), ARG_BUFFER(capture->closeness),
                         ARG_BUFFER(onward->rays), ARG_BUFFER(onward->slots), ARG_BUFFER(capture->count)),
                    log));
  TRY(buffer_read(device, &capture->count, count, sizeof *count, log));

done:
  return status;
}

Status cube_capture_trace(const CubeCapture *capture, const Tracer *tracer, Device *device, const DeviceScene *scene,
                          bool inward, const RayStream *rays, uint32_t count, const HitStream *hits,
                          const RayStream spare[2], Log *log)
{
  Status status = STATUS_OK;
  TRY(trace_closest(tracer, device, scene, rays, count, 0, hits, RAYS_COHERENT, "trace rays of a cube map", log));
  TRY(rays_peel(capture, device, scene, inward, rays, &count, hits, hits, &spare[0], log));
  for (int layer = 0; layer < CUBE_LAYERS_MOST && count > 0; layer++) {
    const RayStream *from = &spare[layer % 2], *onward = &spare[1 - layer % 2];
    TRY(trace_closest(tracer, device, scene, from, count, 0, &capture->hits, RAYS_COHERENT, "trace rays of a cube map",
                      log));
    TRY(rays_peel(capture, device, scene, inward, from, &count, &capture->hits, hits, onward, log));
  }

done:
  return status;
}

Status cube_capture_keep(const CubeCapture *capture, Device *device, const Wave *wave, float share,
                         const DeviceBuffer *radiance, const DeviceBuffer *texels, Log *log)
{
  size_t pixels = (size_t)wave->tile_count * TILE_PIXELS;
  return device_launch(
      device, &capture->keep, work_items(device, pixels), pixels, "keep a cube map",
      ARGS(ARG_BUFFER(capture->info), ARG(wave->first_tile), ARG(wave->tile_count), ARG(wave->sample_count), ARG(share),
           ARG_BUFFER(*radiance), ARG_BUFFER(capture->closeness), ARG_BUFFER(*texels)),
      log);
}

Status cube_capture_keep_hull(const CubeCapture *capture, Device *device, const Wave *wave, const DeviceBuffer *hull,
                              Log *log)
{
  uint32_t pixels = wave->tile_count * TILE_PIXELS;
  return device_launch(device, &capture->hull, work_items(device, pixels), pixels, "keep a reflector's hull",
                       ARGS(ARG_BUFFER(capture->info), ARG(wave->first_tile), ARG(pixels),
                            ARG_BUFFER(capture->closeness), ARG_BUFFER(*hull)),
                       log);
}

Status cube_capture_cells(const CubeCapture *capture, Device *device, uint32_t size, const DeviceBuffer *texels,
                          const DeviceBuffer *cells, Log *log)
{
  size_t count = CUBE_TEXELS((size_t)size) / (CUBE_CELL * CUBE_CELL);
  return device_launch(device, &capture->cells, work_items(device, count), count, "find what is close in a cube map",
                       ARGS(ARG_BUFFER(capture->info), ARG_BUFFER(*texels), ARG_BUFFER(*cells)), log);
}
