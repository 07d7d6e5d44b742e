#include "passes/raster_depth.h"

#include "passes/scene_args.h"
#include "shared/depth_map.h"
#include "shared/raster.h"

static const char bins_path[] = "raster/depth.cl";

enum { PROGRAM_USES = TESTS_MASKS | SKIPS_SHADOWLESS };

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

static uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

static Status kernels_make(RasterDepth *raster, Device *device, const DeviceScene *scene, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  const bool bins = raster->way == RASTER_WAY_BINS;
  TRY(raster_program(&program, device, scene, bins ? bins_path : "raster/depth_direct.cl", PROGRAM_USES, log));
  TRY(raster_items_make(&raster->items, program, RASTER_SIGHT_MAP, log));
  if (bins) {
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

Status raster_depth_make(RasterDepth *out, Device *device, const DeviceScene *scene, uint32_t size_px,
                         uint32_t view_capacity, const RasterOptions *options, Log *log)
{
  Status status = STATUS_OK;
  RasterDepth raster = {.size_px = size_px, .view_capacity = view_capacity, .options = *options};
  if (size_px == 0 || size_px % 4 || size_px > 8192 || view_capacity == 0)
    return log_fail(log, STATUS_USAGE, "depth map: %u texels a side: use a multiple of 4 up to 8192", size_px);
  raster.way = raster_way(options, device);
  TRY(buffer_create(&raster.views, device, view_capacity * sizeof(RasterView), NULL, "depth views", log));
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

// Where maps go.
typedef struct DepthTarget {
  const DeviceBuffer *maps;
  uint32_t first_texel, view_count;
} DepthTarget;

static Status bins_draw(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                        const DepthTarget *to, Log *log)
{
  Status status = STATUS_OK;
  uint32_t columns = divide_up(raster->size_px, RASTER_BIN_PX), view_count = to->view_count;
  uint32_t begin = 1;
  TRY(raster_bins_reserve(&raster->binned, device, raster->items.pass, (size_t)columns * columns, DEPTH_WORDS, log));
  for (uint32_t first = 0; first < raster->items.count || begin; first += raster->items.pass, begin = 0) {
    uint32_t items = smaller(raster->items.pass, raster->items.count - first);
    TRY(device_launch(
        device, &raster->setup, items, (uint64_t)items * RASTER_CHUNK, "set up and bin triangles of depth maps",
        ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ITEM_ARGS(&raster->items, first, items),
             ARG_BUFFER(raster->views), ARG(columns), BIN_ARGS(&raster->binned)),
        log));
    TRY(device_launch(device, &raster->bins, (size_t)columns * columns * view_count,
                      (uint64_t)raster->size_px * raster->size_px * view_count, "raster depth maps",
                      ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(raster->views), ARG(view_count), ARG(columns),
                           ARG_BUFFER(raster->items.starts), ARG(first), ARG(items), BIN_ARGS(&raster->binned),
                           ARG(begin), ARG_BUFFER(*to->maps), ARG(to->first_texel), ATTRIBUTE_ARGS(scene)),
                      log));
  }

done:
  return status;
}

static Status direct_draw(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                          const DepthTarget *to, Log *log)
{
  Status status = STATUS_OK;
  uint32_t tiles = raster->options.pass_tiles ? raster->options.pass_tiles : RASTER_PASS_TILES;
  const uint32_t texels = raster->size_px * raster->size_px * to->view_count;
  TRY(raster_boxes_reserve(&raster->boxes, device, raster->items.pass, tiles, log));
  TRY(device_launch(device, &raster->clear, smaller(raster_box_items(device), texels / 4), texels, "clear depth maps",
                    ARGS(ARG_BUFFER(*to->maps), ARG(to->first_texel), ARG(texels)), log));
  for (uint32_t first = 0; first < raster->items.count; first += raster->items.pass) {
    uint32_t items = smaller(raster->items.pass, raster->items.count - first);
    uint64_t count = (uint64_t)items * RASTER_CHUNK;
    raster->boxes.set = 1 - raster->boxes.set;
    TRY(device_launch(device, &raster->small, count, count, "set up triangles of depth maps, raster small ones",
                      ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds),
                           ITEM_ARGS(&raster->items, first, items), ARG_BUFFER(raster->views), ARG_BUFFER(*to->maps),
                           ARG(to->first_texel), BOX_ARGS(&raster->boxes), ATTRIBUTE_ARGS(scene)),
                      log));
    const Kernel *large[] = {&raster->split, &raster->draw};
    const char *const sentences[] = {"find the tiles of large triangles in depth maps",
                                     "raster depth maps, large triangles"};
    for (int i = 0; i < 2; i++)
      TRY(device_launch(device, large[i], raster_box_items(device), 0, sentences[i],
                        ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(raster->views), ARG_BUFFER(*to->maps),
                             ARG(to->first_texel), BOX_ARGS(&raster->boxes), ATTRIBUTE_ARGS(scene)),
                        log));
  }

done:
  return status;
}

Status raster_depth_into(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                         const RasterView *views, uint32_t view_count, const DeviceBuffer *maps, uint32_t first_texel,
                         Log *log)
{
  Status status = STATUS_OK;
  const DepthTarget to = {maps, first_texel, view_count};
  TRY(buffer_write(device, &raster->views, views, view_count * sizeof *views, log));
  TRY(raster_items_find(&raster->items, device, triangles, &raster->views, view_count,
                        raster_pass_chunks(&raster->options, device, raster->way), log));
  TRY((raster->way == RASTER_WAY_BINS ? bins_draw : direct_draw)(raster, device, scene, triangles, &to, log));

done:
  return status;
}

Status raster_depth(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                    const RasterView *views, uint32_t view_count, Log *log)
{
  Status status = STATUS_OK;
  size_t bytes = (size_t)raster->size_px * raster->size_px * raster->view_capacity * sizeof(float);
  if (!raster->maps.memory) TRY(buffer_create(&raster->maps, device, bytes, NULL, "depth maps", log));
  TRY(raster_depth_into(raster, device, scene, triangles, views, view_count, &raster->maps, 0, log));

done:
  return status;
}

Status raster_depth_planes(Device *device, const DeviceScene *scene, const DeviceBuffer *maps, uint32_t first_texel,
                           uint32_t texel_count, uint32_t first_plane, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  Kernel kernel = {0};
  const uint32_t blocks = texel_count / 16;
  TRY(raster_program(&program, device, scene, bins_path, PROGRAM_USES, log));
  TRY(program_kernel(&kernel, program, "depth_planes", log));
  TRY(device_launch(device, &kernel, divide_up(blocks, DEPTH_PLANES_ITEM), texel_count, "bound blocks of depth maps",
                    ARGS(ARG_BUFFER(*maps), ARG(first_texel), ARG(first_plane), ARG(blocks)), log));

done:
  kernel_free(&kernel);
  return status;
}
