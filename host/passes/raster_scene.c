#include "passes/raster_scene.h"

#include <stdio.h>

#include "shared/bvh.h"
#include "shared/raster.h"

RasterWay raster_way(const RasterOptions *options, const Device *device)
{
  const DeviceInfo *info = device_info(device);
  if (options->way != RASTER_WAY_BEST) return options->way;
  bool direct = info->is_gpu && device_traits(device)->lanes == 1 && info->int64_atomics;
  return direct ? RASTER_WAY_DIRECT : RASTER_WAY_BINS;
}

uint32_t raster_pass_chunks(const RasterOptions *options, const Device *device, RasterWay way)
{
  const bool direct = way == RASTER_WAY_DIRECT;
  const uint64_t usual = direct ? 8192 : 2048, chunk_bytes = (direct ? 24 : 160) * RASTER_CHUNK;
  const uint64_t room = device_info(device)->memory_bytes / 8 / chunk_bytes + 1;
  if (options->pass_chunks) return options->pass_chunks;
  return (uint32_t)(usual < room ? usual : room);
}

uint32_t raster_pass_tiles(const RasterOptions *options, const Device *device)
{
  const uint64_t tile_bytes = RASTER_TILE_VECTORS * 4 * sizeof(uint32_t);
  const uint64_t room = device_info(device)->memory_bytes / 64 / tile_bytes + 1;
  if (options->pass_tiles) return options->pass_tiles;
  return (uint32_t)(RASTER_PASS_TILES < room ? RASTER_PASS_TILES : room);
}

const char *raster_visibility_path(RasterWay way)
{
  return way == RASTER_WAY_DIRECT ? "raster/visibility_direct.cl" : "raster/visibility.cl";
}

Status raster_program(Program **out, Device *device, const DeviceScene *scene, const char *path, uint32_t uses,
                      Log *log)
{
  char surfaces[128] = "", registers[64] = "", options[256];
  const DeviceTraits *traits = device_traits(device);
  program_registers_option(registers, sizeof registers, traits->raster_registers);
  device_scene_options(scene, uses, surfaces, sizeof surfaces);
  snprintf(options, sizeof options, "%s%s-D GROUP_SIZE=%u", registers, surfaces, traits->group_size);
  return program_build(out, device, path, options, log);
}

Status raster_scene_make(RasterScene *out, Device *device, const DeviceScene *scene, const RasterOptions *options,
                         Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  Kernel kernel = {0};
  uint32_t triangles = (uint32_t)(scene->bvh2_triangles.bytes / sizeof(BvhTriangle));
  RasterScene made = {.triangle_count = triangles,
                      .chunk_count = (triangles + RASTER_CHUNK - 1) / RASTER_CHUNK,
                      .has_shadowless = scene->has_shadowless};
  TRY(raster_program(&program, device, scene, raster_visibility_path(raster_way(options, device)), TESTS_MASKS, log));
  TRY(program_kernel(&kernel, program, "triangle_pack", log));
  size_t blocks = (size_t)made.chunk_count * RASTER_CHUNK_BLOCKS;
  TRY(buffer_create(&made.blocks, device, blocks * sizeof(RasterBlock), NULL, "triangles to raster", log));
  TRY(buffer_create(&made.bounds, device, made.chunk_count * sizeof(RasterBounds), NULL, "triangles to raster", log));
  TRY(device_launch(
      device, &kernel, (size_t)made.chunk_count * device_traits(device)->group_size, triangles,
      "pack triangles for raster",
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
