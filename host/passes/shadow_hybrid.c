#include "passes/shadow_hybrid.h"

#include <stdlib.h>

#include "device_scene/solid.h"
#include "passes/raster_bins.h"
#include "passes/scene_args.h"
#include "passes/shadow_maps.h"
#include "shared/raster.h"

static uint32_t divide_up(uint32_t a, uint32_t b) { return (a + b - 1) / b; }
static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

static uint64_t blocks_of(const ShadowInfo *info)
{
  return (uint64_t)info->view_count * (info->size_px / 4) * (info->size_px / 4);
}

static uint64_t rows_of(const ShadowInfo *info) { return (SHADOW_NUMBERS - 1) * blocks_of(info); }

static uint64_t bytes_of(const ShadowInfo *info)
{
  return blocks_of(info) * sizeof(ShadowBlock) + rows_of(info) * sizeof(ShadowRow);
}

// By passes over the scene's chunks, as depth maps are (passes/raster_depth.c).
static Status maps_draw(SureMaps *maps, const ShadowHybrid *hybrid, Device *device, const RasterScene *triangles,
                        const DeviceBuffer *solid, uint32_t skip_facing, Log *log)
{
  Status status = STATUS_OK;
  const ShadowInfo *info = &maps->info;
  RasterBins binned = {0};
  uint32_t columns = divide_up(info->size_px, RASTER_BIN_PX), views = info->view_count, begin = 1;
  uint32_t pass_chunks =
      raster_pass_chunks(&(RasterOptions){0}, RASTER_WAY_BINS, triangles->chunk_count * views) / views;
  TRY(raster_bins_make(&binned, device, (size_t)pass_chunks * views, SURE_WORDS, log));
  TRY(raster_bins_divide(&binned, device, (size_t)pass_chunks * views, (size_t)columns * columns, log));
  for (uint32_t first = 0; first < triangles->chunk_count || begin; first += pass_chunks, begin = 0) {
    uint32_t chunks = smaller(pass_chunks, triangles->chunk_count - first);
    uint64_t items = (uint64_t)chunks * views;
    TRY(device_launch(device, &hybrid->setup, items, items * RASTER_CHUNK, "set up and bin triangles of sure maps",
                      ARGS(ARG_BUFFER(triangles->blocks), ARG_BUFFER(triangles->bounds), ARG(first), ARG(chunks),
                           ARG_BUFFER(maps->views), ARG(views), ARG(columns), ARG_BUFFER(*solid), ARG(skip_facing),
                           BIN_ARGS(&binned)),
                      log));
    TRY(device_launch(device, &hybrid->bins, (size_t)columns * columns * views,
                      (uint64_t)info->size_px * info->size_px * views, "raster sure maps",
                      ARGS(ARG(info->size_px), ARG(views), ARG(columns), ARG(chunks), BIN_ARGS(&binned), ARG(begin),
                           ARG_BUFFER(maps->blocks), ARG_BUFFER(maps->rows)),
                      log));
  }

done:
  raster_bins_free(&binned);
  return status;
}

static Status light_draw(SureMaps *out, const ShadowHybrid *hybrid, Device *device, const RasterScene *triangles,
                         const ShadowFit *fit, const DeviceBuffer *solid, bool skip_facing, Log *log)
{
  Status status = STATUS_OK;
  const ShadowInfo *info = &fit->info;
  out->info = *info;
  TRY(buffer_create(&out->info_buffer, device, sizeof *info, info, "sure maps", log));
  TRY(buffer_create(&out->views, device, info->view_count * sizeof *fit->views, fit->views, "sure maps", log));
  TRY(buffer_create(&out->blocks, device, blocks_of(info) * sizeof(ShadowBlock), NULL, "sure maps", log));
  TRY(buffer_create(&out->rows, device, rows_of(info) * sizeof(ShadowRow), NULL, "sure maps", log));
  TRY(maps_draw(out, hybrid, device, triangles, solid, skip_facing, log));

done:
  return status;
}

static Status kernels_make(ShadowHybrid *hybrid, Device *device, const DeviceScene *scene, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  char options[128];
  device_scene_options(scene, options, sizeof options);
  TRY(program_build(&program, device, "raster/shadow_texels.cl", "", log));
  TRY(program_kernel(&hybrid->setup, program, "shadow_setup", log));
  TRY(program_kernel(&hybrid->bins, program, "shadow_bins", log));
  TRY(program_build(&program, device, "rays/shadow_hybrid.cl", options, log));
  TRY(program_kernel(&hybrid->judge, program, "shadow_hybrid", log));

done:
  return status;
}

Status shadow_hybrid_make(ShadowHybrid *out, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                          const Plan *plan, const CameraInfo *camera, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  ShadowHybrid hybrid = {.light_count = scene->light_count};
  Solids solids = {0};
  DeviceBuffer solid = {0};
  const ShadowScope scope = {camera, scene->low, scene->high};
  const uint64_t most = shadow_bytes_most(&plan->shadow_options, device);
  uint64_t bytes = 0;
  hybrid.lights = calloc(hybrid.light_count + 1, sizeof *hybrid.lights);
  if (!hybrid.lights) return log_no_memory(log, "sure maps");
  TRY(kernels_make(&hybrid, device, scene, log));
  TRY(ray_stream_make(&hybrid.unsure, device, capacity, 1, "unsure shadow rays", log));
  TRY(buffer_create(&hybrid.unsure_count, device, sizeof(uint32_t), NULL, "unsure shadow rays", log));
  if (hybrid.light_count > 0) TRY(solids_make(&solids, scene->source, log));
  TRY(buffer_create(&solid, device, solids.word_count * sizeof *solids.bits, solids.bits, "closed surfaces", log));
  for (uint32_t i = 0; i < hybrid.light_count; i++) {
    ShadowFit fit;
    if (!shadow_fit(&fit, &scene->light_infos[i], plan->shadows, &plan->shadow_options, &scope)) continue;
    uint64_t more = bytes_of(&fit.info);
    if (bytes + more > most) {
      hybrid.left_out++;
      continue;
    }
    bytes += more;
    bool suits = solids_suit(&solids, &scene->light_infos[i], camera);
    TRY(light_draw(&hybrid.lights[i], &hybrid, device, triangles, &fit, &solid, suits, log));
  }
  if (hybrid.left_out)
    log_warn(log, "--shadows hybrid: maps of %u of %u lights would take over %.1f GB: all their rays are traced",
             hybrid.left_out, hybrid.light_count, 1e-9 * (double)most);
  *out = hybrid;
  hybrid = (ShadowHybrid){0};

done:
  buffer_free(&solid);
  solids_free(&solids);
  shadow_hybrid_free(&hybrid);
  return status;
}

void shadow_hybrid_free(ShadowHybrid *hybrid)
{
  for (uint32_t i = 0; i < hybrid->light_count && hybrid->lights; i++) {
    SureMaps *maps = &hybrid->lights[i];
    buffer_free(&maps->info_buffer);
    buffer_free(&maps->views);
    buffer_free(&maps->blocks);
    buffer_free(&maps->rows);
  }
  free(hybrid->lights);
  Kernel *kernels[] = {&hybrid->setup, &hybrid->bins, &hybrid->judge};
  for (size_t i = 0; i < sizeof kernels / sizeof *kernels; i++) kernel_free(kernels[i]);
  ray_stream_free(&hybrid->unsure);
  buffer_free(&hybrid->unsure_count);
  *hybrid = (ShadowHybrid){0};
}

bool shadow_hybrid_has(const ShadowHybrid *hybrid, uint32_t light)
{
  return light < hybrid->light_count && hybrid->lights[light].blocks.memory;
}

Status shadow_hybrid_trace(ShadowHybrid *hybrid, const Tracer *tracer, Device *device, const DeviceScene *scene,
                           uint32_t light, const RayStream *rays, uint32_t segment, uint32_t count,
                           const DeviceBuffer *radiance, Coherence coherence, Log *log)
{
  Status status = STATUS_OK;
  const SureMaps *of = &hybrid->lights[light];
  uint32_t unsure = 0;
  TRY(buffer_zero(device, &hybrid->unsure_count, log));
  TRY(device_launch(
      device, &hybrid->judge, work_items(device, count), count, "judge shadow rays by maps",
      ARGS(ARG_BUFFER(of->info_buffer), ARG_BUFFER(of->views), ARG_BUFFER(of->blocks), ARG_BUFFER(of->rows),
           ARG_BUFFER(scene->bvh2_triangles), ARG_BUFFER(rays->rays), ARG(rays->capacity), ARG(count), ARG(segment),
           ARG_BUFFER(rays->slots), ARG_BUFFER(*radiance), ARG_BUFFER(hybrid->unsure.rays),
           ARG_BUFFER(hybrid->unsure.slots), ARG_BUFFER(hybrid->unsure_count), ATTRIBUTE_ARGS(scene)),
      log));
  TRY(buffer_read(device, &hybrid->unsure_count, &unsure, sizeof unsure, log));
  if (unsure > count) {
    status =
        log_fail(log, STATUS_DEVICE, "%s: says that %u of %u rays are unsure: it computes wrong: try another --device",
                 device_info(device)->name, unsure, count);
    goto done;
  }
  hybrid->rays += count;
  hybrid->traced += unsure;
  if (unsure > 0)
    TRY(trace_any(tracer, device, scene, &hybrid->unsure, 0, unsure, radiance, coherence, "trace unsure shadow rays",
                  log));

done:
  return status;
}
