#include "render/frame.h"

#include "shared/stream.h"

// Bounces whose rays still run side by side: camera rays and their mirror images.
enum { COHERENT_BOUNCES = 2 };

static const float least_weight = 1.0f / 255;

static uint32_t tiles_of(const PictureArea *area)
{
  return ((area->width + TILE_SIZE - 1) / TILE_SIZE) * ((area->height + TILE_SIZE - 1) / TILE_SIZE);
}

static Status aov_sums_make(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  size_t bytes = (size_t)frame->camera.info.width * frame->camera.info.height * sizeof(Float4);
  bool shadow = frame->request.aovs & AOV_SET_SHADOW, reflection = frame->request.aovs & AOV_SET_REFLECTION;
  DeviceBuffer *sums[] = {shadow ? &frame->own_sums : NULL, shadow ? &frame->unshadowed_sums : NULL,
                          shadow || reflection ? &frame->direct_sums : NULL};
  for (int i = 0; i < 3; i++) {
    if (!sums[i]) continue;
    TRY(buffer_create(sums[i], frame->device, bytes, NULL, "AOVs", log));
    TRY(buffer_zero(frame->device, sums[i], log));
  }

done:
  return status;
}

Status frame_make(Frame *out, Device *device, const DeviceScene *scene, const FrameRequest *request, Log *log)
{
  Status status = STATUS_OK;
  Frame frame = {.device = device, .scene = scene, .request = *request};
  uint64_t all = (uint64_t)tiles_of(&request->area) * TILE_PIXELS * request->samples;
  uint32_t capacity = device_traits(device)->wave_rays;
  if (all < capacity) capacity = (uint32_t)all;
  uint32_t segments = !request->plan.shadow_rays                   ? 0
                      : scene->light_count < LIGHTS_PER_LAUNCH ? scene->light_count
                                                                : LIGHTS_PER_LAUNCH;
  CameraInfo info = camera_info(request->camera, &request->area);
  TRY(camera_rays_make(&frame.camera, device, &info, request->samples, log));
  TRY(tracer_make(&frame.tracer, device, scene, log));
  TRY(shader_make(&frame.shader, device, scene, log));
  TRY(film_make(&frame.film, device, scene, &info, request->aovs & AOV_SET_SURFACE, log));
  TRY(ray_stream_make(&frame.streams[0], device, capacity, 1, "rays", log));
  TRY(ray_stream_make(&frame.streams[1], device, capacity, request->plan.reflected_rays, "reflected rays", log));
  TRY(ray_stream_make(&frame.shadow, device, capacity, segments, "shadow rays", log));
  TRY(hit_stream_make(&frame.hits, device, capacity, log));
  TRY(buffer_create(&frame.radiance, device, (size_t)capacity * sizeof(Float4), NULL, "radiance", log));
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
  tracer_free(&frame->tracer);
  shader_free(&frame->shader);
  film_free(&frame->film);
  ray_stream_free(&frame->streams[0]);
  ray_stream_free(&frame->streams[1]);
  ray_stream_free(&frame->shadow);
  hit_stream_free(&frame->hits);
  buffer_free(&frame->radiance);
  buffer_free(&frame->own_sums);
  buffer_free(&frame->unshadowed_sums);
  buffer_free(&frame->direct_sums);
  *frame = (Frame){0};
}

static ShadeInfo shade_info(const Frame *frame, uint32_t depth)
{
  const Plan *plan = &frame->request.plan;
  return (ShadeInfo){
      .model = plan->lighting == LIGHTING_PHONG ? LIGHTING_MODEL_PHONG : LIGHTING_MODEL_PBR,
      .first_batch = 1,
      .cast_shadows = plan->shadow_rays,
      .reflect = plan->reflected_rays && depth < plan->max_depth,
      .environment_lights = plan->environment_light,
      .ambient = plan->ambient,
      .min_weight = least_weight,
  };
}

// Shades a bounce by batches of lights, tracing each light's shadow rays in the lights' order. `*spawned` counts the
// reflected rays.
static Status bounce_shade(Frame *frame, const ShadeStreams *streams, uint32_t count, const ShadeInfo *info,
                           Coherence coherence, uint32_t *spawned, Log *log)
{
  Status status = STATUS_OK;
  ShadeInfo batch = *info;
  uint32_t lights = frame->scene->light_count, counts[STREAM_COUNTS];
  *spawned = 0;
  do {
    batch.light_count = lights - batch.first_light < LIGHTS_PER_LAUNCH ? lights - batch.first_light : LIGHTS_PER_LAUNCH;
    TRY(shade(&frame->shader, frame->device, frame->scene, streams, count, &batch, counts, "shade and spawn rays", log));
    for (uint32_t i = 0; i < batch.light_count; i++)
      TRY(trace_any(&frame->tracer, frame->device, frame->scene, streams->shadow, i, counts[i], streams->radiance, coherence,
                    "trace shadow rays", log));
    if (batch.first_batch) *spawned = counts[STREAM_COUNT_REFLECTED];
    batch.first_light += batch.light_count;
    batch.first_batch = batch.reflect = 0;
  } while (batch.first_light < lights);

done:
  return status;
}

// Direct light of the first hits without shadows, and what is there without any light: the shadow AOV is the quotient
// of what their differences lose.
static Status aov_shadow(Frame *frame, const ShadeStreams *streams, const Wave *wave, Log *log)
{
  Status status = STATUS_OK;
  uint32_t spawned = 0, unused[STREAM_COUNTS], rays = wave_rays(wave);
  ShadeInfo info = shade_info(frame, 0);
  info.reflect = info.cast_shadows = 0;
  TRY(buffer_zero(frame->device, &frame->radiance, log));
  TRY(shade(&frame->shader, frame->device, frame->scene, streams, rays, &info, unused, "shade without lights", log));
  TRY(film_accumulate(&frame->film, frame->device, &frame->camera, wave, &frame->radiance, &frame->own_sums, log));
  TRY(buffer_zero(frame->device, &frame->radiance, log));
  TRY(bounce_shade(frame, streams, rays, &info, RAYS_COHERENT, &spawned, log));
  TRY(film_accumulate(&frame->film, frame->device, &frame->camera, wave, &frame->radiance, &frame->unshadowed_sums, log));
  TRY(buffer_zero(frame->device, &frame->radiance, log));

done:
  return status;
}

static Status wave_render(Frame *frame, const Wave *wave, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  const FrameRequest *request = &frame->request;
  RayStream *arriving = &frame->streams[0], *spawned = &frame->streams[1];
  uint32_t count = wave_rays(wave);
  TRY(camera_rays_generate(&frame->camera, device, wave, arriving, log));
  TRY(buffer_zero(device, &frame->radiance, log));
  for (uint32_t depth = 0; count > 0; depth++) {
    Coherence coherence = depth < COHERENT_BOUNCES ? RAYS_COHERENT : RAYS_INCOHERENT;
    ShadeStreams streams = {arriving, &frame->hits, &frame->shadow, spawned, &frame->radiance};
    ShadeInfo info = shade_info(frame, depth);
    TRY(trace_closest(&frame->tracer, device, frame->scene, arriving, count, depth ? 0 : frame->camera.info.near_m, &frame->hits,
                      coherence, depth ? "trace reflected rays" : "trace camera rays", log));
    if (depth == 0 && request->aovs & AOV_SET_SURFACE)
      TRY(film_aov(&frame->film, device, frame->scene, &frame->camera, wave, arriving, &frame->hits, log));
    if (depth == 0 && request->aovs & AOV_SET_SHADOW) TRY(aov_shadow(frame, &streams, wave, log));
    TRY(bounce_shade(frame, &streams, count, &info, coherence, &count, log));
    if (depth == 0 && frame->direct_sums.memory)
      TRY(film_accumulate(&frame->film, device, &frame->camera, wave, &frame->radiance, &frame->direct_sums, log));
    RayStream *turn = arriving;
    arriving = spawned;
    spawned = turn;
  }
  TRY(film_accumulate(&frame->film, device, &frame->camera, wave, &frame->radiance, &frame->film.sums, log));
  TRY(device_finish(device, log));

done:
  return status;
}

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

Status frame_render(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const FrameRequest *request = &frame->request;
  uint32_t tiles = tiles_of(&request->area), samples = request->samples;
  uint32_t wave_tiles = smaller(tiles, frame->streams[0].capacity / TILE_PIXELS);
  uint32_t wave_samples = smaller(samples, frame->streams[0].capacity / (wave_tiles * TILE_PIXELS));
  double total = (double)tiles * samples, done_work = 0;
  for (uint32_t sample = 0; sample < samples; sample += wave_samples) {
    for (uint32_t tile = 0; tile < tiles; tile += wave_tiles) {
      Wave wave = {tile, smaller(wave_tiles, tiles - tile), sample, smaller(wave_samples, samples - sample)};
      TRY(wave_render(frame, &wave, log));
      done_work += (double)wave.tile_count * wave.sample_count;
      if (request->progress) request->progress(request->progress_context, done_work / total);
    }
  }

done:
  return status;
}
