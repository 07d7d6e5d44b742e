#include "passes/shadow_maps.h"

#include <stdlib.h>

#include "passes/scene_args.h"

uint64_t shadow_bytes_most(const ShadowOptions *options, const Device *device)
{
  const uint64_t usual_most = 2000000000, quarter = device_info(device)->memory_bytes / 4;
  if (options->max_bytes) return options->max_bytes;
  return quarter < usual_most ? quarter : usual_most;
}

static Status light_draw(LightMaps *out, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                         const ShadowFit *fit, Log *log)
{
  Status status = STATUS_OK;
  RasterDepth raster = {0};
  RasterView views[SHADOW_VIEWS_MOST];
  const ShadowInfo *info = &fit->info;
  for (uint32_t i = 0; i < info->view_count; i++) views[i] = fit->views[i].raster;
  out->info = *info;
  TRY(buffer_create(&out->info_buffer, device, sizeof *info, info, "shadow maps", log));
  TRY(buffer_create(&out->views, device, info->view_count * sizeof *fit->views, fit->views, "shadow maps", log));
  TRY(raster_depth_make(&raster, device, scene, triangles, info->size_px, info->view_count, &(RasterOptions){0}, log));
  TRY(raster_depth(&raster, device, scene, triangles, views, info->view_count, log));
  out->maps = raster.maps;
  raster.maps = (DeviceBuffer){0};

done:
  raster_depth_free(&raster);
  return status;
}

Status shadow_maps_make(ShadowMaps *out, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                        const Plan *plan, const CameraInfo *camera, Log *log)
{
  Status status = STATUS_OK;
  ShadowMaps maps = {.light_count = scene->light_count};
  Program *program = NULL;
  const ShadowScope scope = {camera, scene->low, scene->high};
  const uint64_t most = shadow_bytes_most(&plan->shadow_options, device);
  maps.lights = calloc(maps.light_count + 1, sizeof *maps.lights);
  if (!maps.lights) return log_no_memory(log, "shadow maps");
  TRY(program_build(&program, device, "shade/shadow_filter.cl", plan->shadows == SHADOWS_PCSS ? "-D HAS_DISC" : "",
                    log));
  TRY(program_kernel(&maps.filter, program, "shadow_filter", log));
  for (uint32_t i = 0; i < maps.light_count; i++) {
    ShadowFit fit;
    if (!shadow_fit(&fit, &scene->light_infos[i], plan->shadows, &plan->shadow_options, &scope)) continue;
    uint64_t bytes = (uint64_t)fit.info.view_count * fit.info.size_px * fit.info.size_px * sizeof(float);
    if (maps.bytes + bytes > most) {
      maps.left_out++;
      continue;
    }
    maps.bytes += bytes;
    TRY(light_draw(&maps.lights[i], device, scene, triangles, &fit, log));
  }
  if (maps.left_out)
    log_warn(log, "--shadows: maps of %u of %u lights would take over %.1f GB: these lights' shadows are traced",
             maps.left_out, maps.light_count, 1e-9 * (double)most);
  *out = maps;
  maps = (ShadowMaps){0};

done:
  shadow_maps_free(&maps);
  return status;
}

void shadow_maps_free(ShadowMaps *maps)
{
  for (uint32_t i = 0; i < maps->light_count && maps->lights; i++) {
    buffer_free(&maps->lights[i].info_buffer);
    buffer_free(&maps->lights[i].views);
    buffer_free(&maps->lights[i].maps);
  }
  free(maps->lights);
  kernel_free(&maps->filter);
  *maps = (ShadowMaps){0};
}

bool shadow_maps_have(const ShadowMaps *maps, uint32_t light)
{
  return light < maps->light_count && maps->lights[light].maps.memory;
}

Status shadow_maps_filter(const ShadowMaps *maps, Device *device, const DeviceScene *scene, uint32_t light,
                          const RayStream *rays, uint32_t segment, uint32_t count, const DeviceBuffer *radiance,
                          Log *log)
{
  const LightMaps *of = &maps->lights[light];
  return device_launch(
      device, &maps->filter, work_items(device, count), count, "look up shadow maps",
      ARGS(ARG_BUFFER(of->info_buffer), ARG_BUFFER(of->views), ARG_BUFFER(of->maps), ARG_BUFFER(rays->rays),
           ARG(rays->capacity), ARG(count), ARG(segment), ARG_BUFFER(rays->slots), ARG_BUFFER(scene->corners),
           ARG_BUFFER(scene->positions), ARG_BUFFER(*radiance)),
      log);
}
