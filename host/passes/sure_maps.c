#include "passes/sure_maps.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "shared/raster.h"

static uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }
static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

uint32_t sure_maps_tiles(const ShadowInfo *info)
{
  return info->view_count * TILE_COLUMNS(info->size_px) * TILE_COLUMNS(info->size_px);
}

const uint64_t sure_tile_bytes =
    sizeof(ShadowTile) + SHADOW_TILE_BLOCKS * (sizeof(ShadowBlock) + (SHADOW_NUMBERS - 1) * sizeof(ShadowRow));

static const char *shadowless_option(const RasterScene *triangles)
{
  return triangles->has_shadowless ? "-D HAS_SHADOWLESS " : "";
}

static Status bins_make(SureRaster *raster, Device *device, const RasterScene *triangles, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  TRY(program_build(&program, device, "raster/shadow_texels.cl", shadowless_option(triangles), log));
  TRY(program_kernel(&raster->setup, program, "shadow_setup", log));
  TRY(program_kernel(&raster->bins, program, "shadow_bins", log));

done:
  return status;
}

static Status direct_make(SureRaster *raster, Device *device, const RasterScene *scene, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  char options[64];
  size_t triangles = (size_t)raster->pass_chunks * RASTER_CHUNK;
  snprintf(options, sizeof options, "%s-D GROUP_SIZE=%u", shadowless_option(scene), device_traits(device)->group_size);
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
  const uint32_t all = triangles->chunk_count * SHADOW_VIEWS_MOST;
  raster.pass_chunks = smaller(raster_pass_chunks(options, device, pass_way(&raster, device)), all);
  if (raster.pass_chunks < SHADOW_VIEWS_MOST) raster.pass_chunks = SHADOW_VIEWS_MOST;
  TRY((raster.way == RASTER_WAY_BINS ? bins_make : direct_make)(&raster, device, triangles, log));
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

// What both ways are given of a light.
typedef struct SureDrawing {
  SureMaps *maps;
  SureRaster *raster;
  Device *device;
  const RasterScene *triangles;
  const DeviceBuffer *marks, *views;
  const ShadowInfo *info;
  uint32_t what, tile_columns, columns;
  uint64_t texels;  // to be known
} SureDrawing;

// In the order in which the kernels declare them.
#define TILE_ARGS(drawing) \
  ARG_BUFFER((drawing)->maps->tiles), ARG((drawing)->info->first_texel), ARG((drawing)->tile_columns)
#define BLOCK_ARGS(drawing) \
  ARG_BUFFER((drawing)->maps->blocks), ARG_BUFFER((drawing)->maps->rows), ARG((drawing)->maps->block_count)

static Status bins_pass(const SureDrawing *drawing, uint32_t first, uint32_t chunks, Log *log)
{
  Status status = STATUS_OK;
  const SureRaster *raster = drawing->raster;
  const RasterScene *triangles = drawing->triangles;
  const uint32_t size = drawing->info->size_px, views = drawing->info->view_count;
  uint64_t items = (uint64_t)chunks * views, bins = (uint64_t)drawing->columns * drawing->columns;
  TRY(device_launch(drawing->device, &raster->setup, items, items * RASTER_CHUNK,
                    "set up and bin triangles of sure maps",
                    ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ARG(first), ARG(chunks),
                         ARG_BUFFER(*drawing->views), ARG(views), ARG(drawing->columns), ARG_BUFFER(*drawing->marks),
                         ARG(drawing->what), TILE_ARGS(drawing), BIN_ARGS(&raster->binned)),
                    log));
  TRY(device_launch(drawing->device, &raster->bins, bins * views, drawing->texels, "raster sure maps",
                    ARGS(ARG(size), ARG(views), ARG(drawing->columns), ARG(chunks), BIN_ARGS(&raster->binned),
                         TILE_ARGS(drawing), BLOCK_ARGS(drawing)),
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
  const uint32_t size = drawing->info->size_px, views = drawing->info->view_count, columns = drawing->columns;
  const uint32_t group = device_traits(device)->group_size, lists = views * (columns * columns + 1);
  uint32_t first_triangle = first * RASTER_CHUNK, count = chunks * RASTER_CHUNK;
  uint64_t tiles = sure_maps_tiles(drawing->info), squares = tiles * (SHADOW_TILE_PX * SHADOW_TILE_PX / group);
  TRY(buffer_zero(device, &raster->counts, log));
  TRY(device_launch(
      device, &raster->take, (uint64_t)count * views, (uint64_t)count * views, "set up triangles of sure maps",
      ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ARG(first_triangle), ARG(count),
           ARG_BUFFER(*drawing->views), ARG(views), ARG(columns), ARG_BUFFER(*drawing->marks), ARG(drawing->what),
           TILE_ARGS(drawing), ARG_BUFFER(raster->records), ARG_BUFFER(raster->counts)),
      log));
  TRY(device_launch(device, &raster->place, lists, lists, "place the bins of sure maps",
                    ARGS(ARG(lists), ARG_BUFFER(raster->counts), ARG_BUFFER(raster->starts), ARG_BUFFER(raster->ends)),
                    log));
  TRY(device_launch(device, &raster->fill, raster_box_items(device), 0, "fill the bins of sure maps",
                    ARGS(ARG(columns), ARG_BUFFER(raster->records), ARG_BUFFER(raster->counts),
                         ARG_BUFFER(raster->ends), ARG_BUFFER(raster->lists)),
                    log));
  TRY(device_launch(device, &raster->squares, squares * group, drawing->texels, "raster sure maps",
                    ARGS(ARG(size), ARG(views), ARG(columns), ARG_BUFFER(raster->records), ARG_BUFFER(raster->starts),
                         ARG_BUFFER(raster->ends), ARG_BUFFER(raster->lists), TILE_ARGS(drawing), BLOCK_ARGS(drawing)),
                    log));
  TRY(device_launch(device, &raster->sum_up, tiles, tiles, "sum up tiles of sure maps",
                    ARGS(ARG(size), ARG(views), TILE_ARGS(drawing), ARG_BUFFER(drawing->maps->blocks)), log));

done:
  return status;
}

// Makes room for a map's bins.
static Status bins_divide(SureRaster *raster, Device *device, uint32_t columns, uint32_t views, Log *log)
{
  Status status = STATUS_OK;
  size_t bins = (size_t)columns * columns, bytes = views * (bins + 1) * sizeof(uint32_t);
  if (raster->way == RASTER_WAY_BINS)
    return raster_bins_reserve(&raster->binned, device, raster->pass_chunks, bins, SURE_WORDS, log);
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

// Infos and views, and where the tiles of each light are.
static Status tables_make(SureMaps *maps, const ShadowFit *fits, Log *log)
{
  uint32_t views = 0;
  maps->tile_count = 0;
  maps->lights = calloc(maps->light_count + 1, sizeof *maps->lights);
  maps->known_tiles = calloc(maps->light_count + 1, sizeof *maps->known_tiles);
  maps->stayed = calloc(maps->light_count + 1, sizeof *maps->stayed);
  maps->view_blocks = calloc(maps->light_count + 1, sizeof *maps->view_blocks);
  maps->view_table = malloc(((size_t)maps->light_count * SHADOW_VIEWS_MOST + 1) * sizeof *maps->view_table);
  if (!maps->lights || !maps->known_tiles || !maps->stayed || !maps->view_blocks || !maps->view_table)
    return log_no_memory(log, "sure maps");
  for (uint32_t i = 0; i < maps->light_count; i++) {
    ShadowInfo *info = &maps->lights[i];
    *info = fits[i].info;
    info->first_view = views;
    info->first_texel = maps->tile_count;
    memcpy(maps->view_table + views, fits[i].views, info->view_count * sizeof *fits[i].views);
    views += info->view_count;
    maps->tile_count += sure_maps_tiles(info);
  }
  return STATUS_OK;
}

Status sure_maps_aim(SureMaps *out, Device *device, const ShadowFit *fits, uint32_t light_count, bool marked, Log *log)
{
  Status status = STATUS_OK;
  out->light_count = light_count;
  TRY(tables_make(out, fits, log));
  const ShadowInfo *last = light_count ? &out->lights[light_count - 1] : NULL;
  size_t views = last ? last->first_view + last->view_count : 0;
  TRY(buffer_create(&out->infos, device, light_count * sizeof *out->lights, out->lights, "sure maps", log));
  TRY(buffer_create(&out->views, device, views * sizeof *out->view_table, out->view_table, "sure maps", log));
  if (!marked) return STATUS_OK;
  TRY(buffer_create(&out->marks, device, out->tile_count * sizeof(uint32_t), NULL, "sure maps", log));
  TRY(buffer_fill_words(device, &out->marks, SHADOW_TILE_UNKNOWN, log));

done:
  return status;
}

Status sure_maps_read_marks(SureMaps *maps, Device *device, Log *log)
{
  maps->seen = malloc((maps->tile_count + 1ull) * sizeof *maps->seen);
  if (!maps->seen) return log_no_memory(log, "sure maps");
  Status status = buffer_read(device, &maps->marks, maps->seen, maps->tile_count * sizeof *maps->seen, log);
  buffer_free(&maps->marks);
  return status;
}

// The marks of a light's maps, were these smaller by 2^level: a tile has the least of those that become it.
static void marks_shrink(uint32_t *out, const uint32_t *marks, const ShadowInfo *info, uint32_t level)
{
  uint32_t columns = TILE_COLUMNS(info->size_px), fewer = TILE_COLUMNS(info->size_px >> level);
  memset(out, 0xff, (size_t)info->view_count * fewer * fewer * sizeof *out);  // SHADOW_TILE_UNKNOWN
  for (uint32_t row = 0; row < info->view_count * columns; row++) {
    uint32_t *to = out + (row / columns * fewer + (row % columns >> level)) * fewer;
    for (uint32_t x = 0; x < columns; x++) to[x >> level] = smaller(to[x >> level], marks[row * columns + x]);
  }
}

uint32_t sure_maps_marked(const SureMaps *maps, uint32_t light, uint32_t level)
{
  const ShadowInfo *info = &maps->lights[light];
  const uint32_t *marks = maps->seen + info->first_texel;
  uint32_t columns = TILE_COLUMNS(info->size_px), count = 0;
  for (uint32_t y = 0; y < info->view_count * columns; y += 1u << level)
    for (uint32_t x = 0; x < columns; x += 1u << level) {
      bool marked = false;
      for (uint32_t i = 0; i < 1u << 2 * level && !marked; i++) {
        uint32_t at_x = x + (i & ((1u << level) - 1)), at_y = y + (i >> level);
        if (at_x < columns) marked = marks[at_y * columns + at_x] != SHADOW_TILE_UNKNOWN;
      }
      count += marked;
    }
  return count;
}

Status sure_maps_shrink(SureMaps *maps, Device *device, const ShadowFit *fits, const uint8_t *levels, Log *log)
{
  Status status = STATUS_OK;
  SureMaps smaller_maps = {0};
  TRY(sure_maps_aim(&smaller_maps, device, fits, maps->light_count, false, log));
  smaller_maps.seen = malloc((smaller_maps.tile_count + 1ull) * sizeof *maps->seen);
  if (!smaller_maps.seen) {
    status = log_no_memory(log, "sure maps");
    goto done;
  }
  for (uint32_t i = 0; i < maps->light_count; i++)
    if (smaller_maps.lights[i].view_count > 0)
      marks_shrink(smaller_maps.seen + smaller_maps.lights[i].first_texel, maps->seen + maps->lights[i].first_texel,
                   &maps->lights[i], levels[i]);
  SureMaps before = *maps;
  *maps = smaller_maps;
  smaller_maps = before;

done:
  sure_maps_free(&smaller_maps);
  return status;
}

// Views [first, first + count) of a light as though they were all of it.
static ShadowInfo views_of(const ShadowInfo *info, uint32_t first, uint32_t count)
{
  ShadowInfo part = *info;
  part.view_count = 1;
  part.first_texel += first * sure_maps_tiles(&part);
  part.first_view += first;
  part.view_count = count;
  return part;
}

// By passes over the scene's chunks, as depth maps are (passes/raster_depth.c).
static Status views_draw(SureDrawing *drawing, const ShadowInfo *info, Log *log)
{
  Status status = STATUS_OK;
  SureRaster *raster = drawing->raster;
  const uint32_t views = info->view_count, bin_px = raster->way == RASTER_WAY_BINS ? RASTER_BIN_PX : SURE_BIN_PX;
  const ShadowView *table = drawing->maps->view_table + info->first_view;
  DeviceBuffer view_table = {0};
  const uint32_t pass_chunks = raster->pass_chunks / views, all = drawing->triangles->chunk_count;
  drawing->info = info;
  drawing->views = &view_table;
  drawing->tile_columns = TILE_COLUMNS(info->size_px);
  drawing->columns = divide_up(info->size_px, bin_px);
  TRY(buffer_create(&view_table, drawing->device, views * sizeof *table, table, "sure maps", log));
  TRY(bins_divide(raster, drawing->device, drawing->columns, views, log));
  for (uint32_t first = 0; first < all; first += pass_chunks) {
    uint32_t chunks = smaller(pass_chunks, all - first);
    TRY((raster->way == RASTER_WAY_BINS ? bins_pass : direct_pass)(drawing, first, chunks, log));
  }

done:
  buffer_free(&view_table);
  return status;
}

Status sure_maps_draw(SureMaps *maps, uint32_t light, SureRaster *raster, Device *device, const RasterScene *triangles,
                      const DeviceBuffer *marks, uint32_t what, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t count = maps->lights[light].view_count;
  SureDrawing drawing = {
      .maps = maps, .raster = raster, .device = device, .triangles = triangles, .marks = marks, .what = what};
  for (uint32_t first = 0, end; first < count; first = end) {
    const bool stayed = maps->stayed[light][first];
    uint64_t blocks = 0;
    for (end = first; end < count && maps->stayed[light][end] == stayed; end++)
      blocks += maps->view_blocks[light][end].count;
    if (stayed || blocks == 0) continue;
    const ShadowInfo views = views_of(&maps->lights[light], first, end - first);
    drawing.texels = blocks * (SHADOW_TILE_PX * SHADOW_TILE_PX / SHADOW_TILE_BLOCKS);
    TRY(views_draw(&drawing, &views, log));
  }

done:
  return status;
}

uint32_t sure_maps_kept(const SureMaps *maps, uint32_t light)
{
  uint32_t kept = 0;
  for (uint32_t view = 0; view < maps->lights[light].view_count; view++) kept += maps->stayed[light][view];
  return kept;
}

void sure_maps_free(SureMaps *maps)
{
  DeviceBuffer *buffers[] = {&maps->infos, &maps->views, &maps->marks, &maps->tiles, &maps->blocks, &maps->rows};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) buffer_free(buffers[i]);
  free(maps->lights);
  free(maps->known_tiles);
  free(maps->stayed);
  free(maps->view_blocks);
  free(maps->view_table);
  free(maps->seen);
  *maps = (SureMaps){0};
}
