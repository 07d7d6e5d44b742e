#include "passes/shadow_maps.h"

#include <stdlib.h>
#include <string.h>

uint64_t shadow_bytes_most(const ShadowOptions *options, const Device *device)
{
  return device_budget(device, options->max_bytes, 2000000000);
}

// The fits of all lights, one behind the other in what they take of views and texels; counts those left out.
static void lights_fit(ShadowMaps *maps, ShadowFit *fits, const DeviceScene *scene, const Plan *plan,
                       const CameraInfo *camera, uint64_t most)
{
  const ShadowScope scope = {camera, scene->low, scene->high};
  uint32_t views = 0;
  for (uint32_t i = 0; i < maps->light_count; i++) {
    ShadowInfo *info = &fits[i].info;
    if (!shadow_fit(&fits[i], &scene->light_infos[i], plan->shadows, &plan->shadow_options, &scope)) {
      *info = (ShadowInfo){0};
      continue;
    }
    uint64_t bytes = (uint64_t)info->view_count * info->size_px * info->size_px * sizeof(float);
    if (maps->bytes + bytes > most) {
      *info = (ShadowInfo){0};
      maps->left_out++;
      continue;
    }
    info->first_view = views;
    info->first_texel = (uint32_t)(maps->bytes / sizeof(float));
    views += info->view_count;
    maps->bytes += bytes;
  }
}

static Status light_draw(const ShadowMaps *maps, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                         const ShadowFit *fit, Log *log)
{
  Status status = STATUS_OK;
  RasterDepth raster = {0};
  RasterView views[SHADOW_VIEWS_MOST];
  const ShadowInfo *info = &fit->info;
  for (uint32_t i = 0; i < info->view_count; i++) views[i] = fit->views[i].raster;
  TRY(raster_depth_make(&raster, device, scene, info->size_px, info->view_count, &(RasterOptions){0}, log));
  TRY(raster_depth_into(&raster, device, scene, triangles, views, info->view_count, &maps->maps, info->first_texel,
                        log));

done:
  raster_depth_free(&raster);
  return status;
}

// Infos and views of all lights, and room for the maps.
static Status tables_make(ShadowMaps *maps, Device *device, const ShadowFit *fits, Log *log)
{
  Status status = STATUS_OK;
  uint32_t count = 0;
  ShadowView *views = malloc(((size_t)maps->light_count * SHADOW_VIEWS_MOST + 1) * sizeof *views);
  if (!views) return log_no_memory(log, "shadow maps");
  for (uint32_t i = 0; i < maps->light_count; i++) {
    maps->lights[i] = fits[i].info;
    memcpy(views + count, fits[i].views, fits[i].info.view_count * sizeof *views);
    count += fits[i].info.view_count;
  }
  TRY(buffer_create(&maps->infos, device, maps->light_count * sizeof *maps->lights, maps->lights, "shadow maps", log));
  TRY(buffer_create(&maps->views, device, count * sizeof *views, views, "shadow maps", log));
  TRY(buffer_create(&maps->maps, device, maps->bytes, NULL, "shadow maps", log));

done:
  free(views);
  return status;
}

Status shadow_maps_make(ShadowMaps *out, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                        const Plan *plan, const CameraInfo *camera, Log *log)
{
  Status status = STATUS_OK;
  bool wanted = plan_uses_shadow_maps(plan) && plan->shadows != SHADOWS_HYBRID;
  ShadowMaps maps = {.light_count = wanted ? scene->light_count : 0};
  const uint64_t most = shadow_bytes_most(&plan->shadow_options, device);
  ShadowFit *fits = calloc(maps.light_count + 1, sizeof *fits);
  maps.lights = calloc(maps.light_count + 1, sizeof *maps.lights);
  if (!maps.lights || !fits) {
    status = log_no_memory(log, "shadow maps");
    goto done;
  }
  lights_fit(&maps, fits, scene, plan, camera, most);
  TRY(tables_make(&maps, device, fits, log));
  for (uint32_t i = 0; i < maps.light_count; i++)
    if (shadow_maps_have(&maps, i)) TRY(light_draw(&maps, device, scene, triangles, &fits[i], log));
  if (maps.left_out)
    log_warn(log, "--shadows: maps of %u of %u lights would take over %.1f GB: these lights' shadows are traced",
             maps.left_out, maps.light_count, 1e-9 * (double)most);
  *out = maps;
  maps = (ShadowMaps){0};

done:
  free(fits);
  shadow_maps_free(&maps);
  return status;
}

void shadow_maps_free(ShadowMaps *maps)
{
  DeviceBuffer *buffers[] = {&maps->infos, &maps->views, &maps->maps};
  for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) buffer_free(buffers[i]);
  free(maps->lights);
  *maps = (ShadowMaps){0};
}

bool shadow_maps_have(const ShadowMaps *maps, uint32_t light)
{
  return light < maps->light_count && maps->lights[light].view_count > 0;
}
