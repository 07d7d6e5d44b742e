#include "passes/shadow_doubt.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/scene_args.h"

Status shadow_doubt_make(ShadowDoubt *out, Device *device, const ShadowMaps *maps, bool has_disc, uint32_t capacity,
                         Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  ShadowDoubt doubt = {.maps = maps, .capacity = capacity};
  doubt.slots = calloc(capacity, sizeof *doubt.slots);
  doubt.wave = calloc(capacity, sizeof *doubt.wave);
  doubt.lights = calloc(maps->light_count + 1, sizeof *doubt.lights);
  if (!doubt.slots || !doubt.wave || !doubt.lights) {
    status = log_no_memory(log, "shadow doubts");
    goto done;
  }
  TRY(program_build(&program, device, "shade/shadow_doubt.cl", has_disc ? "-D HAS_DISC" : "", log));
  TRY(program_kernel(&doubt.kernel, program, "shadow_doubt", log));
  TRY(buffer_create(&doubt.shown, device, capacity * sizeof(Float4), NULL, "shadow doubts", log));
  TRY(buffer_create(&doubt.by_slot, device, capacity * sizeof(float), NULL, "shadow doubts", log));
  *out = doubt;
  doubt = (ShadowDoubt){0};

done:
  shadow_doubt_free(&doubt);
  return status;
}

void shadow_doubt_free(ShadowDoubt *doubt)
{
  kernel_free(&doubt->kernel);
  buffer_free(&doubt->by_slot);
  buffer_free(&doubt->shown);
  free(doubt->slots);
  free(doubt->wave);
  free(doubt->lights);
  *doubt = (ShadowDoubt){0};
}

Status shadow_doubt_begin_wave(ShadowDoubt *doubt, Device *device, uint32_t pixels, uint32_t samples, Log *log)
{
  doubt->pixels = pixels;
  doubt->samples = samples;
  return buffer_zero(device, &doubt->shown, log);
}

// Adds a wave's doubts, by slot, to sums over its probes: those of a probe's samples together, at most 1.
static void probes_sum(double *sum, double *sum_squared, const ShadowDoubt *doubt, const float *slots)
{
  uint32_t together = doubt->samples_a_probe, probes = doubt->samples / together;
  for (uint32_t i = 0; i < doubt->pixels * probes; i++) {
    double probe = 0;
    for (uint32_t k = 0; k < together; k++)
      probe += (double)slots[(size_t)(i / doubt->pixels * together + k) * doubt->pixels + i % doubt->pixels];
    probe = fmin(probe, 1);
    *sum += probe;
    *sum_squared += probe * probe;
  }
}

static Status rays_doubt(const ShadowDoubt *doubt, Device *device, const DeviceScene *scene, uint32_t light,
                         const RayStream *rays, uint32_t segment, uint32_t count, Log *log)
{
  const uint32_t showing = doubt->showing, has_finer = doubt->finer && shadow_maps_have(doubt->finer, light);
  const ShadowMaps *maps = doubt->maps, *finer = has_finer ? doubt->finer : maps;
  return device_launch(
      device, &doubt->kernel, work_items(device, count), count, "doubt shadow maps",
      ARGS(ARG_BUFFER(maps->infos), ARG_BUFFER(maps->views), ARG_BUFFER(maps->maps), ARG_BUFFER(finer->infos),
           ARG_BUFFER(finer->views), ARG_BUFFER(finer->maps), ARG(has_finer), ARG(light), ARG_BUFFER(rays->rays),
           ARG(rays->capacity), ARG(count), ARG(segment), ARG_BUFFER(rays->slots), ARG_BUFFER(scene->corners),
           ARG_BUFFER(scene->positions), ARG(doubt->least_weight), ARG(doubt->scale), ARG(showing),
           ARG_BUFFER(doubt->shown), ARG_BUFFER(doubt->by_slot)),
      log);
}

Status shadow_doubt_add(ShadowDoubt *doubt, Device *device, const DeviceScene *scene, uint32_t light,
                        const RayStream *rays, uint32_t segment, uint32_t count, Log *log)
{
  Status status = STATUS_OK;
  if (!shadow_maps_have(doubt->maps, light) || count == 0) return STATUS_OK;
  if (doubt->showing) return rays_doubt(doubt, device, scene, light, rays, segment, count, log);
  TRY(buffer_zero(device, &doubt->by_slot, log));
  TRY(rays_doubt(doubt, device, scene, light, rays, segment, count, log));
  TRY(buffer_read(device, &doubt->by_slot, doubt->slots, doubt->capacity * sizeof(float), log));
  for (uint32_t i = 0; i < doubt->capacity; i++) doubt->wave[i] += doubt->slots[i] * fmaxf(1 - doubt->wave[i], 0);
  double unused = 0;
  probes_sum(&doubt->lights[light], &unused, doubt, doubt->slots);

done:
  return status;
}

void shadow_doubt_end_wave(ShadowDoubt *doubt)
{
  probes_sum(&doubt->sum, &doubt->sum_squared, doubt, doubt->wave);
  memset(doubt->wave, 0, doubt->capacity * sizeof *doubt->wave);
}
