#include "passes/sure_maps.h"

#include <stdio.h>

#include "shared/raster.h"

static uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }
static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

static uint64_t blocks_of(const ShadowInfo *info)
{
  return (uint64_t)info->view_count * (info->size_px / 4) * (info->size_px / 4);
}

static uint64_t rows_of(const ShadowInfo *info) { return (SHADOW_NUMBERS - 1) * blocks_of(info); }

uint64_t sure_maps_bytes(const ShadowInfo *info)
{
  return blocks_of(info) * sizeof(ShadowBlock) + rows_of(info) * sizeof(ShadowRow);
}

static Status bins_make(SureRaster *raster, Device *device, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  TRY(program_build(&program, device, "raster/shadow_texels.cl", "", log));
  TRY(program_kernel(&raster->setup, program, "shadow_setup", log));
  TRY(program_kernel(&raster->bins, program, "shadow_bins", log));
  TRY(raster_bins_make(&raster->binned, device, raster->pass_chunks, SURE_WORDS, log));

done:
  return status;
}

static Status direct_make(SureRaster *raster, Device *device, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  char options[32];
  size_t triangles = (size_t)raster->pass_chunks * RASTER_CHUNK;
  snprintf(options, sizeof options, "-D GROUP_SIZE=%u", device_traits(device)->group_size);
  TRY(program_build(&program, device, "raster/shadow_direct.cl", options, log));
  TRY(program_kernel(&raster->take, program, "shadow_take", log));
  TRY(program_kernel(&raster->place, program, "shadow_place", log));
  TRY(program_kernel(&raster->fill, program, "shadow_fill", log));
  TRY(program_kernel(&raster->tiles, program, "shadow_tiles", log));
  TRY(buffer_create(&raster->records, device, triangles * SURE_DIRECT_WORDS * sizeof(uint32_t), NULL, "sure maps",
                    log));
  TRY(buffer_create(&raster->lists, device, triangles * RASTER_LARGE_BINS * sizeof(uint32_t), NULL, "sure maps", log));

done:
  return status;
}

// Passes are as large as those of the direct way of other rasters where the device has 16 times as much memory.
static RasterWay pass_way(const SureRaster *raster, const Device *device)
{
  const uint64_t triangle_bytes = (SURE_DIRECT_WORDS + RASTER_LARGE_BINS) * sizeof(uint32_t);
  bool large = device_info(device)->memory_bytes / 16 > 4096 * triangle_bytes * RASTER_CHUNK;
  return raster->way == RASTER_WAY_DIRECT && large ? RASTER_WAY_DIRECT : RASTER_WAY_BINS;
}

Status sure_raster_make(SureRaster *out, Device *device, const RasterScene *triangles, const RasterOptions *options,
                        Log *log)
{
  Status status = STATUS_OK;
  SureRaster raster = {.way = options->way};
  bool direct = device_info(device)->is_gpu && device_traits(device)->lanes == 1;
  if (raster.way == RASTER_WAY_BEST) raster.way = direct ? RASTER_WAY_DIRECT : RASTER_WAY_BINS;
  raster.pass_chunks =
      raster_pass_chunks(options, pass_way(&raster, device), triangles->chunk_count * SHADOW_VIEWS_MOST);
  if (raster.pass_chunks < SHADOW_VIEWS_MOST) raster.pass_chunks = SHADOW_VIEWS_MOST;
  TRY((raster.way == RASTER_WAY_BINS ? bins_make : direct_make)(&raster, device, log));
  *out = raster;
  raster = (SureRaster){0};

done:
  sure_raster_free(&raster);
  return status;
}

void sure_raster_free(SureRaster *raster)
{
  Kernel *kernels[] = {&raster->setup, &raster->bins, &raster->take, &raster->place, &raster->fill, &raster->tiles};
  for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++) kernel_free(kernels[i]);
  DeviceBuffer *buffers[] = {&raster->records, &raster->lists, &raster->counts, &raster->starts, &raster->ends};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) buffer_free(buffers[i]);
  raster_bins_free(&raster->binned);
  *raster = (SureRaster){0};
}

// What both ways are given.
typedef struct SureDrawing {
  SureMaps *maps;
  SureRaster *raster;
  Device *device;
  const RasterScene *triangles;
  const DeviceBuffer *solid;
  uint32_t skip_facing, views, columns;
} SureDrawing;

static Status bins_pass(const SureDrawing *drawing, uint32_t first, uint32_t chunks, uint32_t begin, Log *log)
{
  Status status = STATUS_OK;
  const SureRaster *raster = drawing->raster;
  const RasterScene *triangles = drawing->triangles;
  const SureMaps *maps = drawing->maps;
  uint64_t items = (uint64_t)chunks * drawing->views, bins = (uint64_t)drawing->columns * drawing->columns;
  uint32_t size = maps->info.size_px;
  TRY(device_launch(drawing->device, &raster->setup, items, items * RASTER_CHUNK,
                    "set up and bin triangles of sure maps",
                    ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ARG(first), ARG(chunks),
                         ARG_BUFFER(maps->views), ARG(drawing->views), ARG(drawing->columns),
                         ARG_BUFFER(*drawing->solid), ARG(drawing->skip_facing), BIN_ARGS(&raster->binned)),
                    log));
  TRY(device_launch(drawing->device, &raster->bins, bins * drawing->views, (uint64_t)size * size * drawing->views,
                    "raster sure maps",
                    ARGS(ARG(size), ARG(drawing->views), ARG(drawing->columns), ARG(chunks), BIN_ARGS(&raster->binned),
                         ARG(begin), ARG_BUFFER(maps->blocks), ARG_BUFFER(maps->rows)),
                    log));

done:
  return status;
}

static Status direct_pass(const SureDrawing *drawing, uint32_t first, uint32_t chunks, uint32_t begin, Log *log)
{
  Status status = STATUS_OK;
  Device *device = drawing->device;
  SureRaster *raster = drawing->raster;
  const RasterScene *triangles = drawing->triangles;
  const SureMaps *maps = drawing->maps;
  const uint32_t views = drawing->views, columns = drawing->columns, size = maps->info.size_px;
  const uint32_t group = device_traits(device)->group_size, lists = views * (columns * columns + 1);
  uint32_t first_triangle = first * RASTER_CHUNK, count = chunks * RASTER_CHUNK;
  uint64_t tiles = (uint64_t)divide_up(size / 4, 2) * divide_up(size / 4, group / 32) * views;
  TRY(buffer_zero(device, &raster->counts, log));
  TRY(device_launch(device, &raster->take, (uint64_t)count * views, (uint64_t)count * views,
                    "set up triangles of sure maps",
                    ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ARG(first_triangle), ARG(count),
                         ARG_BUFFER(maps->views), ARG(views), ARG(columns), ARG_BUFFER(*drawing->solid),
                         ARG(drawing->skip_facing), ARG_BUFFER(raster->records), ARG_BUFFER(raster->counts)),
                    log));
  TRY(device_launch(device, &raster->place, lists, lists, "place the bins of sure maps",
                    ARGS(ARG(lists), ARG_BUFFER(raster->counts), ARG_BUFFER(raster->starts), ARG_BUFFER(raster->ends)),
                    log));
  TRY(device_launch(device, &raster->fill, raster_box_items(device), 0, "fill the bins of sure maps",
                    ARGS(ARG(columns), ARG_BUFFER(raster->records), ARG_BUFFER(raster->counts),
                         ARG_BUFFER(raster->ends), ARG_BUFFER(raster->lists)),
                    log));
  TRY(device_launch(device, &raster->tiles, tiles * group, (uint64_t)size * size * views, "raster sure maps",
                    ARGS(ARG(size), ARG(views), ARG(columns), ARG_BUFFER(raster->records), ARG_BUFFER(raster->starts),
                         ARG_BUFFER(raster->ends), ARG_BUFFER(raster->lists), ARG(begin), ARG_BUFFER(maps->blocks),
                         ARG_BUFFER(maps->rows)),
                    log));

done:
  return status;
}

// Makes room for a map's bins.
static Status bins_divide(SureRaster *raster, Device *device, uint32_t columns, uint32_t views, Log *log)
{
  Status status = STATUS_OK;
  size_t bins = (size_t)columns * columns, bytes = views * (bins + 1) * sizeof(uint32_t);
  if (raster->way == RASTER_WAY_BINS)
    return raster_bins_divide(&raster->binned, device, raster->pass_chunks, bins, log);
  if (raster->starts.memory && raster->starts.bytes >= bytes) return STATUS_OK;
  DeviceBuffer *buffers[] = {&raster->counts, &raster->starts, &raster->ends};
  for (int i = 0; i < 3; i++) {
    buffer_free(buffers[i]);
    TRY(buffer_create(buffers[i], device, bytes + (i == 0 ? SURE_COUNTS * sizeof(uint32_t) : 0), NULL, "sure maps",
                      log));
  }

done:
  return status;
}

// By passes over the scene's chunks, as depth maps are (passes/raster_depth.c).
Status sure_maps_draw(SureMaps *out, SureRaster *raster, Device *device, const RasterScene *triangles,
                      const ShadowFit *fit, const DeviceBuffer *solid, bool skip_facing, Log *log)
{
  Status status = STATUS_OK;
  const ShadowInfo *info = &fit->info;
  const uint32_t views = info->view_count, bin_px = raster->way == RASTER_WAY_BINS ? RASTER_BIN_PX : SURE_BIN_PX,
                 columns = divide_up(info->size_px, bin_px);
  uint32_t pass_chunks = raster->pass_chunks / views;
  const SureDrawing drawing = {out, raster, device, triangles, solid, skip_facing, views, columns};
  out->info = *info;
  TRY(buffer_create(&out->info_buffer, device, sizeof *info, info, "sure maps", log));
  TRY(buffer_create(&out->views, device, views * sizeof *fit->views, fit->views, "sure maps", log));
  TRY(buffer_create(&out->blocks, device, blocks_of(info) * sizeof(ShadowBlock), NULL, "sure maps", log));
  TRY(buffer_create(&out->rows, device, rows_of(info) * sizeof(ShadowRow), NULL, "sure maps", log));
  TRY(bins_divide(raster, device, columns, views, log));
  for (uint32_t first = 0, begin = 1; first < triangles->chunk_count || begin; first += pass_chunks, begin = 0) {
    uint32_t chunks = smaller(pass_chunks, triangles->chunk_count - first);
    TRY((raster->way == RASTER_WAY_BINS ? bins_pass : direct_pass)(&drawing, first, chunks, begin, log));
  }

done:
  return status;
}

void sure_maps_free(SureMaps *maps)
{
  buffer_free(&maps->info_buffer);
  buffer_free(&maps->views);
  buffer_free(&maps->blocks);
  buffer_free(&maps->rows);
  *maps = (SureMaps){0};
}
