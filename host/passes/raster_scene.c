#include "passes/raster_scene.h"

#include "shared/bvh.h"
#include "shared/raster.h"

Status raster_scene_make(RasterScene *out, Device *device, const DeviceScene *scene, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  Kernel kernel = {0};
  uint32_t triangles = (uint32_t)(scene->bvh2_triangles.bytes / sizeof(BvhTriangle));
  RasterScene made = {.triangle_count = triangles, .chunk_count = (triangles + RASTER_CHUNK - 1) / RASTER_CHUNK};
  TRY(program_build(&program, device, "raster/triangle_pack.cl", "", log));
  TRY(program_kernel(&kernel, program, "triangle_pack", log));
  size_t blocks = (size_t)made.chunk_count * RASTER_CHUNK_BLOCKS;
  TRY(buffer_create(&made.blocks, device, blocks * sizeof(RasterBlock), NULL, "triangles to raster", log));
  TRY(buffer_create(&made.bounds, device, made.chunk_count * sizeof(RasterBounds), NULL, "triangles to raster", log));
  TRY(device_launch(
      device, &kernel, made.chunk_count, triangles, "pack triangles for raster",
      ARGS(ARG_BUFFER(scene->bvh2_triangles), ARG(triangles), ARG_BUFFER(made.blocks), ARG_BUFFER(made.bounds)), log));
  *out = made;
  made = (RasterScene){0};

done:
  kernel_free(&kernel);
  raster_scene_free(&made);
  return status;
}

void raster_scene_free(RasterScene *scene)
{
  buffer_free(&scene->blocks);
  buffer_free(&scene->bounds);
  *scene = (RasterScene){0};
}

RasterWay raster_way(const RasterOptions *options, const Device *device, bool needs_int64_atomics)
{
  const DeviceInfo *info = device_info(device);
  if (options->way != RASTER_WAY_BEST) return options->way;
  bool direct = info->is_gpu && device_traits(device)->lanes == 1 && (info->int64_atomics || !needs_int64_atomics);
  return direct ? RASTER_WAY_DIRECT : RASTER_WAY_BINS;
}

RasterProgramOptions raster_scene_options(const DeviceScene *scene)
{
  RasterProgramOptions options = {""};
  if (scene->has_masks) device_scene_options(scene, options.text, sizeof options.text);
  return options;
}
