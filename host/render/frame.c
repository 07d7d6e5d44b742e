#include "render/frame.h"

#include <string.h>

#include "render/bounce.h"
#include "render/reflectors.h"
#include "render/shadow_receivers.h"
#include "shared/raster.h"
#include "shared/stream.h"

// Work that is queued before the host waits for it, in tiles times samples: progress and interrupts come no finer, and
// each wait leaves the device idle for a moment.
enum { MOST_QUEUED_TILES = 4096 };

static uint32_t tiles_of(const CameraInfo *camera)
{
  return camera->tiles_per_row * ((camera->height + TILE_SIZE - 1) / TILE_SIZE);
}

// A capacity no less than that, whose fields lie apart in a cache: were they 4 KiB or a multiple of it from each other,
// one set of it would hold the same place of all.
static uint32_t capacity_apart(uint32_t capacity)
{
  enum { PAGE_FLOATS = 1024, SHIFT_FLOATS = TILE_PIXELS };
  return (capacity + PAGE_FLOATS - 1) / PAGE_FLOATS * PAGE_FLOATS + SHIFT_FLOATS;
}

const CameraRays *frame_camera(const Frame *frame)
{
  return frame->capturing && !frame->photographing ? &frame->cube_capture.views : &frame->camera;
}

static Status aov_sums_make(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  size_t bytes = (size_t)frame->camera.info.width * frame->camera.info.height * sizeof(Float4);
  bool shadow = frame->request.aovs & AOV_SET_SHADOW, reflection = frame->request.aovs & AOV_SET_REFLECTION;
  DeviceBuffer *sums[] = {shadow ? &frame->own_sums : NULL, shadow ? &frame->unshadowed_sums : NULL,
                          shadow ? &frame->lit_sums : NULL, reflection ? &frame->direct_sums : NULL};
  for (size_t i = 0; i < sizeof sums / sizeof *sums; i++) {
    if (!sums[i]) continue;
    TRY(buffer_create(sums[i], frame->device, bytes, NULL, "AOVs", log));
    TRY(buffer_zero(frame->device, sums[i], log));
  }

done:
  return status;
}

// The triangles for raster: those of the frame before where none moved.
static Status raster_scene_take(Frame *frame, Frame *before, Log *log)
{
  if (!before || frame->scene->mover_count || !before->raster_scene.blocks.memory)
    return raster_scene_make(&frame->raster_scene, frame->device, frame->scene, &(RasterOptions){0}, log);
  frame->raster_scene = before->raster_scene;
  before->raster_scene = (RasterScene){0};
  return STATUS_OK;
}

static Status raster_make(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const RasterOptions options = {0};
  const Plan *plan = &frame->request.plan;
  Frame *before = frame->request.before;
  bool raster = plan->primary == PRIMARY_RASTER, maps = plan_uses_shadow_maps(plan);
  bool cubes = plan_uses_cubes(plan) && plan->cubes.visibility != PRIMARY_RAYS;
  bool planar = plan->reflections == REFLECTIONS_PLANAR;
  if (raster || maps || cubes || planar || plan_uses_reflections(plan, REFLECTIONS_HYBRID))
    TRY(raster_scene_take(frame, before, log));
  TRY(shadow_maps_make(&frame->shadow_maps, frame->device, frame->scene, &frame->raster_scene, plan,
                       &frame->camera.info, before ? &before->shadow_maps : NULL, log));
  if (plan_uses_shadows(plan, SHADOW_SET(SHADOWS_HYBRID)))
    TRY(shadow_hybrid_make(&frame->shadow_hybrid, frame->device, frame->scene, plan, &frame->camera.info,
                           frame->capacity, frame->shadow_maps.bytes, log));
  if (!raster) goto done;
  TRY(raster_visibility_make(&frame->raster, frame->device, frame->scene, &options, log));
  TRY(raster_visibility_aim(&frame->raster, frame->device, &frame->raster_scene, &frame->camera, frame->request.samples,
                            frame->capacity, log));

done:
  return status;
}

ShadowMethod frame_light_shadows(const Frame *frame, uint32_t light)
{
  return plan_light_shadows(&frame->request.plan, light, frame->scene->light_infos[light].kind);
}

// Streams of shadow rays to the lights of a batch; none where maps answer for all of them.
static uint32_t light_segments(const Frame *frame)
{
  uint32_t lights = frame->scene->light_count, traced = 0;
  for (uint32_t i = 0; i < lights; i++)
    traced += frame_light_shadows(frame, i) != SHADOWS_NONE && !shadow_maps_have(&frame->shadow_maps, i);
  if (traced == 0) return 0;
  return lights < LIGHTS_PER_LAUNCH ? lights : LIGHTS_PER_LAUNCH;
}

// Long waves have fewer pauses between launches, short ones leave streams in the cache.
static uint32_t wave_capacity(const DeviceTraits *traits, const Plan *plan)
{
  return traits->wave_rays * (traits->lean_waves && !plan_sends_rays(plan) ? traits->lean_waves : 1);
}

Status frame_make(Frame *out, Device *device, const DeviceScene *scene, const FrameRequest *request, Log *log)
{
  Status status = STATUS_OK;
  Frame frame = {.device = device, .scene = scene, .request = *request};
  CameraInfo info = camera_info(request->camera, &request->area);
  if (request->doubt || request->sights) info = camera_info_blocks(&info, request->block_px);
  uint64_t all = (uint64_t)tiles_of(&info) * TILE_PIXELS * request->samples;
  const uint64_t cube_rays = CUBE_TEXELS(64);  // the fewest at a time with which a cube map is quick
  if (plan_uses_cubes(&request->plan) && all < cube_rays) all = cube_rays;
  frame.capacity = wave_capacity(device_traits(device), &request->plan);
  if (all < frame.capacity || request->sights) frame.capacity = (uint32_t)all;
  frame.capacity = capacity_apart(frame.capacity);
  TRY(camera_rays_make(&frame.camera, device, &info, request->samples, log));
  TRY(raster_make(&frame, log));
  frame.light_segments = light_segments(&frame);
  TRY(tracer_make(&frame.tracer, device, scene, log));
  TRY(shader_make(&frame.shader, device, scene, &request->plan, log));
  TRY(film_make(&frame.film, device, scene, &info, request->aovs & AOV_SET_SURFACE,
                request->before ? &request->before->film : NULL, log));
  bool spawns = request->plan.reflected_rays || request->plan.transmitted_rays;
  for (int i = 0; i < (spawns ? 2 : 1); i++)
    TRY(ray_stream_make(&frame.streams[i], device, frame.capacity, 1, "rays", log));
  TRY(ray_stream_make(&frame.no_rays, device, frame.capacity, 0, "rays", log));
  TRY(ray_stream_make(&frame.shadow, device, frame.capacity, frame.light_segments + frame.shader.environment_segments,
                      "shadow rays", log));
  TRY(hit_stream_make(&frame.hits, device, frame.capacity, log));
  TRY(buffer_create(&frame.radiance, device, (size_t)frame.capacity * sizeof(Float4), NULL, "radiance", log));
  TRY(aov_sums_make(&frame, log));
  if (plan_uses_shadows(&request->plan, SHADOW_SET(SHADOWS_HYBRID))) TRY(shadow_receivers_prepare(&frame, log));
  TRY(known_hits_make(&frame.known_hits, device, frame.capacity, plan_knows_hits(&request->plan), log));
  TRY(reflectors_prepare(&frame, log));
  frame.request.before = NULL;
  *out = frame;
  frame = (Frame){0};

done:
  frame_free(&frame);
  return status;
}

void frame_retire(Frame *frame)
{
  camera_rays_free(&frame->camera);
  raster_visibility_free(&frame->raster);
  known_hits_free(&frame->known_hits);
  planar_free(&frame->planar);
  cube_capture_free(&frame->cube_capture);
  snapshot_capture_free(&frame->snapshot_capture);
  tracer_free(&frame->tracer);
  shader_free(&frame->shader);
  for (int i = 0; i < FRAME_STREAMS; i++) ray_stream_free(&frame->streams[i]);
  ray_stream_free(&frame->no_rays);
  ray_stream_free(&frame->shadow);
  hit_stream_free(&frame->hits);
  DeviceBuffer *sums[] = {&frame->radiance, &frame->own_sums, &frame->unshadowed_sums, &frame->lit_sums,
                          &frame->direct_sums};
  for (size_t i = 0; i < sizeof sums / sizeof *sums; i++) buffer_free(sums[i]);
}

void frame_free(Frame *frame)
{
  frame_retire(frame);
  film_free(&frame->film);
  shadow_maps_free(&frame->shadow_maps);
  shadow_hybrid_free(&frame->shadow_hybrid);
  raster_scene_free(&frame->raster_scene);
  cube_reflect_free(&frame->cube_reflect);
  cube_record_free(&frame->cubes_drawn);
  hybrid_reflect_free(&frame->hybrid_reflect);
  near_objects_free(&frame->near_objects);
  near_reflect_free(&frame->near_reflect);
  *frame = (Frame){0};
}

// What is let through goes before what is reflected, so that all that camera rays see is there before the first
// reflection is; where many surfaces lie behind each other, so that streams run out, the other way round: then no more
// wait than there are reflections in a row.
Status frame_render_wave(Frame *frame, const Wave *wave, Log *log)
{
  Status status = STATUS_OK;
  Bounce waiting[FRAME_STREAMS], bounce = bounce_first(frame, wave);
  uint32_t waiting_count = 0;
  bool direct_pending = frame->request.aovs & AOV_SET_REFLECTION;
  memset(frame->taken, 0, sizeof frame->taken);
  TRY(stream_take(&bounce.rays, frame, !bounce.from_camera, log));
  if (frame->photographing)
    TRY(snapshot_capture_rays(&frame->snapshot_capture, frame->device, wave, bounce.rays, log));
  else if (!bounce.from_camera)
    TRY(camera_rays_generate(frame_camera(frame), frame->device, wave, bounce.rays, log));
  if (!bounce.from_camera) TRY(buffer_zero(frame->device, &frame->radiance, log));
  waiting[waiting_count++] = bounce;
  while (waiting_count > 0) {
    bounce = waiting[--waiting_count];
    if (direct_pending && bounce.depth > 0) {
      TRY(radiance_accumulate(frame, wave, &frame->direct_sums, log));
      direct_pending = false;
    }
    TRY(bounce_render(frame, wave, &bounce, waiting, &waiting_count, log));
  }
  if (direct_pending) TRY(radiance_accumulate(frame, wave, &frame->direct_sums, log));

done:
  return status;
}

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

static Status wave_add(Frame *frame, const Wave *wave, Log *log)
{
  Status status = STATUS_OK;
  ShadowDoubt *doubt = frame->request.doubt;
  if (doubt) {
    TRY(shadow_doubt_begin_wave(doubt, frame->device, wave->tile_count * TILE_PIXELS, wave->sample_count, log));
    doubt->showing = true;
    TRY(frame_render_wave(frame, wave, log));
    doubt->showing = false;
  }
  TRY(frame_render_wave(frame, wave, log));
  if (!bounce_fills_picture(frame, wave)) TRY(radiance_accumulate(frame, wave, &frame->film.sums, log));
  if (frame->request.sights)
    TRY(reflection_sights_light(frame->request.sights, frame->device, &frame->radiance, wave_rays(wave), log));
  if (doubt) shadow_doubt_end_wave(doubt);

done:
  return status;
}

uint32_t frame_wave_tiles(const Frame *frame, uint32_t tiles, uint32_t samples)
{
  uint32_t most = smaller(tiles, frame->capacity / TILE_PIXELS / samples);
  uint32_t row = frame_camera(frame)->info.tiles_per_row * BIN_TILES, bins = most > row ? row : BIN_TILES * BIN_TILES;
  return most > bins && most < tiles ? most - most % bins : most;
}

Status frame_render(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const FrameRequest *request = &frame->request;
  uint32_t tiles = tiles_of(&frame->camera.info), samples = request->samples;
  uint32_t together = request->doubt ? request->doubt->samples_a_probe : 1;  // in one wave
  uint32_t wave_tiles = frame_wave_tiles(frame, tiles, together);
  uint32_t wave_samples = smaller(samples, frame->capacity / (wave_tiles * TILE_PIXELS));
  if (wave_samples > together) wave_samples -= wave_samples % together;
  double total = (double)tiles * samples, done_work = 0, queued = 0;
  for (uint32_t sample = 0; sample < samples; sample += wave_samples) {
    for (uint32_t tile = 0; tile < tiles; tile += wave_tiles) {
      Wave wave = {tile, smaller(wave_tiles, tiles - tile), sample, smaller(wave_samples, samples - sample)};
      TRY(wave_add(frame, &wave, log));
      done_work += (double)wave.tile_count * wave.sample_count;
      if (done_work - queued < MOST_QUEUED_TILES && done_work < total) continue;
      TRY(device_finish(frame->device, log));
      queued = done_work;
      if (request->progress) request->progress(request->progress_context, done_work / total);
    }
  }

done:
  return status;
}

Status frame_render_tile(Frame *frame, uint32_t x, uint32_t y, Log *log)
{
  Status status = STATUS_OK;
  uint32_t tile = tile_number(&frame->camera.info, x, y);
  uint32_t samples = frame->request.samples, wave_samples = smaller(samples, frame->capacity / TILE_PIXELS);
  for (uint32_t sample = 0; sample < samples; sample += wave_samples) {
    Wave wave = {tile, 1, sample, smaller(wave_samples, samples - sample)};
    TRY(wave_add(frame, &wave, log));
  }
  TRY(device_finish(frame->device, log));

done:
  return status;
}
