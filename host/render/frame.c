#include "render/frame.h"

#include <math.h>
#include <string.h>

#include "shared/raster.h"
#include "shared/stream.h"

// Work that is queued before the host waits for it, in tiles times samples: progress and interrupts come no finer, and
// each wait leaves the device idle for a moment.
enum { MOST_QUEUED_TILES = 4096 };

// Bounces whose rays still run side by side: camera rays and their mirror images.
enum { COHERENT_BOUNCES = 2 };

static const float least_weight = 1.0f / 255, least_transmitted = 1.0f / 65536;

// Reach of ambient occlusion, as a share of the diagonal of the scene's bounds.
static const double occlusion_reach = 0.1;

static uint32_t tiles_of(const PictureArea *area)
{
  return ((area->width + TILE_SIZE - 1) / TILE_SIZE) * ((area->height + TILE_SIZE - 1) / TILE_SIZE);
}

// A capacity no less than that, whose fields lie apart in a cache: were they 4 KiB or a multiple of it from each other,
// one set of it would hold the same place of all.
static uint32_t capacity_apart(uint32_t capacity)
{
  enum { PAGE_FLOATS = 1024, SHIFT_FLOATS = TILE_PIXELS };
  return (capacity + PAGE_FLOATS - 1) / PAGE_FLOATS * PAGE_FLOATS + SHIFT_FLOATS;
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

// A stream that is not in use; `no_rays` where none is wanted.
static Status stream_take(RayStream **out, Frame *frame, bool wanted, Log *log)
{
  *out = &frame->no_rays;
  if (!wanted) return STATUS_OK;
  uint32_t at = 0;
  while (at < FRAME_STREAMS && frame->taken[at]) at++;
  if (at == FRAME_STREAMS)
    return log_fail(log, STATUS_TOO_LARGE,
                    "frame: over %d streams of reflected rays wait behind BLEND surfaces: lower --max-depth",
                    FRAME_STREAMS);
  RayStream *stream = &frame->streams[at];
  Status status =
      stream->rays.memory ? STATUS_OK : ray_stream_make(stream, frame->device, frame->capacity, 1, "rays", log);
  if (status) return status;
  frame->taken[at] = true;
  *out = stream;
  return STATUS_OK;
}

static void stream_give_back(Frame *frame, const RayStream *stream)
{
  if (stream != &frame->no_rays) frame->taken[stream - frame->streams] = false;
}

static Status raster_make(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const RasterOptions options = {0};
  const Plan *plan = &frame->request.plan;
  bool raster = plan->primary == PRIMARY_RASTER, maps = plan_uses_shadow_maps(plan);
  if (raster || maps) TRY(raster_scene_make(&frame->raster_scene, frame->device, frame->scene, &options, log));
  TRY(shadow_maps_make(&frame->shadow_maps, frame->device, frame->scene, &frame->raster_scene, plan,
                       &frame->camera.info, log));
  if (plan->shadows == SHADOWS_HYBRID)
    TRY(shadow_hybrid_make(&frame->shadow_hybrid, frame->device, frame->scene, &frame->raster_scene, plan,
                           &frame->camera.info, frame->capacity, log));
  if (!raster) goto done;
  TRY(raster_visibility_make(&frame->raster, frame->device, frame->scene, &frame->raster_scene, &options, log));
  TRY(raster_visibility_aim(&frame->raster, frame->device, &frame->camera, frame->request.samples, frame->capacity,
                            log));

done:
  return status;
}

// Streams of shadow rays to the lights of a batch; none where maps answer for all of them.
static uint32_t light_segments(const Frame *frame)
{
  uint32_t lights = frame->scene->light_count, traced = 0;
  for (uint32_t i = 0; i < lights; i++) traced += !shadow_maps_have(&frame->shadow_maps, i);
  if (!frame->request.plan.shadow_rays || traced == 0) return 0;
  return lights < LIGHTS_PER_LAUNCH ? lights : LIGHTS_PER_LAUNCH;
}

Status frame_make(Frame *out, Device *device, const DeviceScene *scene, const FrameRequest *request, Log *log)
{
  Status status = STATUS_OK;
  Frame frame = {.device = device, .scene = scene, .request = *request};
  uint64_t all = (uint64_t)tiles_of(&request->area) * TILE_PIXELS * request->samples;
  frame.capacity = device_traits(device)->wave_rays;
  if (all < frame.capacity) frame.capacity = (uint32_t)all;
  frame.capacity = capacity_apart(frame.capacity);
  CameraInfo info = camera_info(request->camera, &request->area);
  TRY(camera_rays_make(&frame.camera, device, &info, request->samples, log));
  TRY(raster_make(&frame, log));
  frame.light_segments = light_segments(&frame);
  TRY(tracer_make(&frame.tracer, device, scene, log));
  TRY(shader_make(&frame.shader, device, scene, &request->plan, log));
  TRY(film_make(&frame.film, device, scene, &info, request->aovs & AOV_SET_SURFACE, log));
  bool spawns = request->plan.reflected_rays || request->plan.transmitted_rays;
  for (int i = 0; i < (spawns ? 2 : 1); i++)
    TRY(ray_stream_make(&frame.streams[i], device, frame.capacity, 1, "rays", log));
  TRY(ray_stream_make(&frame.no_rays, device, frame.capacity, 0, "rays", log));
  TRY(ray_stream_make(&frame.shadow, device, frame.capacity, frame.light_segments + frame.shader.environment_segments,
                      "shadow rays", log));
  TRY(hit_stream_make(&frame.hits, device, frame.capacity, log));
  TRY(buffer_create(&frame.radiance, device, (size_t)frame.capacity * sizeof(Float4), NULL, "radiance", log));
  TRY(aov_sums_make(&frame, log));
  *out = frame;
  frame = (Frame){0};

done:
  frame_free(&frame);
  return status;
}

void frame_free(Frame *frame)
{
  camera_rays_free(&frame->camera);
  raster_visibility_free(&frame->raster);
  shadow_maps_free(&frame->shadow_maps);
  shadow_hybrid_free(&frame->shadow_hybrid);
  raster_scene_free(&frame->raster_scene);
  tracer_free(&frame->tracer);
  shader_free(&frame->shader);
  film_free(&frame->film);
  for (int i = 0; i < FRAME_STREAMS; i++) ray_stream_free(&frame->streams[i]);
  ray_stream_free(&frame->no_rays);
  ray_stream_free(&frame->shadow);
  hit_stream_free(&frame->hits);
  buffer_free(&frame->radiance);
  buffer_free(&frame->own_sums);
  buffer_free(&frame->unshadowed_sums);
  buffer_free(&frame->lit_sums);
  buffer_free(&frame->direct_sums);
  *frame = (Frame){0};
}

// Rays that wait for their turn: camera rays, what a bounce reflected, or what BLEND surfaces let through.
typedef struct Bounce {
  RayStream *rays;
  uint32_t count;
  uint32_t depth;  // reflections so far
  bool first;      // nothing was hit before
  uint32_t path;   // hash of what happened so far: reflected, let through
} Bounce;

// From Jarzynski, Olano, "Hash Functions for GPU Rendering", JCGT 2020 (pcg).
static uint32_t hash_pcg(uint32_t x)
{
  uint32_t state = x * 747796405u + 2891336453u, word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
  return word >> 22 ^ word;
}

static uint32_t environment_light_of(EnvironmentLightMethod method)
{
  switch (method) {
    case ENVIRONMENT_LIGHT_AMBIENT: return ENVIRONMENT_BY_MEAN;
    case ENVIRONMENT_LIGHT_SH: return ENVIRONMENT_BY_HARMONICS;
    case ENVIRONMENT_LIGHT_SH_AO: return ENVIRONMENT_BY_OCCLUSION;
    case ENVIRONMENT_LIGHT_SAMPLED: return ENVIRONMENT_BY_SAMPLES;
    default: return ENVIRONMENT_BY_NOTHING;
  }
}

static ShadeInfo shade_info(const Frame *frame, const Wave *wave, uint32_t depth, uint32_t path)
{
  const FrameRequest *request = &frame->request;
  const Plan *plan = &request->plan;
  const CameraInfo *camera = &frame->camera.info;
  return (ShadeInfo){
      .model = plan->lighting == LIGHTING_PHONG ? LIGHTING_MODEL_PHONG : LIGHTING_MODEL_PBR,
      .first_batch = 1,
      .cast_shadows = plan->shadow_rays,
      .reflect = plan->reflected_rays &&
                 depth<plan->max_depth, .environment_light = environment_light_of(plan->environment_light),
                       .ambient = plan->ambient, .min_weight = least_weight, .min_transmitted = least_transmitted,
                       .primary = depth == 0, .flat_background = request->flat_background,
                       .background = {request->background[0], request->background[1], request->background[2]},
                       .max_roughness = plan->max_roughness,
                       .occlusion_radius_m = (float)(occlusion_reach * frame->scene->extent_m),
                       .environment_segment = frame->light_segments,
                       .environment_open = frame->shader.environment_segments - 1,
                       .environment_table = frame->shader.environment_table.bytes> 0,
      .random_key = path,
      .first_tile = wave->first_tile,
      .tile_count = wave->tile_count,
      .first_sample = wave->first_sample,
      .tiles_per_row = camera->tiles_per_row,
      .tile_rows = (camera->height + TILE_SIZE - 1) / TILE_SIZE,
      .crop_x = camera->crop_x,
      .crop_y = camera->crop_y,
      .light_radius_m = plan->shadow_options.light_radius_m,
      .light_sine = (float)sin(plan->shadow_options.light_angle_rad),
  };
}

// Sends the environment's light along the rays that a launch has spawned for it.
static Status environment_trace(Frame *frame, const ShadeStreams *streams, const uint32_t counts[STREAM_COUNTS],
                                Log *log)
{
  Status status = STATUS_OK;
  bool occlusion = frame->request.plan.environment_light == ENVIRONMENT_LIGHT_SH_AO;
  uint32_t segments = frame->shader.environment_segments;
  for (uint32_t i = 0; i < segments; i++) {
    bool open = i + 1 == segments && frame->shader.environment_open;
    TRY((open ? trace_open : trace_any)(&frame->tracer, frame->device, frame->scene, streams->shadow,
                                        frame->light_segments + i, counts[STREAM_COUNT_ENVIRONMENT + i],
                                        streams->radiance, RAYS_INCOHERENT,
                                        occlusion ? "trace ambient occlusion" : "trace environment light", log));
  }

done:
  return status;
}

// Lets through what light `light` sends along the rays of segment `segment` past what stands in its way.
static Status shadows_resolve(Frame *frame, const ShadeStreams *streams, uint32_t light, uint32_t segment,
                              uint32_t count, Coherence coherence, Log *log)
{
  if (count == 0) return STATUS_OK;
  if (shadow_hybrid_has(&frame->shadow_hybrid, light))
    return shadow_hybrid_trace(&frame->shadow_hybrid, &frame->tracer, frame->device, frame->scene, light,
                               streams->shadow, segment, count, streams->radiance, coherence, log);
  return trace_any(&frame->tracer, frame->device, frame->scene, streams->shadow, segment, count, streams->radiance,
                   coherence, "trace shadow rays", log);
}

// Shades a bounce by batches of lights, tracing each light's shadow rays in the lights' order. counts: what was
// spawned.
static Status bounce_shade(Frame *frame, const ShadeStreams *streams, uint32_t count, const ShadeInfo *info,
                           Coherence coherence, uint32_t counts[STREAM_COUNTS], Log *log)
{
  Status status = STATUS_OK;
  ShadeInfo batch = *info;
  uint32_t lights = frame->scene->light_count, spawned[STREAM_COUNTS];
  do {
    batch.light_count = lights - batch.first_light < LIGHTS_PER_LAUNCH ? lights - batch.first_light : LIGHTS_PER_LAUNCH;
    TRY(shade(&frame->shader, frame->device, frame->scene, streams, count, &batch, spawned, "shade and spawn rays",
              log));
    for (uint32_t i = 0; i < batch.light_count; i++)
      TRY(shadows_resolve(frame, streams, batch.first_light + i, i, spawned[i], coherence, log));
    if (batch.first_batch) {
      memcpy(counts, spawned, sizeof spawned);
      TRY(environment_trace(frame, streams, counts, log));
    }
    batch.first_light += batch.light_count;
    batch.first_batch = batch.reflect = 0;
  } while (batch.first_light < lights);

done:
  return status;
}

static Status radiance_accumulate(Frame *frame, const Wave *wave, const DeviceBuffer *sums, Log *log)
{
  return film_accumulate(&frame->film, frame->device, &frame->camera, wave, &frame->radiance, sums, log);
}

// Light of the first hits without lights, with them, and without their shadows, all of it without the environment's:
// the shadow AOV is the quotient of the differences.
static Status aov_shadow(Frame *frame, const ShadeStreams *streams, const Wave *wave, Log *log)
{
  Status status = STATUS_OK;
  uint32_t unused[STREAM_COUNTS], rays = wave_rays(wave);
  ShadeInfo info = shade_info(frame, wave, 0, 0), shadowed;
  info.reflect = info.environment_light = info.environment_table = 0;
  shadowed = info;
  info.cast_shadows = 0;
  TRY(buffer_zero(frame->device, &frame->radiance, log));
  TRY(shade(&frame->shader, frame->device, frame->scene, streams, rays, &info, unused, "shade without lights", log));
  TRY(radiance_accumulate(frame, wave, &frame->own_sums, log));
  TRY(buffer_zero(frame->device, &frame->radiance, log));
  TRY(bounce_shade(frame, streams, rays, &info, RAYS_COHERENT, unused, log));
  TRY(radiance_accumulate(frame, wave, &frame->unshadowed_sums, log));
  TRY(buffer_zero(frame->device, &frame->radiance, log));
  TRY(bounce_shade(frame, streams, rays, &shadowed, RAYS_COHERENT, unused, log));
  TRY(radiance_accumulate(frame, wave, &frame->lit_sums, log));
  TRY(buffer_zero(frame->device, &frame->radiance, log));

done:
  return status;
}

// Traces and shades one bounce, gives its stream back and adds what it spawned to `waiting`.
static Status bounce_render(Frame *frame, const Wave *wave, const Bounce *bounce, Bounce *waiting,
                            uint32_t *waiting_count, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  const FrameRequest *request = &frame->request;
  uint32_t coherent_bounces = request->plan.max_roughness > 0 ? 1 : COHERENT_BOUNCES;
  Coherence coherence = bounce->depth < coherent_bounces ? RAYS_COHERENT : RAYS_INCOHERENT;
  ShadeInfo info = shade_info(frame, wave, bounce->depth, bounce->path);
  RayStream *reflected, *transmitted;
  TRY(stream_take(&reflected, frame, info.reflect, log));
  TRY(stream_take(&transmitted, frame, request->plan.transmitted_rays, log));
  ShadeStreams streams = {bounce->rays, &frame->hits,     &frame->shadow,     reflected,
                          transmitted,  &frame->radiance, &frame->shadow_maps};
  if (bounce->first && request->plan.primary == PRIMARY_RASTER)
    TRY(raster_visibility(&frame->raster, device, frame->scene, &frame->raster_scene, &frame->camera, wave,
                          &frame->hits, frame->capacity, log));
  else
    TRY(trace_closest(&frame->tracer, device, frame->scene, bounce->rays, bounce->count,
                      bounce->first ? frame->camera.info.near_m : 0, &frame->hits, coherence,
                      bounce->first   ? "trace camera rays"
                      : bounce->depth ? "trace reflected rays"
                                      : "trace transmitted rays",
                      log));
  if (bounce->first && request->aovs & AOV_SET_SURFACE)
    TRY(film_aov(&frame->film, device, frame->scene, &frame->camera, wave, bounce->rays, &frame->hits, log));
  if (bounce->first && request->aovs & AOV_SET_SHADOW) TRY(aov_shadow(frame, &streams, wave, log));
  uint32_t counts[STREAM_COUNTS];
  TRY(bounce_shade(frame, &streams, bounce->count, &info, coherence, counts, log));
  stream_give_back(frame, bounce->rays);
  Bounce spawned[] = {
      {reflected, counts[STREAM_COUNT_REFLECTED], bounce->depth + 1, false, hash_pcg(bounce->path + 1)},
      {transmitted, counts[STREAM_COUNT_TRANSMITTED], bounce->depth, false, hash_pcg(bounce->path + 2)}};
  bool crowded = *waiting_count > FRAME_STREAMS / 2;
  for (int k = 0; k < 2; k++) {
    const Bounce *next = &spawned[crowded ? 1 - k : k];
    if (next->count)
      waiting[(*waiting_count)++] = *next;
    else
      stream_give_back(frame, next->rays);
  }

done:
  return status;
}

// What is let through goes before what is reflected, so that all that camera rays see is there before the first
// reflection is; where many surfaces lie behind each other, so that streams run out, the other way round: then no more
// wait than there are reflections in a row.
static Status wave_render(Frame *frame, const Wave *wave, Log *log)
{
  Status status = STATUS_OK;
  Bounce waiting[FRAME_STREAMS], bounce = {.count = wave_rays(wave), .first = true};
  bounce.path = hash_pcg(frame->request.seed);
  uint32_t waiting_count = 0;
  bool direct_pending = frame->request.aovs & AOV_SET_REFLECTION;
  memset(frame->taken, 0, sizeof frame->taken);
  TRY(stream_take(&bounce.rays, frame, true, log));
  TRY(camera_rays_generate(&frame->camera, frame->device, wave, bounce.rays, log));
  TRY(buffer_zero(frame->device, &frame->radiance, log));
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
  TRY(radiance_accumulate(frame, wave, &frame->film.sums, log));

done:
  return status;
}

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

Status frame_render(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const FrameRequest *request = &frame->request;
  uint32_t tiles = tiles_of(&request->area), samples = request->samples;
  uint32_t wave_tiles = smaller(tiles, frame->capacity / TILE_PIXELS);
  uint32_t bin_row = frame->camera.info.tiles_per_row * BIN_TILES,
           whole = wave_tiles > bin_row ? bin_row : BIN_TILES * BIN_TILES;
  if (wave_tiles > whole && wave_tiles < tiles) wave_tiles -= wave_tiles % whole;  // few bins in two waves
  uint32_t wave_samples = smaller(samples, frame->capacity / (wave_tiles * TILE_PIXELS));
  double total = (double)tiles * samples, done_work = 0, queued = 0;
  for (uint32_t sample = 0; sample < samples; sample += wave_samples) {
    for (uint32_t tile = 0; tile < tiles; tile += wave_tiles) {
      Wave wave = {tile, smaller(wave_tiles, tiles - tile), sample, smaller(wave_samples, samples - sample)};
      TRY(wave_render(frame, &wave, log));
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
