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

// Who sees a cube.
typedef enum CubeSeen {
  SEEN_IN_MIRRORS,  // by the camera: its deep cube
  SEEN,             // its mirrors
  SEEN_ROUGH,       // its rough surfaces alone
} CubeSeen;

// What is drawn in a cube: one bounce less, or two in a deep one. In mirrors' cubes mirrors show their deep cubes, and
// nothing is traced; in others the environment. Hybrid reflections leave what mirrors show in theirs.
static Plan plan_of_capture(const Plan *plan, CubeSeen seen)
{
  Plan capture = *plan;
  const uint32_t less = seen == SEEN_IN_MIRRORS ? 2 : 1;
  const bool maps = reflections_use_maps(plan->deep_reflections), closed = plan_uses_deep_cubes(plan) && seen == SEEN;
  if (maps && !closed) capture.deep_reflections = REFLECTIONS_ENVIRONMENT;
  if (plan->reflections == REFLECTIONS_HYBRID) capture.deep_reflections = REFLECTIONS_NONE;
  if (maps || plan->rough_by_maps) capture.max_roughness = 0;
  capture.rough_by_maps = false;
  capture.reflections = capture.deep_reflections;
  capture.max_depth = plan->max_depth > less ? plan->max_depth - less : 0;
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

// What cubes are drawn with.
typedef struct CubePens {
  CubeDoubt doubt;
  CubePrefilter prefilter;
  uint32_t *left_out;  // [object_count]
  uint32_t samples;
  bool lists, marched, doubted;
  CubeChanges changes;
} CubePens;

// Leaves out one object, or all others.
static void left_out_set(const CubePens *pens, const Frame *frame, uint32_t object, bool others)
{
  for (uint32_t i = 0; i < frame->scene->object_count; i++) pens->left_out[i] = (i == object) != others;
}

static Status cube_draw(Frame *frame, uint32_t i, const CubePens *pens, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  CubeCapture *capture = &frame->cube_capture;
  const CubeReflect *maps = &frame->cube_reflect;
  const CubeInfo *cube = &frame->cubes_drawn.cubes[i];
  const bool doubted = pens->doubted && i < frame->cubes_drawn.order.first_deep;
  uint32_t faces = CUBE_ALL_FACES;
  if (!pens->lists && !pens->doubted) TRY(cube_take(&faces, frame, i, &pens->changes, log));
  frame->reflectors.faces_kept += CUBE_FACES - bits_count(faces);
  if (!faces) return STATUS_OK;
  left_out_set(pens, frame, cube->object, false);
  near_objects_mark(&frame->near_objects, i, pens->left_out);
  TRY(cube_capture_aim(capture, device, frame->scene, cube, frame->cubes_drawn.nears_m[i], pens->left_out, log));
  if (cube_by_raster(frame, cube))
    TRY(cube_capture_raster(capture, device, frame->scene, &frame->raster_scene, pens->left_out, frame->capacity, log));
  TRY(faces_draw(frame, cube->size, faces, pens->samples, log));
  if (cube->first_level != CUBE_NONE)
    TRY(cube_prefilter(&pens->prefilter, device, cube, &maps->texels, &maps->levels, log));
  if (doubted) TRY(cube_doubts_draw(frame, &pens->doubt, cube, log));
  if (!pens->marched) return STATUS_OK;
  TRY(cube_capture_cells(capture, device, cube->size, &maps->texels, &maps->cells, log));
  const bool taken = faces != CUBE_ALL_FACES;
  if (taken || pens->lists || isinf(cube->hull_least)) return STATUS_OK;  // with lists the reflector itself is traced
  left_out_set(pens, frame, cube->object, true);
  TRY(cube_capture_aim(capture, device, frame->scene, cube, 0, pens->left_out, log));
  TRY(hull_draw(frame, cube, log));

done:
  return status;
}

static Status pens_make(CubePens *out, Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const FrameRequest *request = &frame->request;
  const Plan *plan = &request->plan;
  const bool by_chance = plan->environment_light == ENVIRONMENT_LIGHT_SAMPLED ||
                         plan->environment_light == ENVIRONMENT_LIGHT_SH_AO ||
                         plan_uses_shadows(plan, SHADOW_SET(SHADOWS_AREA)) || plan_samples_lobes(plan);
  *out = (CubePens){.left_out = calloc((size_t)frame->scene->object_count + 1, sizeof *out->left_out),
                    .samples = by_chance ? smaller(request->samples, CUBE_SAMPLES_MOST) : 1,
                    .lists = plan_uses_lists(plan),
                    .marched = cubes_are_marched(plan),
                    .doubted = plan_uses_reflections(plan, REFLECTIONS_HYBRID)};
  if (!out->left_out) return log_no_memory(log, "cube maps");
  if (plan->rough_by_maps) TRY(cube_prefilter_make(&out->prefilter, frame->device, frame->reflectors.greatest_px, log));
  if (out->doubted)
    TRY(cube_doubt_make(&out->doubt, frame->device, frame->capacity, frame->reflectors.greatest_px, log));
  TRY(cube_changes_make(&out->changes, frame, log));

done:
  return status;
}

static void pens_free(CubePens *pens)
{
  cube_doubt_free(&pens->doubt);
  cube_prefilter_free(&pens->prefilter);
  cube_changes_free(&pens->changes);
  free(pens->left_out);
}

Status cubes_draw(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const FrameRequest request = frame->request;
  const CameraInfo camera = frame->camera.info;
  const CubeOrder *order = &frame->cubes_drawn.order;
  CubePens pens = {0};
  TRY(pens_make(&pens, frame, log));
  frame->capturing = true;
  frame->request.aovs = AOV_SET_NONE;
  frame->request.flat_background = false;
  TRY(cube_capture_make(&frame->cube_capture, frame->device, frame->scene, frame->capacity, log));
  const struct {
    CubeSeen seen;
    uint32_t first, end;
  } parts[] = {{SEEN_IN_MIRRORS, order->first_deep, order->count},
               {SEEN_ROUGH, order->mirrors, order->first_deep},
               {SEEN, 0, order->mirrors}};
  for (size_t part = 0; part < sizeof parts / sizeof *parts; part++) {
    frame->request.plan = plan_of_capture(&request.plan, parts[part].seen);
    for (uint32_t i = parts[part].first; i < parts[part].end; i++) TRY(cube_draw(frame, i, &pens, log));
  }
  if (pens.lists) TRY(near_objects_draw(frame, frame->cubes_drawn.cubes, pens.samples, log));
  TRY(device_finish(frame->device, log));
  frame->cube_reflect.looked_up = frame->cube_reflect.left = 0;

done:
  cube_capture_free(&frame->cube_capture);
  pens_free(&pens);
  frame->camera.info = camera;
  frame->request = request;
  frame->capturing = false;
  return status;
}
