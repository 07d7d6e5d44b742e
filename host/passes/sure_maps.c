#include "passes/sure_maps.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "shared/raster.h"

static uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }
static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

static uint32_t tile_columns_of(const ShadowInfo *info) { return divide_up(info->size_px, SHADOW_TILE_PX); }

static uint32_t tiles_of(const ShadowInfo *info)
{
  return info->view_count * tile_columns_of(info) * tile_columns_of(info);
}

static const uint64_t block_bytes = sizeof(ShadowBlock) + (SHADOW_NUMBERS - 1) * sizeof(ShadowRow);

uint64_t sure_maps_bytes(const ShadowInfo *info)
{
  return (uint64_t)tiles_of(info) * (sizeof(ShadowTile) + SHADOW_TILE_BLOCKS * block_bytes);
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
  TRY(program_kernel(&raster->squares, program, "shadow_squares", log));
  TRY(program_kernel(&raster->sum_up, program, "shadow_sum_up", log));
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
  Kernel *kernels[] = {&raster->setup, &raster->bins,    &raster->take,  &raster->place,
                       &raster->fill,  &raster->squares, &raster->sum_up};
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

static uint64_t texels_known(const SureMaps *maps)
{
  return (uint64_t)maps->tile_count * SHADOW_TILE_PX * SHADOW_TILE_PX;
}

static Status bins_pass(const SureDrawing *drawing, uint32_t first, uint32_t chunks, Log *log)
{
  Status status = STATUS_OK;
  const SureRaster *raster = drawing->raster;
  const RasterScene *triangles = drawing->triangles;
  const SureMaps *maps = drawing->maps;
  uint64_t items = (uint64_t)chunks * drawing->views, bins = (uint64_t)drawing->columns * drawing->columns;
  uint32_t size = maps->info.size_px;
  TRY(device_launch(
      drawing->device, &raster->setup, items, items * RASTER_CHUNK, "set up and bin triangles of sure maps",
      ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ARG(first), ARG(chunks),
           ARG_BUFFER(maps->views), ARG(drawing->views), ARG(drawing->columns), ARG_BUFFER(*drawing->solid),
           ARG(drawing->skip_facing), ARG_BUFFER(maps->tiles), ARG(maps->tile_columns), BIN_ARGS(&raster->binned)),
      log));
  TRY(device_launch(drawing->device, &raster->bins, bins * drawing->views, texels_known(maps), "raster sure maps",
                    ARGS(ARG(size), ARG(drawing->views), ARG(drawing->columns), ARG(chunks), BIN_ARGS(&raster->binned),
                         ARG_BUFFER(maps->tiles), ARG(maps->tile_columns), ARG_BUFFER(maps->blocks),
                         ARG_BUFFER(maps->rows), ARG(maps->block_count)),
                    log));

done:
  return status;
}

static Status direct_pass(const SureDrawing *drawing, uint32_t first, uint32_t chunks, Log *log)
{
  Status status = STATUS_OK;
  Device *device = drawing->device;
  SureRaster *raster = drawing->raster;
  const RasterScene *triangles = drawing->triangles;
  const SureMaps *maps = drawing->maps;
  const uint32_t views = drawing->views, columns = drawing->columns, size = maps->info.size_px;
  const uint32_t group = device_traits(device)->group_size, lists = views * (columns * columns + 1);
  uint32_t first_triangle = first * RASTER_CHUNK, count = chunks * RASTER_CHUNK;
  uint64_t tiles = tiles_of(&maps->info), squares = tiles * (SHADOW_TILE_PX * SHADOW_TILE_PX / group);
  TRY(buffer_zero(device, &raster->counts, log));
  TRY(device_launch(
      device, &raster->take, (uint64_t)count * views, (uint64_t)count * views, "set up triangles of sure maps",
      ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ARG(first_triangle), ARG(count),
           ARG_BUFFER(maps->views), ARG(views), ARG(columns), ARG_BUFFER(*drawing->solid), ARG(drawing->skip_facing),
           ARG_BUFFER(maps->tiles), ARG(maps->tile_columns), ARG_BUFFER(raster->records), ARG_BUFFER(raster->counts)),
      log));
  TRY(device_launch(device, &raster->place, lists, lists, "place the bins of sure maps",
                    ARGS(ARG(lists), ARG_BUFFER(raster->counts), ARG_BUFFER(raster->starts), ARG_BUFFER(raster->ends)),
                    log));
  TRY(device_launch(device, &raster->fill, raster_box_items(device), 0, "fill the bins of sure maps",
                    ARGS(ARG(columns), ARG_BUFFER(raster->records), ARG_BUFFER(raster->counts),
                         ARG_BUFFER(raster->ends), ARG_BUFFER(raster->lists)),
                    log));
  TRY(device_launch(
      device, &raster->squares, squares * group, texels_known(maps), "raster sure maps",
      ARGS(ARG(size), ARG(views), ARG(columns), ARG_BUFFER(raster->records), ARG_BUFFER(raster->starts),
           ARG_BUFFER(raster->ends), ARG_BUFFER(raster->lists), ARG_BUFFER(maps->tiles), ARG(maps->tile_columns),
           ARG_BUFFER(maps->blocks), ARG_BUFFER(maps->rows), ARG(maps->block_count)),
      log));
  TRY(device_launch(
      device, &raster->sum_up, tiles, tiles, "sum up tiles of sure maps",
      ARGS(ARG(size), ARG(views), ARG_BUFFER(maps->tiles), ARG(maps->tile_columns), ARG_BUFFER(maps->blocks)), log));

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

Status sure_maps_aim(SureMaps *out, Device *device, const ShadowFit *fit, bool marked, Log *log)
{
  Status status = STATUS_OK;
  const ShadowInfo *info = &fit->info;
  const uint32_t views = info->view_count;
  out->info = *info;
  out->tile_columns = tile_columns_of(info);
  TRY(buffer_create(&out->info_buffer, device, sizeof *info, info, "sure maps", log));
  TRY(buffer_create(&out->views, device, views * sizeof *fit->views, fit->views, "sure maps", log));
  if (!marked) return STATUS_OK;
  TRY(buffer_create(&out->marks, device, tiles_of(info) * sizeof(uint32_t), NULL, "sure maps", log));
  TRY(buffer_fill_words(device, &out->marks, SHADOW_TILE_UNKNOWN, log));

done:
  return status;
}

// What cl/rays/shadow_mark.cl made a mark of.
static float least_of(uint32_t mark)
{
  float least;
  uint32_t bits = mark >> 31 ? mark & 0x7fffffffu : ~mark;
  memcpy(&least, &bits, sizeof least);
  return least;
}

// The tiles, and room for the blocks of those that are known.
static Status tiles_make(SureMaps *maps, Device *device, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t count = tiles_of(&maps->info);
  const bool marked = maps->marks.memory;
  uint32_t *marks = calloc(count + 1, sizeof *marks);
  ShadowTile *tiles = calloc(count + 1, sizeof *tiles);
  if (!marks || !tiles) {
    status = log_no_memory(log, "sure maps");
    goto done;
  }
  if (marked) TRY(buffer_read(device, &maps->marks, marks, count * sizeof *marks, log));
  maps->tile_count = 0;
  for (uint32_t i = 0; i < count; i++) {
    bool known = marks[i] != SHADOW_TILE_UNKNOWN;
    tiles[i] = (ShadowTile){known ? SHADOW_TILE_BLOCKS * maps->tile_count : SHADOW_TILE_UNKNOWN,
                            marked && known ? least_of(marks[i]) : -INFINITY, -INFINITY, -INFINITY};
    maps->tile_count += known;
  }
  maps->block_count = SHADOW_TILE_BLOCKS * maps->tile_count;
  const size_t blocks = maps->block_count;
  TRY(buffer_create(&maps->tiles, device, count * sizeof *tiles, tiles, "sure maps", log));
  TRY(buffer_create(&maps->blocks, device, blocks * sizeof(ShadowBlock), NULL, "sure maps", log));
  TRY(buffer_create(&maps->rows, device, (SHADOW_NUMBERS - 1) * blocks * sizeof(ShadowRow), NULL, "sure maps", log));

done:
  buffer_free(&maps->marks);
  free(marks);
  free(tiles);
  return status;
}

// By passes over the scene's chunks, as depth maps are (passes/raster_depth.c).
Status sure_maps_draw(SureMaps *maps, SureRaster *raster, Device *device, const RasterScene *triangles,
                      const DeviceBuffer *solid, bool skip_facing, Log *log)
{
  Status status = STATUS_OK;
  const ShadowInfo *info = &maps->info;
  const uint32_t views = info->view_count, bin_px = raster->way == RASTER_WAY_BINS ? RASTER_BIN_PX : SURE_BIN_PX,
                 columns = divide_up(info->size_px, bin_px);
  uint32_t pass_chunks = raster->pass_chunks / views;
  const SureDrawing drawing = {maps, raster, device, triangles, solid, skip_facing, views, columns};
  TRY(tiles_make(maps, device, log));
  if (maps->tile_count == 0) goto done;
  TRY(bins_divide(raster, device, columns, views, log));
  for (uint32_t first = 0; first < triangles->chunk_count; first += pass_chunks) {
    uint32_t chunks = smaller(pass_chunks, triangles->chunk_count - first);
    TRY((raster->way == RASTER_WAY_BINS ? bins_pass : direct_pass)(&drawing, first, chunks, log));
  }

done:
  return status;
}

void sure_maps_free(SureMaps *maps)
{
  DeviceBuffer *buffers[] = {&maps->info_buffer, &maps->views, &maps->marks, &maps->tiles, &maps->blocks, &maps->rows};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) buffer_free(buffers[i]);
  *maps = (SureMaps){0};
}
