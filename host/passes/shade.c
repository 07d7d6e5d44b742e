#include "passes/shade.h"

#include <string.h>

#include "device_scene/environment_levels.h"
#include "device_scene/environment_table.h"
#include "passes/raster_scene.h"
#include "passes/scene_args.h"

// What the environment's light needs besides the kernel.
static Status environment_prepare(Shader *shader, Device *device, const DeviceScene *scene, const Plan *plan, Log *log)
{
  Status status = STATUS_OK;
  EnvironmentTable table = {0};
  EnvironmentLevels levels = {0};
  if (plan->lobes && !plan->lobes_alone && scene->environment_lights)
    TRY(environment_table_make(&table, &scene->source->environment, log));
  bool by_image = table.count > 0;
  if (plan->environment_light == ENVIRONMENT_LIGHT_SAMPLED) shader->environment_segments = by_image ? 2 : 1;
  if (plan->environment_light == ENVIRONMENT_LIGHT_SH_AO) shader->environment_segments = OCCLUSION_RAYS;
  shader->environment_open = by_image && plan_samples_lobes(plan);
  shader->environment_segments += shader->environment_open;
  bool harmonics =
      plan->environment_light == ENVIRONMENT_LIGHT_SH || plan->environment_light == ENVIRONMENT_LIGHT_SH_AO;
  if ((harmonics || plan->rough_by_maps) && scene->environment_lights)
    TRY(environment_levels_make(&levels, &scene->source->environment, scene->least_roughness, log));
  TRY(buffer_create(&shader->environment_levels, device, levels.count * sizeof *levels.pixels, levels.pixels,
                    "environment levels", log));
  TRY(buffer_create(&shader->environment_table, device, table.count * sizeof *table.values, table.values,
                    "environment table", log));

done:
  environment_table_free(&table);
  environment_levels_free(&levels);
  return status;
}

Status shader_make(Shader *out, Device *device, const DeviceScene *scene, const Plan *plan, Log *log)
{
  Status status = STATUS_OK;
  Shader shader = {0};
  char options[512];
  const bool judges = plan_uses_shadows(plan, SHADOW_SET(SHADOWS_HYBRID));
  device_scene_options(scene, READS_SURFACES | TESTS_BLENDS | (judges ? TESTS_MASKS : 0), options, sizeof options);
  if (plan->lobes) strcat(options, "-D HAS_LOBES ");
  if (plan->rough_by_maps) strcat(options, "-D HAS_ROUGH_MAPS ");
  if (plan_uses_shadows(plan, SHADOW_SET(SHADOWS_AREA))) strcat(options, "-D HAS_AREA_LIGHTS ");
  if (plan_uses_shadows(plan, SHADOW_SET_LOOKED_UP)) strcat(options, "-D HAS_SHADOW_MAPS ");
  if (judges) strcat(options, "-D HAS_SURE_MAPS ");
  if (plan_uses_shadows(plan, SHADOW_SET(SHADOWS_PCSS))) strcat(options, "-D HAS_DISC ");
  if (plan->receivers) strcat(options, "-D HAS_RECEIVERS ");
  if (plan->environment_light == ENVIRONMENT_LIGHT_SH_AO) strcat(options, "-D HAS_OCCLUSION_RAYS ");
  if (plan->primary == PRIMARY_RASTER && raster_way(&(RasterOptions){0}, device) == RASTER_WAY_DIRECT)
    strcat(options, "-D HAS_KEYS ");
  if (!plan_sends_rays(plan))
    program_registers_option(options + strlen(options), sizeof options - strlen(options),
                             device_traits(device)->lean_shade_registers);
  TRY(environment_prepare(&shader, device, scene, plan, log));
  TRY(program_build(&shader.program, device, "shade/shade.cl", options, log));
  TRY(program_kernel(&shader.kernel, shader.program, "shade", log));
  TRY(buffer_create(&shader.nothing, device, 0, NULL, "nothing", log));
  TRY(buffer_create(&shader.counts, device, STREAM_COUNTS * sizeof(uint32_t), NULL, "stream counters", log));
  *out = shader;
  shader = (Shader){0};

done:
  shader_free(&shader);
  return status;
}

void shader_free(Shader *shader)
{
  kernel_free(&shader->kernel);
  buffer_free(&shader->counts);
  buffer_free(&shader->nothing);
  buffer_free(&shader->environment_table);
  buffer_free(&shader->environment_levels);
  *shader = (Shader){0};
}

// What the kernel reads of shadows.
typedef struct MapBuffers {
  DeviceBuffer infos, views, texels;
  DeviceBuffer sure_infos, sure_views, tiles, blocks, rows, verdicts;
  uint32_t block_count, verdict_slots, verdicts_stay;
} MapBuffers;

static MapBuffers map_buffers(const Shader *shader, const ShadeStreams *streams)
{
  const DeviceBuffer none = shader->nothing;
  const ShadowMaps *maps = streams->maps;
  const SureMaps *sure = streams->sure;
  MapBuffers of = {none, none, none, none, none, none, none, none, none, 0, 0, 0};
  if (maps && maps->infos.memory) {
    of.infos = maps->infos;
    of.views = maps->views;
    of.texels = maps->maps;
  }
  if (sure && sure->tiles.memory) {
    of.sure_infos = sure->infos;
    of.sure_views = sure->views;
    of.tiles = sure->tiles;
    of.blocks = sure->blocks;
    of.rows = sure->rows;
    of.block_count = sure->block_count;
  }
  if (streams->verdicts && streams->verdicts->slots) {
    of.verdicts = streams->verdicts->words;
    of.verdict_slots = streams->verdicts->slots;
    of.verdicts_stay = streams->verdicts->stayed;
  }
  return of;
}

Status shade(const Shader *shader, Device *device, const DeviceScene *scene, const ShadeStreams *streams,
             uint32_t count, const ShadeInfo *info, uint32_t counts[STREAM_COUNTS], const char *sentence, Log *log)
{
  Status status = STATUS_OK;
  const ShadowMaps *maps = streams->maps;
  const CameraRays none = {.cameras = shader->nothing, .offsets = shader->nothing};
  const CameraRays *camera = streams->camera ? streams->camera : &none;
  const MapBuffers of = map_buffers(shader, streams);
  bool shadow_rays = false;
  for (uint32_t i = 0; i < info->light_count; i++)
    shadow_rays |= info->casting_lights >> i & 1 && (!maps || !shadow_maps_have(maps, info->first_light + i));
  bool spawns =
      shadow_rays || info->reflect || (info->first_batch && (scene->has_blends || shader->environment_segments > 0));
  DeviceBuffer counters = shader->counts, keys = streams->keys ? *streams->keys : shader->nothing;
  memset(counts, 0, STREAM_COUNTS * sizeof *counts);
  if (spawns) TRY(buffer_zero(device, &counters, log));
  TRY(device_launch(
      device, &shader->kernel, work_items(device, count), count, sentence,
      ARGS(ARG(*info), ARG_BUFFER(streams->rays->rays), ARG_BUFFER(streams->rays->slots), ARG(streams->rays->capacity),
           ARG(count), ARG_BUFFER(streams->hits->hits), ARG_BUFFER(streams->hits->ids), ARG_BUFFER(keys),
           ARG_BUFFER(scene->positions), ARG_BUFFER(scene->normals), ARG_BUFFER(scene->tangents), ATTRIBUTE_ARGS(scene),
           ARG_BUFFER(scene->lights), ARG_BUFFER(scene->environment), ARG_BUFFER(scene->environment_pixels),
           ARG_BUFFER(shader->environment_table), ARG_BUFFER(shader->environment_levels), ARG_BUFFER(of.infos),
           ARG_BUFFER(of.views), ARG_BUFFER(of.texels), ARG_BUFFER(of.sure_infos), ARG_BUFFER(of.sure_views),
           ARG_BUFFER(of.tiles), ARG_BUFFER(of.blocks), ARG_BUFFER(of.rows), ARG(of.block_count),
           ARG_BUFFER(scene->bvh2_triangles), ARG_BUFFER(of.verdicts), ARG(of.verdict_slots), ARG(of.verdicts_stay),
           ARG_BUFFER(*streams->radiance), ARG_BUFFER(streams->shadow->rays), ARG_BUFFER(streams->shadow->slots),
           ARG_BUFFER(streams->reflected->rays), ARG_BUFFER(streams->reflected->slots),
           ARG_BUFFER(streams->transmitted->rays), ARG_BUFFER(streams->transmitted->slots), ARG_BUFFER(shader->counts),
           ARG_BUFFER(camera->cameras), ARG(camera->view_count), ARG_BUFFER(camera->offsets)),
      log));
  if (spawns) TRY(buffer_read(device, &shader->counts, counts, STREAM_COUNTS * sizeof *counts, log));
  for (int i = 0; i < STREAM_COUNTS; i++)
    if (counts[i] > count * (i >= STREAM_COUNT_JUDGED ? LIGHTS_PER_LAUNCH : 1)) {
      status = log_fail(log, STATUS_DEVICE, "%s: says that %u rays spawned %u: it computes wrong: try another --device",
                        device_info(device)->name, count, counts[i]);
      goto done;
    }

done:
  return status;
}
