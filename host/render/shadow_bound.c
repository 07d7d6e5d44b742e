#include "render/shadow_bound.h"

#include <math.h>
#include <stdlib.h>

#include "plan/samples.h"

enum { PROBES = 16384, BLOCK_PROBES = 8, SAMPLES_MOST = 16, FINER_PX = 1024 };

static const double least_shown = 2.0 / 255 / 12.92;  // linear: sRGB is straight there
static const double normal_99 = 2.576;

// Pixels of a block, and how wide it is.
typedef struct Block {
  uint32_t side_px, probes;
} Block;

static Block block_choose(const CameraInfo *camera)
{
  double pixels = (double)camera->width * camera->height;
  uint32_t side = (uint32_t)fmax(1, ceil(sqrt(pixels * BLOCK_PROBES / PROBES)));
  return side * side > BLOCK_PROBES ? (Block){side, BLOCK_PROBES} : (Block){side, side * side};
}

// Positions of samples in a block, sample by sample of its first probe, then of the next. Where not all of its pixels
// are probes they are those that the standard pattern of 8 samples lies in: none shares a row or a column with another.
static Status block_offsets(float (**out)[2], Block block, uint32_t samples, Log *log)
{
  float places[BLOCK_PROBES][2], pattern[SAMPLES_MOST][2];
  uint32_t side = block.side_px, count = block.probes * samples;
  *out = malloc(count * sizeof **out);
  if (!*out) return log_no_memory(log, "shadow bound");
  sample_pattern(places, BLOCK_PROBES);
  sample_pattern(pattern, samples);
  for (uint32_t i = 0; i < count; i++) {
    uint32_t probe = i / samples, in_turn[2] = {probe % side, probe / side};
    for (int axis = 0; axis < 2; axis++) {
      double pixel = block.probes == side * side ? in_turn[axis] : floor((double)places[probe][axis] * block.side_px);
      (*out)[i][axis] = (float)((pixel + (double)pattern[i % samples][axis]) / side);
    }
  }
  return STATUS_OK;
}

// The frame's request, for probes in place of pixels.
static FrameRequest probe_request(const Frame *frame, Block block, uint32_t samples, ShadowDoubt *doubt)
{
  FrameRequest request = frame->request;
  request.doubt = doubt;
  request.block_px = block.side_px;
  request.samples = samples * block.probes;
  request.aovs = AOV_SET_NONE;
  request.progress = NULL;
  request.plan.primary = PRIMARY_RAYS;
  request.plan.shadow_methods = SHADOW_SET(SHADOWS_RAYS);
  request.plan.receivers = true;
  if (reflections_use_cubes(request.plan.reflections) || request.plan.reflections == REFLECTIONS_PLANAR)
    request.plan.reflections = REFLECTIONS_RAYS;
  if (reflections_use_cubes(request.plan.deep_reflections)) request.plan.deep_reflections = REFLECTIONS_RAYS;
  EnvironmentLightMethod environment = request.plan.environment_light;
  if (environment == ENVIRONMENT_LIGHT_SH || environment == ENVIRONMENT_LIGHT_AMBIENT)
    request.plan.environment_light = ENVIRONMENT_LIGHT_NONE;
  return request;
}

// Size of finer maps for all lights of a method, MAP or PCSS; 0: none. What nearest texels of large maps get wrong is
// told well enough by these themselves; for PCSS a light of some size makes a wide, visible half-shadow even of what is
// much thinner than a texel.
static uint32_t finer_px(const ShadowMaps *maps, ShadowMethod method)
{
  const uint32_t looked_up = method == SHADOWS_PCSS ? SHADOW_BY_PCSS : SHADOW_BY_TEXEL;
  uint32_t size = 0;
  for (uint32_t i = 0; i < maps->light_count; i++)
    if (maps->lights[i].method == looked_up && maps->lights[i].size_px > size) size = maps->lights[i].size_px;
  uint32_t finer = size * 4 < FINER_PX ? size * 4 : size * 2 < FINER_PX ? FINER_PX : size * 2;
  bool wanted = size > 0 && (method == SHADOWS_PCSS || size < FINER_PX);
  return wanted && finer <= SHADOW_MAP_MOST_PX ? finer : 0;
}

// Finer maps of the same lights.
static Status finer_make(ShadowMaps *out, const Frame *frame, Log *log)
{
  Plan plan = frame->request.plan;
  Log quiet = {0};
  uint32_t by_texel = finer_px(&frame->shadow_maps, SHADOWS_MAP), by_disc = finer_px(&frame->shadow_maps, SHADOWS_PCSS);
  if (!by_texel && !by_disc) return STATUS_OK;
  plan.shadow_methods =
      SHADOW_SET(SHADOWS_RAYS) | (by_texel ? SHADOW_SET(SHADOWS_MAP) : 0) | (by_disc ? SHADOW_SET(SHADOWS_PCSS) : 0);
  plan.shadow_options.map_size_px = by_texel > by_disc ? by_texel : by_disc;
  Status status = shadow_maps_make(out, frame->device, frame->scene, &frame->raster_scene, &plan, &frame->camera.info,
                                   NULL, &quiet);
  return status ? log_fail(log, status, "%s", quiet.error) : STATUS_OK;
}

// By how much the bound is above what is expected: the mean of the lights' own factors, by what each puts off.
static double bound_factor(const ShadowBound *bound, const ShadowMaps *maps)
{
  const double of_map = 2, of_ramps = 1.35;
  double by_map = 0, by_ramps = 0;
  for (uint32_t i = 0; i < maps->light_count; i++)
    *(maps->lights[i].method == SHADOW_BY_TEXEL ? &by_map : &by_ramps) += bound->lights[i];
  if (by_map <= 0) return of_ramps;
  return by_ramps <= 0 ? of_map : (by_map * of_map + by_ramps * of_ramps) / (by_map + by_ramps);
}

Status shadow_bound_make(ShadowBound *out, const Frame *frame, float scale, Log *log)
{
  Status status = STATUS_OK;
  Frame probing = {0};
  ShadowDoubt doubt = {0};
  ShadowMaps finer = {0};
  float(*offsets)[2] = NULL;
  Device *device = frame->device;
  uint32_t light_count = frame->scene->light_count, samples = frame->request.samples;
  if (samples > SAMPLES_MOST) samples = SAMPLES_MOST;
  Block block = block_choose(&frame->camera.info);
  ShadowBound bound = {.lights = calloc(light_count + 1, sizeof *bound.lights)};
  FrameRequest request = probe_request(frame, block, samples, &doubt);
  if (!bound.lights) return log_no_memory(log, "shadow bound");
  TRY(block_offsets(&offsets, block, samples, log));
  TRY(frame_make(&probing, device, frame->scene, &request, log));
  TRY(buffer_write(device, &probing.camera.offsets, offsets, request.samples * sizeof *offsets, log));
  TRY(shadow_doubt_make(&doubt, device, &frame->shadow_maps,
                        plan_uses_shadows(&frame->request.plan, SHADOW_SET(SHADOWS_PCSS)), probing.capacity, log));
  TRY(finer_make(&finer, frame, log));
  doubt.finer = &finer;
  doubt.least_weight = (float)(least_shown / (double)scale);
  doubt.scale = scale;
  doubt.samples_a_probe = samples;
  TRY(frame_render(&probing, log));
  bound.probes = (uint64_t)probing.camera.info.width * probing.camera.info.height * block.probes;
  double count = (double)bound.probes;
  for (uint32_t i = 0; i < light_count; i++) bound.lights[i] = fmin(doubt.lights[i] / count, 1);
  bound.expected = doubt.sum / count;
  double error = sqrt(fmax(doubt.sum_squared / count - bound.expected * bound.expected, 0) / count);
  bound.bound = fmin(bound_factor(&bound, &frame->shadow_maps) * (bound.expected + normal_99 * error), 1);
  *out = bound;
  bound = (ShadowBound){0};

done:
  shadow_bound_free(&bound);
  shadow_doubt_free(&doubt);
  shadow_maps_free(&finer);
  frame_free(&probing);
  free(offsets);
  return status;
}

void shadow_bound_free(ShadowBound *bound)
{
  free(bound->lights);
  *bound = (ShadowBound){0};
}
