#include "passes/raster_depth.h"

#include "passes/scene_args.h"
#include "shared/raster.h"

static const uint32_t far_depth = 0x3f800000;  // the bits of 1.0f

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

static uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

static Status bins_make(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterOptions *options,
                        Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  uint32_t columns = divide_up(raster->size_px, RASTER_BIN_PX);
  TRY(raster_program(&program, device, scene, "raster/depth.cl", log));
  TRY(program_kernel(&raster->setup, program, "depth_setup", log));
  TRY(program_kernel(&raster->bins, program, "depth_bins", log));
  TRY(raster_bins_make(&raster->binned, device, raster->pass_chunks, DEPTH_WORDS, log));
  TRY(raster_bins_divide(&raster->binned, device, raster->pass_chunks, (size_t)columns * columns, log));

done:
  return status;
}

static Status direct_make(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterOptions *options,
                          Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  TRY(raster_program(&program, device, scene, "raster/depth_direct.cl", log));
  TRY(program_kernel(&raster->small, program, "depth_small", log));
  TRY(program_kernel(&raster->split, program, "depth_split", log));
  TRY(program_kernel(&raster->draw, program, "depth_tiles", log));
  TRY(raster_boxes_make(&raster->boxes, device, raster->pass_chunks,
                        options->pass_tiles ? options->pass_tiles : RASTER_PASS_TILES, log));

done:
  return status;
}

Status raster_depth_make(RasterDepth *out, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                         uint32_t size_px, uint32_t view_capacity, const RasterOptions *options, Log *log)
{
  Status status = STATUS_OK;
  RasterDepth raster = {.size_px = size_px, .view_capacity = view_capacity};
  if (size_px == 0 || size_px % 4 || size_px > 8192 || view_capacity == 0)
    return log_fail(log, STATUS_USAGE, "depth map: %u texels a side: use a multiple of 4 up to 8192", size_px);
  raster.way = raster_way(options, device);
  raster.pass_chunks = raster_pass_chunks(options, raster.way, triangles->chunk_count * view_capacity);
  if (raster.pass_chunks < view_capacity) raster.pass_chunks = view_capacity;
  TRY(buffer_create(&raster.views, device, view_capacity * sizeof(RasterView), NULL, "depth views", log));
  TRY((raster.way == RASTER_WAY_BINS ? bins_make : direct_make)(&raster, device, scene, options, log));
  *out = raster;
  raster = (RasterDepth){0};

done:
  raster_depth_free(&raster);
  return status;
}

void raster_depth_free(RasterDepth *raster)
{
  Kernel *kernels[] = {&raster->setup, &raster->bins, &raster->small, &raster->split, &raster->draw};
  for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++) kernel_free(kernels[i]);
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
  uint32_t pass_chunks = raster->pass_chunks / view_count, begin = 1;
  for (uint32_t first = 0; first < triangles->chunk_count || begin; first += pass_chunks, begin = 0) {
    uint32_t chunks = smaller(pass_chunks, triangles->chunk_count - first);
    uint64_t items = (uint64_t)chunks * view_count;
    TRY(device_launch(device, &raster->setup, items, items * RASTER_CHUNK, "set up and bin triangles of depth maps",
                      ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ARG(first), ARG(chunks),
                           ARG_BUFFER(raster->views), ARG(view_count), ARG(columns), BIN_ARGS(&raster->binned)),
                      log));
    TRY(device_launch(
        device, &raster->bins, (size_t)columns * columns * view_count,
        (uint64_t)raster->size_px * raster->size_px * view_count, "raster depth maps",
        ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(raster->views), ARG(view_count), ARG(columns), ARG(chunks),
             BIN_ARGS(&raster->binned), ARG(begin), ARG_BUFFER(*to->maps), ARG(to->first_texel), ATTRIBUTE_ARGS(scene)),
        log));
  }

done:
  return status;
}

static Status direct_draw(RasterDepth *raster, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                          const DepthTarget *to, Log *log)
{
  Status status = STATUS_OK;
  uint32_t view_count = to->view_count, pass_chunks = raster->pass_chunks / view_count;
  size_t texels = (size_t)raster->size_px * raster->size_px * view_count;
  TRY(buffer_fill_part(device, to->maps, to->first_texel, texels, far_depth, log));
  for (uint32_t first = 0; first < triangles->chunk_count; first += pass_chunks) {
    uint32_t first_triangle = first * RASTER_CHUNK;
    uint32_t count = smaller(pass_chunks, triangles->chunk_count - first) * RASTER_CHUNK;
    uint64_t items = (uint64_t)count * view_count;
    TRY(buffer_zero(device, &raster->boxes.counts, log));
    TRY(device_launch(device, &raster->small, items, items, "set up triangles of depth maps, raster small ones",
                      ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ARG(first_triangle),
                           ARG(count), ARG_BUFFER(raster->views), ARG(view_count), ARG_BUFFER(*to->maps),
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
