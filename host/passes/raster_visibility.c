#include "passes/raster_visibility.h"

#include <stdlib.h>

#include "passes/raster_view.h"
#include "passes/scene_args.h"
#include "shared/raster.h"
#include "shared/stream.h"

_Static_assert(RASTER_BIN_PX == TILE_SIZE * BIN_TILES, "waves and raster have the same bins");

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

static uint32_t larger(uint32_t a, uint32_t b) { return a > b ? a : b; }

static uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

static Status kernels_make(RasterVisibility *raster, Device *device, const DeviceScene *scene, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  TRY(raster_program(&program, device, scene, raster_visibility_path(raster->way), TESTS_MASKS, log));
  TRY(raster_items_make(&raster->items, program, raster->way, RASTER_SIGHT_CAMERA, log));
  if (raster->way == RASTER_WAY_BINS) {
    TRY(program_kernel(&raster->setup, program, "visibility_setup", log));
    TRY(program_kernel(&raster->bins, program, "visibility_bins", log));
  } else {
    TRY(program_kernel(&raster->small, program, "visibility_small", log));
    TRY(program_kernel(&raster->split, program, "visibility_split", log));
    TRY(program_kernel(&raster->draw, program, "visibility_tiles", log));
    TRY(program_kernel(&raster->resolve, program, "visibility_resolve", log));
  }

done:
  return status;
}

Status raster_visibility_make(RasterVisibility *out, Device *device, const DeviceScene *scene,
                              const RasterOptions *options, Log *log)
{
  Status status = STATUS_OK;
  RasterVisibility raster = {.way = raster_way(options, device), .options = *options};
  TRY(buffer_create(&raster.hidden, device, 2 * sizeof(uint32_t), NULL, "what is left out", log));
  TRY(buffer_create(&raster.costs, device, RASTER_COSTS * sizeof(uint32_t), NULL, "costs", log));
  TRY(buffer_zero(device, &raster.costs, log));
  TRY(kernels_make(&raster, device, scene, log));
  *out = raster;
  raster = (RasterVisibility){0};

done:
  raster_visibility_free(&raster);
  return status;
}

static Status views_write(RasterVisibility *raster, Device *device, const CameraRays *camera, Log *log)
{
  Status status = STATUS_OK;
  size_t bytes = camera->view_count * sizeof(RasterView);
  RasterView *views = malloc(bytes);
  if (!views) return log_no_memory(log, "camera");
  for (uint32_t i = 0; i < camera->view_count; i++) views[i] = raster_view_of_camera(&camera->views[i]);
  raster->view_count = camera->view_count;
  TRY(buffer_put(&raster->views, device, bytes, views, "camera", log));

done:
  free(views);
  return status;
}

Status raster_visibility_hide(RasterVisibility *raster, Device *device, const uint32_t (*ranges)[2], uint32_t count,
                              Log *log)
{
  raster->hidden_count = count;
  raster->ready = false;
  return buffer_put(&raster->hidden, device, count * sizeof *ranges, ranges, "what is left out", log);
}

// Room for the bins of a pass.
static Status bins_aim(RasterVisibility *raster, Device *device, const CameraInfo *info, uint32_t capacity, Log *log)
{
  uint32_t rows = divide_up(info->height, RASTER_BIN_PX);
  // A wave may touch one row of bins more than its tiles fill.
  uint32_t wave_rows = divide_up(capacity / TILE_PIXELS, info->tiles_per_row * BIN_TILES) + 1;
  uint32_t pass_bins = raster->options.pass_bins ? raster->options.pass_bins : RASTER_PASS_BINS;
  raster->columns = divide_up(info->width, RASTER_BIN_PX);
  bool whole = raster->view_count > 1 || raster->columns * rows <= pass_bins;
  raster->pass_rows = whole ? rows : smaller(rows, wave_rows);
  return raster_bins_reserve(&raster->binned, device, raster->items.pass, (size_t)raster->columns * raster->pass_rows,
                             VISIBLE_WORDS, log);
}

static Status direct_aim(RasterVisibility *raster, Device *device, const CameraInfo *info, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  uint32_t tiles = raster_pass_tiles(&raster->options, device);
  TRY(raster_boxes_reserve(&raster->boxes, device, raster->items.pass, tiles, log));
  if (raster->keys.bytes < capacity * sizeof(uint64_t)) {
    TRY(buffer_reserve(&raster->keys, device, capacity * sizeof(uint64_t), "visibility", log));
    TRY(buffer_fill_words(device, &raster->keys, 0xffffffffu, log));
  }

done:
  return status;
}

Status raster_visibility_aim(RasterVisibility *raster, Device *device, const RasterScene *triangles,
                             const CameraRays *camera, uint32_t samples, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  TRY(views_write(raster, device, camera, log));
  TRY(raster_items_find(&raster->items, device, triangles, &raster->views, raster->view_count,
                        raster_pass_chunks(&raster->options, device, raster->way), log));
  raster->samples = samples;
  raster->ready = false;
  TRY((raster->way == RASTER_WAY_BINS ? bins_aim : direct_aim)(raster, device, &camera->info, capacity, log));

done:
  return status;
}

void raster_visibility_free(RasterVisibility *raster)
{
  Kernel *kernels[] = {&raster->setup, &raster->bins, &raster->small, &raster->split, &raster->draw, &raster->resolve};
  for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++) kernel_free(kernels[i]);
  raster_items_free(&raster->items);
  raster_bins_free(&raster->binned);
  raster_boxes_free(&raster->boxes);
  buffer_free(&raster->views);
  buffer_free(&raster->hidden);
  buffer_free(&raster->keys);
  buffer_free(&raster->costs);
  *raster = (RasterVisibility){0};
}

// Number of a tile's bin.
static uint32_t bin_of(const RasterVisibility *raster, const CameraInfo *info, uint32_t tile)
{
  uint32_t row_tiles = info->tiles_per_row * BIN_TILES, row = tile / row_tiles;
  uint32_t height = smaller(BIN_TILES, divide_up(info->height, TILE_SIZE) - row * BIN_TILES);
  return row * raster->columns + tile % row_tiles / (BIN_TILES * height);
}

// Bin rows [wave_row, wave_row + wave_rows) of the wave, by passes over the items.
static Status bins_draw(RasterVisibility *raster, Device *device, const DeviceScene *scene,
                        const RasterScene *triangles, const CameraRays *camera, const Wave *wave, uint32_t wave_row,
                        uint32_t wave_rows, const HitStream *hits, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  const CameraInfo *info = &camera->info;
  uint32_t all_rows = divide_up(info->height, RASTER_BIN_PX), view_bins = raster->columns * all_rows;
  uint32_t first_bin = 0, end_bin = view_bins * raster->view_count, last_tile = wave->first_tile + wave->tile_count - 1;
  if (raster->view_count == 1) {
    first_bin = larger(bin_of(raster, info, wave->first_tile), wave_row * raster->columns);
    end_bin = smaller(bin_of(raster, info, last_tile) + 1, (wave_row + wave_rows) * raster->columns);
  } else if (info->width % RASTER_BIN_PX == 0 && info->height % RASTER_BIN_PX == 0) {  // no bin has parts of two views
    first_bin = wave->first_tile / (BIN_TILES * BIN_TILES);
    end_bin = last_tile / (BIN_TILES * BIN_TILES) + 1;
  }
  uint32_t bin_count = end_bin - first_bin;
  bool whole = raster->pass_rows == all_rows;
  uint32_t first_row = whole ? 0 : wave_row, rows = whole ? all_rows : wave_rows, begin = 1;
  for (uint32_t first = 0; first < raster->items.count || begin; first += raster->items.pass, begin = 0) {
    uint32_t items = smaller(raster->items.pass, raster->items.count - first);
    if (!raster->ready)
      TRY(device_launch(
          device, &raster->setup, divide_up(items, RASTER_SPREAD) * RASTER_SPREAD, (uint64_t)items * RASTER_CHUNK,
          "set up and bin triangles",
          ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ITEM_ARGS(&raster->items, first, items),
               ARG_BUFFER(raster->views), ARG_BUFFER(raster->hidden), ARG(raster->hidden_count),
               ARG_BUFFER(camera->offsets), ARG(raster->samples), ARG(raster->columns), ARG(first_row), ARG(rows),
               BIN_ARGS(&raster->binned)),
          log));
    raster->ready = whole && items == raster->items.count;
    TRY(device_launch(
        device, &raster->bins, (size_t)bin_count * wave->sample_count, wave_rays(wave), "raster camera visibility",
        ARGS(ARG_BUFFER(camera->cameras), ARG(raster->view_count), ARG_BUFFER(camera->offsets), ARG(wave->first_tile),
             ARG(wave->tile_count), ARG(wave->first_sample), ARG(wave->sample_count), ARG(raster->columns),
             ARG(view_bins), ARG(first_row), ARG(rows), ARG(first_bin), ARG(bin_count), ARG_BUFFER(triangles->blocks),
             ARG_BUFFER(raster->items.starts), ARG(first), ARG(items), BIN_ARGS(&raster->binned), ARG(begin),
             ARG(info->near_m), ARG(capacity), ARG_BUFFER(hits->hits), ARG_BUFFER(hits->ids), ARG_BUFFER(raster->costs),
             ATTRIBUTE_ARGS(scene)),
        log));
  }

done:
  return status;
}

// The wave in two sizes of triangles, by passes over the items, and then the hits.
static Status direct_draw(RasterVisibility *raster, Device *device, const DeviceScene *scene,
                          const RasterScene *triangles, const CameraRays *camera, const Wave *wave,
                          const HitStream *hits, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  const CameraInfo *info = &camera->info;
  uint32_t slots = wave_rays(wave);
  for (uint32_t first = 0; first < raster->items.count; first += raster->items.pass) {
    uint32_t items = smaller(raster->items.pass, raster->items.count - first);
    uint64_t count = (uint64_t)items * RASTER_CHUNK;
    raster->boxes.set = 1 - raster->boxes.set;
    TRY(device_launch(
        device, &raster->small, count, count, "set up triangles, raster small ones",
        ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ITEM_ARGS(&raster->items, first, items),
             ARG_BUFFER(raster->views), ARG_BUFFER(camera->cameras), ARG(raster->view_count),
             ARG_BUFFER(raster->hidden), ARG(raster->hidden_count), ARG_BUFFER(camera->offsets), ARG(wave->first_tile),
             ARG(wave->tile_count), ARG(wave->first_sample), ARG(wave->sample_count), ARG(info->near_m),
             ARG_BUFFER(raster->keys), BOX_ARGS(&raster->boxes), ATTRIBUTE_ARGS(scene)),
        log));
    const Kernel *large[] = {&raster->split, &raster->draw};
    const char *const sentences[] = {"find the tiles of large triangles", "raster large triangles"};
    for (int i = 0; i < 2; i++)
      TRY(device_launch(device, large[i], raster_box_items(device), 0, sentences[i],
                        ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(raster->views), ARG_BUFFER(camera->cameras),
                             ARG(raster->view_count), ARG_BUFFER(camera->offsets), ARG(wave->first_tile),
                             ARG(wave->tile_count), ARG(wave->first_sample), ARG(wave->sample_count), ARG(info->near_m),
                             ARG_BUFFER(raster->keys), BOX_ARGS(&raster->boxes), ATTRIBUTE_ARGS(scene)),
                        log));
  }
  if (!hits) return STATUS_OK;
  TRY(device_launch(device, &raster->resolve, slots, slots, "raster camera visibility",
                    ARGS(ARG_BUFFER(camera->cameras), ARG(camera->view_count), ARG_BUFFER(camera->offsets),
                         ARG(wave->first_tile), ARG(wave->tile_count), ARG(wave->first_sample), ARG(slots),
                         ARG_BUFFER(raster->keys), ARG_BUFFER(scene->corners), ARG_BUFFER(scene->positions),
                         ARG(capacity), ARG_BUFFER(hits->hits), ARG_BUFFER(hits->ids)),
                    log));

done:
  return status;
}

Status raster_visibility(RasterVisibility *raster, Device *device, const DeviceScene *scene,
                         const RasterScene *triangles, const CameraRays *camera, const Wave *wave,
                         const HitStream *hits, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  if (raster->way == RASTER_WAY_DIRECT)
    return direct_draw(raster, device, scene, triangles, camera, wave, hits, capacity, log);
  if (raster->view_count > 1)
    return bins_draw(raster, device, scene, triangles, camera, wave, 0, raster->pass_rows, hits, capacity, log);
  uint32_t row_tiles = camera->info.tiles_per_row * BIN_TILES;
  uint32_t end = divide_up(wave->first_tile + wave->tile_count, row_tiles);
  for (uint32_t row = wave->first_tile / row_tiles; row < end; row += raster->pass_rows)
    TRY(bins_draw(raster, device, scene, triangles, camera, wave, row, smaller(raster->pass_rows, end - row), hits,
                  capacity, log));

done:
  return status;
}

Status raster_visibility_cost(RasterCost *out, const RasterVisibility *raster, Device *device, Log *log)
{
  Status status = STATUS_OK;
  uint32_t words[RASTER_COSTS] = {0};
  TRY(buffer_read(device, &raster->costs, words, sizeof words, log));
  *out = (RasterCost){words[RASTER_COST_TESTS] | (uint64_t)words[RASTER_COST_TESTS + 1] << 32,
                      words[RASTER_COST_COVERED] | (uint64_t)words[RASTER_COST_COVERED + 1] << 32};

done:
  return status;
}
