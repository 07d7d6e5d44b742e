#include "passes/shadow_hybrid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/scene_args.h"
#include "passes/shadow_maps.h"

static Status kernels_make(ShadowHybrid *hybrid, Device *device, const DeviceScene *scene, Log *log)
{
  Status status = STATUS_OK;
  Program *judge = NULL, *mark = NULL;
  char options[128];
  device_scene_options(scene, TESTS_MASKS | TESTS_BLENDS, options, sizeof options);
  TRY(program_build(&judge, device, "rays/shadow_hybrid.cl", options, log));
  TRY(program_kernel(&hybrid->judge, judge, "shadow_hybrid", log));
  TRY(program_build(&mark, device, "rays/shadow_mark.cl", "", log));
  TRY(program_kernel(&hybrid->mark, mark, "shadow_mark", log));

done:
  return status;
}

static const uint32_t least_size_px = 64;            // of maps made smaller
static const uint32_t marked_tiles_most = 1u << 24;  // of all lights

// Fits the maps of a light: false where it has none.
static bool light_fit(ShadowFit *fit, const ShadowHybrid *hybrid, const LightInfo *light, const ShadowScope *scope,
                      uint32_t size_px)
{
  ShadowOptions options = hybrid->options;
  if (size_px) options.map_size_px = size_px;
  return shadow_fit(fit, light, SHADOWS_HYBRID, &options, scope);
}

// Fits the maps of all lights, as fine as they may become.
static void lights_fit(ShadowHybrid *hybrid, const DeviceScene *scene, const Plan *plan, const CameraInfo *camera)
{
  const ShadowScope scope = {camera, scene->low, scene->high};
  for (uint32_t i = 0; i < scene->light_count; i++) {
    ShadowFit *fit = &hybrid->fits[i];
    const LightInfo *light = &scene->light_infos[i];
    bool can = plan_light_shadows(plan, i, light->kind) == SHADOWS_HYBRID && light_fit(fit, hybrid, light, &scope, 0);
    while (can && !hybrid->options.map_size_px && fit->info.size_px > SHADOW_MAP_LEAST_PX &&
           (uint64_t)sure_maps_tiles(&fit->info) * scene->light_count > marked_tiles_most)
      light_fit(fit, hybrid, light, &scope, fit->info.size_px / 2);
    if (!can) fit->info.view_count = 0;
  }
}

Status shadow_hybrid_make(ShadowHybrid *out, Device *device, const DeviceScene *scene, const Plan *plan,
                          const CameraInfo *camera, uint32_t capacity, uint64_t taken_bytes, Log *log)
{
  Status status = STATUS_OK;
  ShadowHybrid hybrid = {.options = plan->shadow_options, .taken_bytes = taken_bytes};
  hybrid.fits = calloc(scene->light_count + 1, sizeof *hybrid.fits);
  hybrid.probes = calloc(scene->light_count + 1, sizeof *hybrid.probes);
  hybrid.suited = calloc(scene->light_count + 1, sizeof *hybrid.suited);
  hybrid.lights = calloc(scene->light_count + 1, sizeof *hybrid.lights);
  if (!hybrid.fits || !hybrid.probes || !hybrid.suited || !hybrid.lights) {
    status = log_no_memory(log, "sure maps");
    goto done;
  }
  if (scene->light_count) memcpy(hybrid.lights, scene->light_infos, scene->light_count * sizeof *hybrid.lights);
  TRY(kernels_make(&hybrid, device, scene, log));
  TRY(ray_stream_make(&hybrid.unsure, device, capacity, 1, "unsure shadow rays", log));
  TRY(buffer_create(&hybrid.unsure_count, device, sizeof(uint32_t), NULL, "unsure shadow rays", log));
  lights_fit(&hybrid, scene, plan, camera);
  TRY(sure_maps_aim(&hybrid.maps, device, hybrid.fits, scene->light_count, true, log));
  *out = hybrid;
  hybrid = (ShadowHybrid){0};

done:
  shadow_hybrid_free(&hybrid);
  return status;
}

Status shadow_hybrid_mark(ShadowHybrid *hybrid, Device *device, const CameraRays *probes, uint32_t light,
                          const RayStream *rays, uint32_t segment, uint32_t count, Log *log)
{
  const SureMaps *maps = &hybrid->maps;
  if (light >= maps->light_count || maps->lights[light].view_count == 0 || count == 0) return STATUS_OK;
  hybrid->probes[light] += count;
  return device_launch(
      device, &hybrid->mark, work_items(device, count), count, "mark tiles of sure maps",
      ARGS(ARG_BUFFER(probes->cameras), ARG_BUFFER(maps->infos), ARG(light), ARG_BUFFER(maps->views),
           ARG_BUFFER(rays->rays), ARG(rays->capacity), ARG(count), ARG(segment), ARG_BUFFER(maps->marks)),
      log);
}

// Texels that a light's maps should have where receivers are. More cost time as they are drawn, fewer as more rays meet
// the outlines of triangles in their texels: the longer these are for the pixels seen (plan/shadow_cost.c), the more
// texels pay. The factors were found by trial: room, chrome, colonnade and field take about as long with half of them;
// of the shared models these leave a tenth of the rays to be traced at most.
static double texels_wanted(const ShadowHybrid *hybrid, uint32_t light, const DeviceScene *scene,
                            const ShadowReceivers *receivers)
{
  const double least = 0.06, most = 1, by_outlines = 1;
  double seen = (double)hybrid->probes[light] * receivers->probe_pixels;
  double share = by_outlines * sqrt(scene->triangle_count / fmax(seen, 1));
  return seen * fmin(fmax(share, least), most) * pow(receivers->samples, 2.0 / 3);
}

// Gives each light's maps the size that suits what was marked; counts lights for whose maps there is no room.
static Status sizes_choose(ShadowHybrid *hybrid, Device *device, const DeviceScene *scene,
                           const ShadowReceivers *receivers, Log *log)
{
  SureMaps *maps = &hybrid->maps;
  const ShadowScope scope = {receivers->camera, scene->low, scene->high};
  const uint64_t most = shadow_bytes_most(&hybrid->options, device);
  uint64_t bytes = hybrid->taken_bytes;
  uint8_t *levels = calloc(maps->light_count + 1, sizeof *levels);
  if (!levels) return log_no_memory(log, "sure maps");
  for (uint32_t i = 0; i < maps->light_count; i++) {
    ShadowFit *fit = &hybrid->fits[i];
    if (fit->info.view_count == 0) continue;
    const uint32_t size = fit->info.size_px, tile_texels = SHADOW_TILE_PX * SHADOW_TILE_PX;
    double wanted = texels_wanted(hybrid, i, scene, receivers);
    uint32_t tiles = sure_maps_marked(maps, i, 0);
    while (!hybrid->options.map_size_px && size >> levels[i] > least_size_px && tiles * tile_texels > 2 * wanted)
      tiles = sure_maps_marked(maps, i, ++levels[i]);
    if (levels[i]) light_fit(fit, hybrid, &scene->light_infos[i], &scope, size >> levels[i]);
    uint64_t more = sure_maps_tiles(&fit->info) * sizeof(ShadowTile) + tiles * sure_tile_bytes;
    bool left_out = bytes + more > most;
    if (!left_out) bytes += more;
    if (left_out) hybrid->left_out++;
    if (left_out) fit->info.view_count = 0;
  }
  Status status = sure_maps_shrink(maps, device, hybrid->fits, levels, log);
  free(levels);
  if (hybrid->left_out)
    log_warn(log, "--shadows hybrid: maps of %u of %u lights would take over %.1f GB: all their rays are traced",
             hybrid->left_out, scene->light_count, 1e-9 * (double)most);
  return status;
}

static Status solids_settle(ShadowHybrid *hybrid, const DeviceScene *scene, const CameraInfo *camera,
                            ShadowHybrid *before, Log *log)
{
  Status status = STATUS_OK;
  if (before && before->solids.scene && scene->mover_count == 0) {
    hybrid->solids = before->solids;
    before->solids = (Solids){0};
  } else {
    TRY(solids_make(&hybrid->solids, scene->source, log));
  }
  for (uint32_t i = 0; i < hybrid->maps.light_count; i++)
    if (hybrid->maps.lights[i].view_count)
      hybrid->suited[i] = solids_suit(&hybrid->solids, &scene->light_infos[i], camera);

done:
  return status;
}

static bool any_marked(const SureMaps *maps)
{
  for (uint32_t i = 0; i < maps->light_count; i++)
    if (maps->lights[i].view_count && sure_maps_marked(maps, i, 0)) return true;
  return false;
}

// Whether triangles of closed surfaces are left out is the same; whether one is of such does not change without its
// object being a mover.
static bool suited_alike(const ShadowHybrid *hybrid, const ShadowHybrid *before)
{
  const uint32_t count = hybrid->maps.light_count;
  return count == before->maps.light_count && memcmp(hybrid->suited, before->suited, count * sizeof(bool)) == 0;
}

Status shadow_hybrid_draw(ShadowHybrid *hybrid, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                          const ShadowReceivers *receivers, ShadowHybrid *before, Log *log)
{
  Status status = STATUS_OK;
  DeviceBuffer solid = {0};
  SureRaster raster = {0};
  hybrid->camera = *receivers->camera;
  hybrid->samples = receivers->samples;
  if (before && ((scene->mover_count && scene->trees_rebuilt) || before->maps.block_count == 0)) before = NULL;
  TRY(sure_raster_make(&raster, device, triangles, &(RasterOptions){0}, log));
  TRY(sure_maps_read_marks(&hybrid->maps, device, log));
  TRY(sizes_choose(hybrid, device, scene, receivers, log));
  if (any_marked(&hybrid->maps)) TRY(solids_settle(hybrid, scene, receivers->camera, before, log));
  const bool alike = before && suited_alike(hybrid, before);
  TRY(sure_maps_settle(&hybrid->maps, device, scene, alike ? &before->maps : NULL, log));
  if (hybrid->maps.block_count == 0) goto done;
  const Solids *solids = &hybrid->solids;
  TRY(buffer_create(&solid, device, solids->word_count * sizeof *solids->bits, solids->bits, "closed surfaces", log));
  for (uint32_t i = 0; i < hybrid->maps.light_count; i++) {
    if (!shadow_hybrid_has(hybrid, i)) continue;
    TRY(sure_maps_draw(&hybrid->maps, i, &raster, device, triangles, &solid,
                       hybrid->suited[i] ? SURE_MARKED_SOLID : SURE_NONE_MARKED, log));
  }

done:
  sure_raster_free(&raster);
  buffer_free(&solid);
  return status;
}

bool shadow_hybrid_take(ShadowHybrid *hybrid, const DeviceScene *scene, const ShadowReceivers *receivers,
                        ShadowHybrid *before)
{
  const uint32_t lights = hybrid->maps.light_count;
  if (!before || scene->mover_count || before->maps.block_count == 0 || before->maps.light_count != lights)
    return false;
  if (memcmp(&before->camera, receivers->camera, sizeof before->camera) != 0 || before->samples != receivers->samples ||
      memcmp(before->lights, hybrid->lights, lights * sizeof *hybrid->lights) != 0)
    return false;
  hybrid->camera = before->camera;
  hybrid->samples = before->samples;
  hybrid->left_out = before->left_out;
  sure_maps_free(&hybrid->maps);
  solids_free(&hybrid->solids);
  hybrid->maps = before->maps;
  hybrid->solids = before->solids;
  memcpy(hybrid->suited, before->suited, lights * sizeof *hybrid->suited);
  before->maps = (SureMaps){0};
  before->solids = (Solids){0};
  sure_maps_stay(&hybrid->maps);
  return true;
}

Status shadow_hybrid_keep(ShadowHybrid *hybrid, Device *device, uint64_t slots, ShadowHybrid *before, Log *log)
{
  Status status = STATUS_OK;
  const uint64_t most = shadow_bytes_most(&hybrid->options, device);
  uint64_t taken = hybrid->taken_bytes + hybrid->maps.tile_count * sizeof(ShadowTile);
  for (uint32_t i = 0; i < hybrid->maps.light_count; i++) taken += hybrid->maps.known_tiles[i] * sure_tile_bytes;
  if (!before || taken > most) return STATUS_OK;
  TRY(kept_verdicts_make(&hybrid->verdicts, &before->verdicts, device, &hybrid->maps, slots, most - taken, log));
  for (uint32_t i = 0; i < hybrid->maps.light_count && i < VERDICT_LIGHTS; i++)
    if (memcmp(&before->lights[i], &hybrid->lights[i], sizeof *hybrid->lights) != 0)
      hybrid->verdicts.stayed &= ~(((1u << SHADOW_VIEWS_MOST) - 1) << i * SHADOW_VIEWS_MOST);

done:
  return status;
}

void shadow_hybrid_free(ShadowHybrid *hybrid)
{
  kept_verdicts_free(&hybrid->verdicts);
  sure_maps_free(&hybrid->maps);
  free(hybrid->fits);
  free(hybrid->probes);
  free(hybrid->suited);
  free(hybrid->lights);
  solids_free(&hybrid->solids);
  kernel_free(&hybrid->judge);
  kernel_free(&hybrid->mark);
  ray_stream_free(&hybrid->unsure);
  buffer_free(&hybrid->unsure_count);
  *hybrid = (ShadowHybrid){0};
}

bool shadow_hybrid_has(const ShadowHybrid *hybrid, uint32_t light)
{
  return light < hybrid->maps.light_count && hybrid->maps.known_tiles[light] > 0;
}

Status shadow_hybrid_trace(ShadowHybrid *hybrid, const Tracer *tracer, Device *device, const DeviceScene *scene,
                           uint32_t light, const RayStream *rays, uint32_t segment, uint32_t count,
                           const DeviceBuffer *radiance, HybridTrust trust, Log *log)
{
  Status status = STATUS_OK;
  const SureMaps *maps = &hybrid->maps;
  uint32_t unsure = 0;
  const uint32_t dark_alone = trust == HYBRID_TRUST_DARK;
  const bool is_told = trust == HYBRID_TRUST_TOLD;
  const Coherence coherence = trust == HYBRID_TRUST_ALL || is_told ? RAYS_COHERENT : RAYS_INCOHERENT;
  hybrid->rays += count;
  if (trust == HYBRID_TRUST_NONE || is_told) {
    hybrid->traced += count;
    return trace_any(tracer, device, scene, rays, segment, count, radiance, coherence,
                     is_told ? "trace unsure shadow rays" : "trace incoherent shadow rays", log);
  }
  TRY(buffer_zero(device, &hybrid->unsure_count, log));
  TRY(device_launch(
      device, &hybrid->judge, work_items(device, count), count, "judge shadow rays by maps",
      ARGS(ARG_BUFFER(maps->infos), ARG(light), ARG_BUFFER(maps->views), ARG_BUFFER(maps->tiles),
           ARG_BUFFER(maps->blocks), ARG_BUFFER(maps->rows), ARG(maps->block_count), ARG_BUFFER(scene->bvh2_triangles),
           ARG_BUFFER(rays->rays), ARG(rays->capacity), ARG(count), ARG(segment), ARG(dark_alone),
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
  hybrid->traced += unsure;
  if (unsure > 0)
    TRY(trace_any(tracer, device, scene, &hybrid->unsure, 0, unsure, radiance, coherence, "trace unsure shadow rays",
                  log));

done:
  return status;
}
