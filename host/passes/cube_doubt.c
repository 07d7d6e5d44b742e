#include "passes/cube_doubt.h"

#include <math.h>

#include "passes/scene_args.h"
#include "shared/stream.h"

Status cube_doubt_make(CubeDoubt *out, Device *device, uint32_t capacity, uint32_t size_px, Log *log)
{
  Status status = STATUS_OK;
  CubeDoubt doubt = {0};
  Program *program = NULL;
  TRY(program_build(&program, device, "capture/cube_doubt.cl", "", log));
  TRY(program_kernel(&doubt.turn, program, "cube_turn", log));
  TRY(program_kernel(&doubt.change, program, "cube_change", log));
  TRY(program_kernel(&doubt.flag, program, "cube_flag", log));
  TRY(program_kernel(&doubt.keep, program, "cube_change_keep", log));
  TRY(program_kernel(&doubt.doubt, program, "cube_doubt", log));
  TRY(buffer_create(&doubt.changes, device, capacity * sizeof(float), NULL, "cube maps", log));
  TRY(buffer_create(&doubt.seen_aside, device, capacity * sizeof(Float4), NULL, "cube maps", log));
  TRY(buffer_create(&doubt.kept, device, CUBE_TEXELS((size_t)size_px) * sizeof(float), NULL, "cube maps", log));
  *out = doubt;
  doubt = (CubeDoubt){0};

done:
  cube_doubt_free(&doubt);
  return status;
}

void cube_doubt_free(CubeDoubt *doubt)
{
  Kernel *kernels[] = {&doubt->turn, &doubt->change, &doubt->flag, &doubt->keep, &doubt->doubt};
  for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++) kernel_free(kernels[i]);
  buffer_free(&doubt->changes);
  buffer_free(&doubt->seen_aside);
  buffer_free(&doubt->kept);
  *doubt = (CubeDoubt){0};
}

Status cube_doubt_turn(const CubeDoubt *doubt, Device *device, const DeviceBuffer *info, float aside_m, double turn_rad,
                       const RayStream *rays, uint32_t count, const HitStream *hits, const RayStream *turned, Log *log)
{
  float turn_cos = (float)cos(turn_rad), turn_sin = (float)sin(turn_rad);
  return device_launch(
      device, &doubt->turn, work_items(device, count), count, "look at a cube map from beside it",
      ARGS(ARG_BUFFER(*info), ARG(aside_m), ARG(turn_cos), ARG(turn_sin), ARG_BUFFER(rays->rays), ARG(rays->capacity),
           ARG(count), ARG_BUFFER(hits->hits), ARG_BUFFER(hits->ids), ARG_BUFFER(turned->rays)),
      log);
}

Status cube_doubt_change(const CubeDoubt *doubt, Device *device, uint32_t count, const DeviceBuffer *radiance, Log *log)
{
  return device_launch(
      device, &doubt->change, work_items(device, count), count, "find what hangs on the view",
      ARGS(ARG(count), ARG_BUFFER(*radiance), ARG_BUFFER(doubt->seen_aside), ARG_BUFFER(doubt->changes)), log);
}

Status cube_doubt_flag(const CubeDoubt *doubt, Device *device, const RayStream *spawned, uint32_t count, Log *log)
{
  if (count == 0) return STATUS_OK;
  return device_launch(device, &doubt->flag, work_items(device, count), count, "find what hangs on the view",
                       ARGS(ARG_BUFFER(spawned->slots), ARG(count), ARG_BUFFER(doubt->changes)), log);
}

Status cube_doubt_keep(const CubeDoubt *doubt, Device *device, const DeviceBuffer *info, const Wave *wave,
                       const HitStream *hits, const DeviceBuffer *names, Log *log)
{
  uint32_t pixels = wave->tile_count * TILE_PIXELS;
  return device_launch(device, &doubt->keep, work_items(device, pixels), pixels, "find what hangs on the view",
                       ARGS(ARG_BUFFER(*info), ARG(wave->first_tile), ARG(pixels), ARG_BUFFER(doubt->changes),
                            ARG_BUFFER(hits->ids), ARG_BUFFER(doubt->kept), ARG_BUFFER(*names)),
                       log);
}

Status cube_doubt_fill(const CubeDoubt *doubt, Device *device, const DeviceBuffer *info, uint32_t size_px,
                       const DeviceBuffer *texels, const DeviceBuffer *doubts, Log *log)
{
  size_t count = CUBE_TEXELS((size_t)size_px);
  return device_launch(device, &doubt->doubt, work_items(device, count), count, "doubt a cube map",
                       ARGS(ARG_BUFFER(*info), ARG_BUFFER(*texels), ARG_BUFFER(doubt->kept), ARG_BUFFER(*doubts)), log);
}
