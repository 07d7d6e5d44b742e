#include "passes/shadow_maps.h"

#include <stdlib.h>
#include <string.h>

#include "passes/movers.h"
#include "shared/depth_map.h"

uint64_t shadow_bytes_most(const ShadowOptions *options, const Device *device)
{
  return device_budget(device, options->max_bytes, 2000000000);
}

static uint32_t view_texels(const ShadowInfo *info) { return info->size_px * info->size_px; }

// Words behind a light's maps: planes of their blocks, which lookups by kernels of texels take first on a device of
// more than one lane, and what these read beyond the last.
static uint32_t plane_words(const ShadowInfo *info, const Device *device)
{
  enum { BEYOND = 12, MULTIPLE = 16 };
  bool by_kernels = info->method == SHADOW_BY_PCF || info->method == SHADOW_BY_PCSS;
  if (!by_kernels || device_traits(device)->lanes == 1) return 0;
  uint32_t words = info->view_count * (depth_plane_floats(info->size_px) + depth_wide_floats(info->size_px)) + BEYOND;
  return (words + MULTIPLE - 1) / MULTIPLE * MULTIPLE;
}

// The fits of all lights, one behind the other in what they take of views and texels; counts those left out.
static void lights_fit(ShadowMaps *maps, ShadowFit *fits, const DeviceScene *scene, const Plan *plan,
                       const CameraInfo *camera, uint64_t most, const Device *device)
{
  const ShadowScope scope = {camera, scene->low, scene->high};
  uint32_t views = 0;
  for (uint32_t i = 0; i < maps->light_count; i++) {
    ShadowInfo *info = &fits[i].info;
    const LightInfo *light = &scene->light_infos[i];
    const ShadowMethod method = plan_light_shadows(plan, i, light->kind);
    if (!(SHADOW_SET(method) & SHADOW_SET_LOOKED_UP) ||
        !shadow_fit(&fits[i], light, method, &plan->shadow_options, &scope)) {
      *info = (ShadowInfo){0};
      continue;
    }
    uint64_t bytes = ((uint64_t)info->view_count * view_texels(info) + plane_words(info, device)) * sizeof(float);
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

// Infos and views of all lights.
static Status tables_make(ShadowMaps *maps, Device *device, const ShadowFit *fits, Log *log)
{
  Status status = STATUS_OK;
  maps->view_table = malloc(((size_t)maps->light_count * SHADOW_VIEWS_MOST + 1) * sizeof *maps->view_table);
  if (!maps->view_table) return log_no_memory(log, "shadow maps");
  for (uint32_t i = 0; i < maps->light_count; i++) {
    maps->lights[i] = fits[i].info;
    memcpy(maps->view_table + maps->view_count, fits[i].views, fits[i].info.view_count * sizeof *maps->view_table);
    maps->view_count += fits[i].info.view_count;
  }
  TRY(buffer_create(&maps->infos, device, maps->light_count * sizeof *maps->lights, maps->lights, "shadow maps", log));
  TRY(buffer_create(&maps->views, device, maps->view_count * sizeof *maps->view_table, maps->view_table, "shadow maps",
                    log));

done:
  return status;
}

// Do all maps lie where those before lay?
static bool places_are_same(const ShadowMaps *maps, const ShadowMaps *before)
{
  if (maps->light_count != before->light_count || maps->bytes != before->bytes) return false;
  for (uint32_t i = 0; i < maps->light_count; i++) {
    const ShadowInfo *a = &maps->lights[i], *b = &before->lights[i];
    if (a->view_count != b->view_count || a->size_px != b->size_px || a->first_texel != b->first_texel) return false;
  }
  return true;
}

// Did a light's view look the same in the frame before, upon what has not moved?
static bool view_stayed(const ShadowMaps *maps, const ShadowMaps *before, uint32_t light, uint32_t view,
                        const DeviceScene *scene)
{
  if (!before || light >= before->light_count || view >= before->lights[light].view_count) return false;
  const ShadowView *now = &maps->view_table[maps->lights[light].first_view + view];
  const ShadowView *then = &before->view_table[before->lights[light].first_view + view];
  return memcmp(now, then, sizeof *now) == 0 && !moved_casters_seen(scene, &now->raster);
}

// Takes the views of a light that stayed from the maps before; `copied`, they lie in another buffer as yet. Appends the
// others to `views`, [*count].
static Status light_keep(ShadowMaps *maps, const ShadowMaps *before, bool copied, Device *device,
                         const DeviceScene *scene, uint32_t light, RasterView *views, uint32_t *count, Log *log)
{
  Status status = STATUS_OK;
  const ShadowInfo *info = &maps->lights[light];
  const size_t texels = view_texels(info);
  for (uint32_t view = 0; view < info->view_count; view++) {
    if (!view_stayed(maps, before, light, view, scene)) {
      views[*count] = maps->view_table[info->first_view + view].raster;
      views[(*count)++].first_texel = (uint32_t)(info->first_texel + view * texels);
      continue;
    }
    maps->kept[light]++;
    if (copied)
      TRY(buffer_copy_words(device, &before->maps, before->lights[light].first_texel + view * texels, &maps->maps,
                            info->first_texel + view * texels, texels, log));
  }

done:
  return status;
}

// Draws what did not stay of all maps, at once.
static Status maps_draw(ShadowMaps *maps, const ShadowMaps *before, bool copied, Device *device,
                        const DeviceScene *scene, const RasterScene *triangles, Log *log)
{
  Status status = STATUS_OK;
  RasterDepth raster = {0};
  uint32_t count = 0;
  RasterView *views = malloc(maps->view_count * sizeof *views + 1);
  if (!views) return log_no_memory(log, "shadow maps");
  for (uint32_t i = 0; i < maps->light_count; i++)
    TRY(light_keep(maps, before, copied, device, scene, i, views, &count, log));
  if (count) {
    TRY(raster_depth_make(&raster, device, scene, &(RasterOptions){0}, log));
    TRY(raster_depth_into(&raster, device, scene, triangles, views, count, &maps->maps, log));
  }
  for (uint32_t i = 0; i < maps->light_count; i++) {
    const ShadowInfo *info = &maps->lights[i];
    if (plane_words(info, device) && (copied || maps->kept[i] < info->view_count))
      TRY(raster_depth_planes(device, scene, &maps->maps, info->first_texel, info->size_px, info->view_count, log));
  }

done:
  raster_depth_free(&raster);
  free(views);
  return status;
}

Status shadow_maps_make(ShadowMaps *out, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                        const Plan *plan, const CameraInfo *camera, ShadowMaps *before, Log *log)
{
  Status status = STATUS_OK;
  bool wanted = plan_uses_shadows(plan, SHADOW_SET_LOOKED_UP);
  ShadowMaps maps = {.light_count = wanted ? scene->light_count : 0};
  const uint64_t most = shadow_bytes_most(&plan->shadow_options, device);
  ShadowFit *fits = calloc(maps.light_count + 1, sizeof *fits);
  maps.lights = calloc(maps.light_count + 1, sizeof *maps.lights);
  maps.kept = calloc(maps.light_count + 1, sizeof *maps.kept);
  if (!maps.lights || !maps.kept || !fits) {
    status = log_no_memory(log, "shadow maps");
    goto done;
  }
  lights_fit(&maps, fits, scene, plan, camera, most, device);
  TRY(tables_make(&maps, device, fits, log));
  const bool same_places = before && places_are_same(&maps, before);
  if (same_places) {
    maps.maps = before->maps;
    before->maps = (DeviceBuffer){0};
  } else {
    TRY(buffer_create(&maps.maps, device, maps.bytes, NULL, "shadow maps", log));
  }
  TRY(maps_draw(&maps, before, !same_places, device, scene, triangles, log));
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
  free(maps->view_table);
  free(maps->kept);
  *maps = (ShadowMaps){0};
}

bool shadow_maps_have(const ShadowMaps *maps, uint32_t light)
{
  return light < maps->light_count && maps->lights[light].view_count > 0;
}
