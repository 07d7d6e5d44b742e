#include "render/cubes_draw.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/cube_prefilter.h"
#include "render/bounce.h"
#include "render/capture_waves.h"
#include "render/cube_doubts.h"
#include "shared/stream.h"

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

bool cubes_are_marched(const Plan *plan)
{
  return plan_uses_reflections(plan, REFLECTIONS_IMPOSTOR) || plan_uses_lists(plan);
}

// What is drawn in a cube: no cubes, one bounce less. Hybrid reflections leave what mirrors show there.
static Plan plan_of_capture(const Plan *plan)
{
  Plan capture = *plan;
  bool maps = reflections_use_maps(plan->deep_reflections);
  if (maps) capture.deep_reflections = REFLECTIONS_ENVIRONMENT;
  if (plan->reflections == REFLECTIONS_HYBRID) capture.deep_reflections = REFLECTIONS_NONE;
  if (maps || plan->rough_by_maps) capture.max_roughness = 0;
  capture.rough_by_maps = false;
  capture.reflections = capture.deep_reflections;
  if (capture.max_depth > 0) capture.max_depth--;
  capture.reflected_rays = capture.max_depth > 0 && capture.reflections != REFLECTIONS_NONE;
  return capture;
}

static Status cube_keep(Frame *frame, const Wave *wave, float share, Log *log)
{
  return cube_capture_keep(&frame->cube_capture, frame->device, wave, share, &frame->radiance,
                           &frame->cube_reflect.texels, log);
}

// The reflector's own outermost surface, by rays from beyond it.
static Status hull_draw(Frame *frame, const CubeInfo *cube, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  const CubeCapture *capture = &frame->cube_capture;
  const HitStream *hits = &frame->hits;
  RayStream *rays, *spare[2];
  float beyond_m = (float)(1.001 * (double)cube->reach_m + 1e-5 * frame->scene->extent_m);
  uint32_t tiles = CUBE_TEXELS(cube->size) / TILE_PIXELS;
  uint32_t wave_tiles = smaller(tiles, frame->capacity / TILE_PIXELS);
  memset(frame->taken, 0, sizeof frame->taken);
  TRY(stream_take(&rays, frame, true, log));
  for (int i = 0; i < 2; i++) TRY(stream_take(&spare[i], frame, true, log));
  for (uint32_t tile = 0; tile < tiles; tile += wave_tiles) {
    Wave wave = {tile, smaller(wave_tiles, tiles - tile), 0, 1};
    TRY(cube_capture_rays(capture, device, &wave, beyond_m, rays, log));
    TRY(cube_capture_trace(capture, &frame->tracer, device, frame->scene, true, rays, wave_rays(&wave), hits,
                           (RayStream[2]){*spare[0], *spare[1]}, log));
    TRY(cube_capture_keep_hull(capture, device, &wave, &frame->cube_reflect.hull, log));
  }

done:
  return status;
}

// Is raster the cheaper way to find what a cube sees?
static bool cube_by_raster(const Frame *frame, const CubeInfo *cube)
{
  const PrimaryFacts facts = {.triangles = frame->scene->triangle_count,
                              .pixels = CUBE_TEXELS((uint64_t)cube->size),
                              .samples = 1,
                              .gpu = device_info(frame->device)->is_gpu};
  PrimaryCost cost = primary_cost(&facts);
  return primary_choose(frame->request.plan.cubes.visibility, &cost) == PRIMARY_RASTER;
}

static uint32_t bits_count(uint32_t bits)
{
  uint32_t count = 0;
  for (; bits; bits &= bits - 1) count++;
  return count;
}

// Draws faces of the cube that the capture is aimed at: bit f of `faces`.
static Status faces_draw(Frame *frame, uint32_t size, uint32_t faces, uint32_t samples, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t face_tiles = size / TILE_SIZE * (size / TILE_SIZE);
  if (faces == CUBE_ALL_FACES) return capture_waves(frame, size, CUBE_FACES * size, samples, cube_keep, log);
  for (uint32_t face = 0; face < CUBE_FACES; face++)
    if (faces >> face & 1)
      TRY(capture_some_waves(frame, size, CUBE_FACES * size, face * face_tiles, face_tiles, samples, cube_keep, log));

done:
  return status;
}

Status cubes_draw(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const FrameRequest request = frame->request;
  const CameraInfo camera = frame->camera.info;
  const CubeInfo *cubes = frame->cubes_drawn.cubes;
  const uint32_t objects = frame->scene->object_count;
  CubeReflect maps = frame->cube_reflect;
  bool by_chance = request.plan.environment_light == ENVIRONMENT_LIGHT_SAMPLED ||
                   request.plan.environment_light == ENVIRONMENT_LIGHT_SH_AO ||
                   plan_uses_shadows(&request.plan, SHADOW_SET(SHADOWS_AREA)) || plan_samples_lobes(&request.plan);
  const bool marched = cubes_are_marched(&request.plan), lists = plan_uses_lists(&request.plan);
  const bool doubted = plan_uses_reflections(&request.plan, REFLECTIONS_HYBRID);
  const uint32_t samples = by_chance ? smaller(request.samples, CUBE_SAMPLES_MOST) : 1;
  CubeDoubt doubt = {0};
  CubePrefilter prefilter = {0};
  uint32_t *left_out = calloc((size_t)objects + 1, sizeof *left_out);
  if (!left_out) return log_no_memory(log, "cube maps");
  frame->capturing = true;
  frame->request.plan = plan_of_capture(&request.plan);
  frame->request.aovs = AOV_SET_NONE;
  frame->request.flat_background = false;
  frame->cube_reflect.cube_count = 0;  // none is whole yet
  TRY(cube_capture_make(&frame->cube_capture, frame->device, frame->scene, frame->capacity, log));
  if (request.plan.rough_by_maps)
    TRY(cube_prefilter_make(&prefilter, frame->device, frame->reflectors.greatest_px, log));
  if (doubted) TRY(cube_doubt_make(&doubt, frame->device, frame->capacity, frame->reflectors.greatest_px, log));
  for (uint32_t i = 0; i < frame->cubes_drawn.count; i++) {
    uint32_t faces = CUBE_ALL_FACES;
    if (!lists && !doubted) TRY(cube_take(&faces, frame, i, log));
    const bool taken = faces != CUBE_ALL_FACES;
    frame->reflectors.faces_kept += CUBE_FACES - bits_count(faces);
    if (!faces) continue;
    for (uint32_t object = 0; object < objects; object++) left_out[object] = object == cubes[i].object;
    near_objects_mark(&frame->near_objects, i, left_out);
    TRY(cube_capture_aim(&frame->cube_capture, frame->device, frame->scene, &cubes[i], frame->cubes_drawn.nears_m[i],
                         left_out, log));
    if (cube_by_raster(frame, &cubes[i]))
      TRY(cube_capture_raster(&frame->cube_capture, frame->device, frame->scene, &frame->raster_scene, left_out,
                              frame->capacity, log));
    TRY(faces_draw(frame, cubes[i].size, faces, samples, log));
    if (cubes[i].first_level != CUBE_NONE)
      TRY(cube_prefilter(&prefilter, frame->device, &cubes[i], &maps.texels, &maps.levels, log));
    if (doubted) TRY(cube_doubts_draw(frame, &doubt, &cubes[i], log));
    if (!marched) continue;
    TRY(cube_capture_cells(&frame->cube_capture, frame->device, cubes[i].size, &frame->cube_reflect.texels,
                           &frame->cube_reflect.cells, log));
    if (taken || lists || isinf(cubes[i].hull_least)) continue;  // with lists the reflector itself is traced
    for (uint32_t object = 0; object < objects; object++) left_out[object] = object != cubes[i].object;
    TRY(cube_capture_aim(&frame->cube_capture, frame->device, frame->scene, &cubes[i], 0, left_out, log));
    TRY(hull_draw(frame, &cubes[i], log));
  }
  if (lists) TRY(near_objects_draw(frame, cubes, samples, log));
  TRY(device_finish(frame->device, log));

done:
  cube_capture_free(&frame->cube_capture);
  cube_doubt_free(&doubt);
  cube_prefilter_free(&prefilter);
  frame->cube_reflect = maps;
  frame->camera.info = camera;
  frame->request = request;
  frame->capturing = false;
  free(left_out);
  return status;
}
