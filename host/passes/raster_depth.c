#include "passes/raster_depth.h"

#include <stdlib.h>

#include "passes/scene_args.h"
#include "shared/depth_map.h"
#include "shared/raster.h"

static const char bins_path[] = "raster/depth.cl";

enum { PROGRAM_USES = TESTS_MASKS | SKIPS_SHADOWLESS };

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

static uint32_t larger(uint32_t a, uint32_t b) { return a > b ? a : b; }

static uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

static Status kernels_make(RasterDepth *raster, Device *device, const DeviceScene *scene, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  const bool bins = raster->way == RASTER_WAY_BINS;
  TRY(raster_program(&program, device, scene, bins ? bins_path : "raster/depth_direct.cl", PROGRAM_USES, log));
  if (bins) {
    TRY(raster_items_make(&raster->items, program, raster->way, RASTER_SIGHT_MAP, log));
    TRY(program_kernel(&raster->setup, program, "depth_setup", log));
    TRY(program_kernel(&raster->bins, program, "depth_bins", log));
  } else {
    TRY(program_kernel(&raster->clear, program, "depth_clear", log));
    TRY(program_kernel(&raster->small, program, "depth_small", log));
    TRY(program_kernel(&raster->split, program, "depth_split", log));
    TRY(program_kernel(&raster->draw, program, "depth_tiles", log));
  }

done:
  return status;
}

Status raster_depth_make(RasterDepth *out, Device *device, const DeviceScene *scene, const RasterOptions *options,
                         Log *log)
{
  Status status = STATUS_OK;
  RasterDepth raster = {.way = raster_way(options, device), .options = *options};
  TRY(kernels_make(&raster, device, scene, log));
  *out = raster;
  raster = (RasterDepth){0};

done:
  raster_depth_free(&raster);
  return status;
}

void raster_depth_free(RasterDepth *raster)
{
  Kernel *kernels[] = {&raster->setup, &raster->bins, &raster->clear, &raster->small, &raster->split, &raster->draw};
  for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++) kernel_free(kernels[i]);
  raster_items_free(&raster->items);
  raster_bins_free(&raster->binned);
  raster_boxes_free(&raster->boxes);
  buffer_free(&raster->views);
  buffer_free(&raster->maps);
  *raster = (RasterDepth){0};
}

static uint32_t view_texels(const RasterView *view) { return view->width * view->width; }

// How many views from the first on are of one size and lie behind each other: the maps of a light. Bins take these at
// once.
static uint32_t run_length(const RasterView *views, uint32_t view_count)
{
  uint32_t count = 1;
  while (count < view_count && views[count].width == views->width &&
         views[count].first_texel == views->first_texel + count * view_texels(views))
    count++;
  return count;
}

static Status bins_draw(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                        const RasterView *views, uint32_t view_count, const DeviceBuffer *maps, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t size_px = views->width, columns = divide_up(size_px, RASTER_BIN_PX);
  uint32_t begin = 1;
  TRY(buffer_put(&raster->views, device, view_count * sizeof *views, views, "depth views", log));
  TRY(raster_items_find(&raster->items, device, triangles, &raster->views, view_count,
                        raster_pass_chunks(&raster->options, device, raster->way), log));
  TRY(raster_bins_reserve(&raster->binned, device, raster->items.pass, (size_t)columns * columns, DEPTH_WORDS, log));
  for (uint32_t first = 0; first < raster->items.count || begin; first += raster->items.pass, begin = 0) {
    uint32_t items = smaller(raster->items.pass, raster->items.count - first);
    TRY(device_launch(
        device, &raster->setup, divide_up(items, RASTER_SPREAD) * RASTER_SPREAD, (uint64_t)items * RASTER_CHUNK,
        "set up and bin triangles of depth maps",
        ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ITEM_ARGS(&raster->items, first, items),
             ARG_BUFFER(raster->views), ARG(columns), BIN_ARGS(&raster->binned)),
        log));
    TRY(device_launch(device, &raster->bins, (size_t)columns * columns * view_count,
                      (uint64_t)size_px * size_px * view_count, "raster depth maps",
                      ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(raster->views), ARG(view_count), ARG(columns),
                           ARG_BUFFER(raster->items.starts), ARG(first), ARG(items), BIN_ARGS(&raster->binned),
                           ARG(begin), ARG_BUFFER(*maps), ATTRIBUTE_ARGS(scene)),
                      log));
  }

done:
  return status;
}

// How many work-groups have the views of a chunk: more where triangles alone would not fill the device several times.
static uint32_t chunk_shares(const Device *device, uint32_t chunks, uint32_t view_count)
{
  const size_t enough = 4 * raster_box_items(device);
  return larger(1, smaller(view_count, (uint32_t)(enough / ((size_t)chunks * RASTER_CHUNK + 1))));
}

// Views of any sizes, at most RASTER_VIEWS_MOST.
static Status direct_draw(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                          const RasterView *views, uint32_t view_count, const DeviceBuffer *maps, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t tiles = raster_pass_tiles(&raster->options, device);
  const uint32_t most = raster_pass_chunks(&raster->options, device, raster->way) / view_count;
  const uint32_t pass = larger(1, smaller(most, triangles->chunk_count));
  uint64_t texels = 0;
  for (uint32_t i = 0; i < view_count; i++) texels += view_texels(&views[i]);
  TRY(buffer_put(&raster->views, device, view_count * sizeof *views, views, "depth views", log));
  TRY(raster_boxes_reserve(&raster->boxes, device, (size_t)pass * view_count, tiles, log));
  TRY(device_launch(device, &raster->clear, raster_box_items(device), texels, "clear depth maps",
                    ARGS(ARG_BUFFER(*maps), ARG_BUFFER(raster->views), ARG(view_count)), log));
  for (uint32_t first = 0; first < triangles->chunk_count; first += pass) {
    const uint32_t chunks = smaller(pass, triangles->chunk_count - first);
    const uint32_t shares = chunk_shares(device, chunks, view_count);
    raster->boxes.set = 1 - raster->boxes.set;
    TRY(device_launch(device, &raster->small, (size_t)chunks * shares * RASTER_CHUNK,
                      (uint64_t)chunks * RASTER_CHUNK * view_count, "set up triangles of depth maps, raster small ones",
                      ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ARG(first), ARG(chunks),
                           ARG_BUFFER(raster->views), ARG(view_count), ARG(shares), ARG_BUFFER(*maps),
                           BOX_ARGS(&raster->boxes), ATTRIBUTE_ARGS(scene)),
                      log));
    const Kernel *large[] = {&raster->split, &raster->draw};
    const char *const sentences[] = {"find the tiles of large triangles in depth maps",
                                     "raster depth maps, large triangles"};
    for (int i = 0; i < 2; i++)
      TRY(device_launch(device, large[i], raster_box_items(device), 0, sentences[i],
                        ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(raster->views), ARG_BUFFER(*maps),
                             BOX_ARGS(&raster->boxes), ATTRIBUTE_ARGS(scene)),
                        log));
  }

done:
  return status;
}

Status raster_depth_into(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                         const RasterView *views, uint32_t view_count, const DeviceBuffer *maps, Log *log)
{
  Status status = STATUS_OK;
  const bool bins = raster->way == RASTER_WAY_BINS;
  for (uint32_t i = 0; i < view_count; i++)
    if (views[i].width == 0 || views[i].width % 4 || views[i].width > 8192 || views[i].height != views[i].width)
      return log_fail(log, STATUS_USAGE, "depth map: %u x %u texels: use a square of a multiple of 4 up to 8192",
                      views[i].width, views[i].height);
  for (uint32_t first = 0, count; first < view_count; first += count) {
    const RasterView *from = views + first;
    count = smaller(view_count - first, RASTER_VIEWS_MOST);
    if (bins) count = run_length(from, view_count - first);
    TRY((bins ? bins_draw : direct_draw)(raster, device, scene, triangles, from, count, maps, log));
  }

done:
  return status;
}

Status raster_depth(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                    const RasterView *views, uint32_t view_count, Log *log)
{
  Status status = STATUS_OK;
  size_t texels = 0;
  RasterView *placed = malloc(view_count * sizeof *placed + 1);
  if (!placed) return log_no_memory(log, "depth views");
  for (uint32_t i = 0; i < view_count; i++) {
    placed[i] = views[i];
    placed[i].first_texel = (uint32_t)texels;
    texels += view_texels(&views[i]);
  }
  TRY(buffer_reserve(&raster->maps, device, texels * sizeof(float), "depth maps", log));
  TRY(raster_depth_into(raster, device, scene, triangles, placed, view_count, &raster->maps, log));

done:
  free(placed);
  return status;
}

Status raster_depth_planes(Device *device, const DeviceScene *scene, const DeviceBuffer *maps, uint32_t first_texel,
                           uint32_t size_px, uint32_t view_count, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  Kernel kernel = {0};
  const uint32_t texels = view_count * size_px * size_px, rows = view_count * size_px / 4;
  TRY(raster_program(&program, device, scene, bins_path, PROGRAM_USES, log));
  TRY(program_kernel(&kernel, program, "depth_planes", log));
  TRY(device_launch(device, &kernel, divide_up(rows, DEPTH_PLANES_ROWS), texels, "bound blocks of depth maps",
                    ARGS(ARG_BUFFER(*maps), ARG(first_texel), ARG(size_px), ARG(view_count)), log));

done:
  kernel_free(&kernel);
  return status;
}
