#include "render/bounce.h"

#include <math.h>
#include <string.h>

#include "shared/stream.h"

// Bounces whose rays still run side by side: camera rays and their mirror images.
enum { COHERENT_BOUNCES = 2 };

enum { ALL_LIGHTS = (1 << LIGHTS_PER_LAUNCH) - 1 };

static const float least_weight = 1.0f / 255, least_transmitted = 1.0f / 65536;

// Reach of ambient occlusion, as a share of the diagonal of the scene's bounds.
static const double occlusion_reach = 0.1;

Status stream_take(RayStream **out, Frame *frame, bool wanted, Log *log)
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

void stream_give_back(Frame *frame, const RayStream *stream)
{
  if (stream != &frame->no_rays) frame->taken[stream - frame->streams] = false;
}

// From Jarzynski, Olano, "Hash Functions for GPU Rendering", JCGT 2020 (pcg).
static uint32_t hash_pcg(uint32_t x)
{
  uint32_t state = x * 747796405u + 2891336453u, word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
  return word >> 22 ^ word;
}

Bounce bounce_first(const Frame *frame, const Wave *wave)
{
  // Raster finds what they hit without a stream of them.
  bool by_raster = frame->request.plan.primary == PRIMARY_RASTER;
  if (frame->capturing) by_raster = frame->cube_capture.by_raster && !frame->photographing;
  return (Bounce){.count = wave_rays(wave),
                  .first = true,
                  .from_camera = by_raster && !(frame->request.aovs & AOV_SET_SURFACE),
                  .path = hash_pcg(frame->request.seed)};
}

// Are the hits of camera rays asked once, by a launch of shading for all lights?
static bool shades_once(const Frame *frame)
{
  const FrameRequest *request = &frame->request;
  return request->plan.primary == PRIMARY_RASTER && !(request->aovs & (AOV_SET_SURFACE | AOV_SET_SHADOW)) &&
         !frame->capturing && !frame->marking && !request->doubt && !request->sights && frame->camera.view_count == 1 &&
         frame->scene->light_count <= LIGHTS_PER_LAUNCH;
}

bool bounce_fills_picture(const Frame *frame, const Wave *wave)
{
  const Plan *plan = &frame->request.plan;
  const bool spawns = frame->light_segments > 0 || frame->shader.environment_segments > 0 || plan->reflected_rays ||
                      plan->transmitted_rays;
  return shades_once(frame) && !(frame->request.aovs & AOV_SET_REFLECTION) && wave->sample_count == 1 && !spawns;
}

static bool reads_keys(const Frame *frame, const Bounce *bounce)
{
  return bounce->from_camera && shades_once(frame) && frame->raster.way == RASTER_WAY_DIRECT;
}

// Does the film have samples of the wave's pixels?
static bool picture_begins(const Frame *frame, const Wave *wave)
{
  return wave->first_sample == 0 && !frame->request.adds;
}

// Where the radiance of a wave's camera rays goes.
static unsigned char goes_to(const Frame *frame, const Wave *wave)
{
  if (!bounce_fills_picture(frame, wave)) return SHADE_TO_SLOTS;
  return picture_begins(frame, wave) ? SHADE_BEGINS_PICTURE : SHADE_TO_PICTURE;
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

// What answers rays that have been reflected `depth` times: RAYS where the map's method has no map here.
static ReflectionMethod reflections_of(const Frame *frame, uint32_t depth)
{
  ReflectionMethod method = plan_reflections(&frame->request.plan, depth);
  if (method == REFLECTIONS_PLANAR && (depth > 1 || frame->planar.count == 0)) return REFLECTIONS_RAYS;
  const bool none = frame->cube_reflect.cube_count == 0 && !frame->capturing;
  return reflections_use_cubes(method) && none ? REFLECTIONS_RAYS : method;
}

static Coherence coherence_of(const Frame *frame, uint32_t depth)
{
  uint32_t coherent_bounces = plan_samples_lobes(&frame->request.plan) ? 1 : COHERENT_BOUNCES;
  return depth < coherent_bounces ? RAYS_COHERENT : RAYS_INCOHERENT;
}

// Is something asked that must know where rays start?
static bool reflections_ask(ReflectionMethod method)
{
  return reflections_use_maps(method) || method == REFLECTIONS_PLANAR;
}

// Up to what roughness maps answer for lobes that are reflected as the `depth`-th.
static float roughness_of_maps(const Frame *frame, uint32_t depth)
{
  const Plan *plan = &frame->request.plan;
  const ReflectionMethod method = reflections_of(frame, depth);
  const bool axes = frame->request.sights && frame->request.sights->axes;
  return plan->rough_by_maps && (axes || reflections_answer_lobes(method)) ? plan->max_roughness : 0;
}

ShadeInfo bounce_shade_info(const Frame *frame, const Wave *wave, const Bounce *bounce)
{
  const uint32_t depth = bounce->depth;
  const FrameRequest *request = &frame->request;
  const Plan *plan = &request->plan;
  const CameraInfo *camera = &frame_camera(frame)->info;
  const bool reflects = plan->reflected_rays && depth < plan->max_depth;
  const bool by_image = frame->shader.environment_table.bytes > 0;
  const bool judged = !frame->marking && coherence_of(frame, depth) == RAYS_COHERENT;
  return (ShadeInfo){
      .model = plan->lighting == LIGHTING_PHONG ? LIGHTING_MODEL_PHONG : LIGHTING_MODEL_PBR,
      .first_batch = 1,
      .casting_lights = ALL_LIGHTS,
      .judged_lights = judged ? ALL_LIGHTS : 0,
      .area_lights = ALL_LIGHTS,
      .reflect = reflects,
      .environment_light = environment_light_of(plan->environment_light),
      .ambient = plan->ambient,
      .min_weight = least_weight,
      .min_transmitted = least_transmitted,
      .primary = depth == 0,
      .from_camera = bounce->from_camera,
      .from_keys = reads_keys(frame, bounce),
      .to_picture = bounce->from_camera ? goes_to(frame, wave) : SHADE_TO_SLOTS,
      .flat_background = request->flat_background,
      .background = {request->background[0], request->background[1], request->background[2]},
      .max_roughness = plan_samples_lobes(plan) ? plan->max_roughness : 0,
      .occlusion_radius_m = (float)(occlusion_reach * frame->scene->extent_m),
      .environment_segment = frame->light_segments,
      .environment_open = frame->shader.environment_segments - 1,
      .environment_table = by_image,
      .random_key = bounce->path,
      .receivers = request->sights || reflections_ask(reflections_of(frame, depth + 1)),
      .map_roughness = roughness_of_maps(frame, depth + 1),
      .first_tile = wave->first_tile,
      .tile_count = wave->tile_count,
      .first_sample = wave->first_sample,
      .tiles_per_row = camera->tiles_per_row,
      .tile_rows = camera_tile_rows(frame_camera(frame)),
      .crop_x = camera->crop_x,
      .crop_y = camera->crop_y,
      .light_radius_m = plan->shadow_options.light_radius_m,
      .light_sine = (float)sin(plan->shadow_options.light_angle_rad),
  };
}

Status radiance_accumulate(Frame *frame, const Wave *wave, const DeviceBuffer *sums, Log *log)
{
  return film_accumulate(&frame->film, frame->device, &frame->camera, wave, &frame->radiance, sums,
                         picture_begins(frame, wave), log);
}

// Light of the first hits without lights, with them, and without their shadows, all of it without the environment's:
// the shadow AOV is the quotient of the differences.
static Status aov_shadow(Frame *frame, const ShadeStreams *streams, const Wave *wave, const Bounce *bounce, Log *log)
{
  Status status = STATUS_OK;
  uint32_t unused[STREAM_COUNTS], rays = wave_rays(wave);
  ShadeInfo info = bounce_shade_info(frame, wave, bounce), shadowed;
  info.reflect = info.environment_light = info.environment_table = 0;
  shadowed = info;
  info.casting_lights = 0;
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

// What the first rays of a wave hit: those of the camera, or of a cube map's faces.
static Status first_hits_find(Frame *frame, const Wave *wave, const Bounce *bounce, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  if (frame->photographing) {
    RayStream *spare = &frame->no_rays;
    TRY(stream_take(&spare, frame, true, log));
    TRY(snapshot_capture_trace(&frame->snapshot_capture, &frame->tracer, device, wave, bounce->rays, &frame->hits,
                               spare, &frame->near_reflect, log));
    stream_give_back(frame, spare);
    return STATUS_OK;
  }
  if (frame->capturing && frame->cube_capture.by_raster)
    return cube_capture_see(&frame->cube_capture, device, frame->scene, &frame->raster_scene, wave, &frame->hits,
                            frame->capacity, log);
  if (frame->capturing) {
    RayStream *spare[2] = {&frame->no_rays, &frame->no_rays};
    for (int i = 0; i < 2; i++) TRY(stream_take(&spare[i], frame, true, log));
    TRY(cube_capture_trace(&frame->cube_capture, &frame->tracer, device, frame->scene, false, bounce->rays,
                           bounce->count, &frame->hits, (RayStream[2]){*spare[0], *spare[1]}, log));
    for (int i = 0; i < 2; i++) stream_give_back(frame, spare[i]);
    return STATUS_OK;
  }
  if (frame->request.plan.primary == PRIMARY_RASTER)
    return raster_visibility(&frame->raster, device, frame->scene, &frame->raster_scene, &frame->camera, wave,
                             reads_keys(frame, bounce) ? NULL : &frame->hits, frame->capacity, log);
  return trace_closest(&frame->tracer, device, frame->scene, bounce->rays, bounce->count, frame->camera.info.near_m,
                       &frame->hits, RAYS_COHERENT, "trace camera rays", log);

done:
  return status;
}

// Lists hold what is near mirrors: cubes that hold all of it answer for rough surfaces first.
static Status lists_look_up(Frame *frame, ReflectionMethod method, Bounce *bounce, const RayStream *left,
                            LeftRays *counts, Log *log)
{
  Status status = STATUS_OK;
  const RayStream *asked = bounce->rays;
  uint32_t count = bounce->count;
  RayStream *mirrored = &frame->no_rays;
  if (frame->request.plan.rough_by_maps) {
    TRY(stream_take(&mirrored, frame, true, log));
    TRY(cube_reflect(&frame->cube_reflect, frame->device, frame->scene, method, ASK_FIRST, asked, bounce->count,
                     &frame->radiance, mirrored, &count, log));
    asked = mirrored;
  }
  if (count && frame->near_reflect.cube_count > 0)
    TRY(near_reflect(&frame->near_reflect, &frame->cube_reflect, frame->device, frame->scene, method,
                     bounce->depth > 1 ? least_weight : 0,
                     &(NearStreams){asked, left, &frame->known_hits, &frame->radiance}, count, counts, log));

done:
  stream_give_back(frame, mirrored);
  return status;
}

// Which cubes a bounce asks.
static CubeAsk ask_of(const Frame *frame, const Bounce *bounce)
{
  if (frame->capturing) return ASK_CLOSED;
  return bounce->depth > 1 && plan_uses_deep_cubes(&frame->request.plan) ? ASK_DEEP : ASK_FIRST;
}

// Answers reflected rays by maps, as far as the method for their depth has any; what is left takes the bounce's place.
static Status reflections_look_up(Frame *frame, const Wave *wave, Bounce *bounce, Log *log)
{
  Status status = STATUS_OK;
  ReflectionMethod method = reflections_of(frame, bounce->depth);
  LeftRays counts = {0};
  RayStream *left;
  if (!bounce->reflected || !reflections_ask(method)) return STATUS_OK;
  if (frame->request.sights && frame->request.sights->axes && bounce->depth == 1)
    TRY(reflection_sights_keep(frame->request.sights, frame->device, bounce->rays, bounce->count, NULL,
                               &frame->radiance, log));
  TRY(stream_take(&left, frame, true, log));
  if (method == REFLECTIONS_PLANAR)
    TRY(planar_reflect(&frame->planar, frame->device, frame->scene, wave, bounce->rays, bounce->count, left,
                       &frame->known_hits, &counts, log));
  else if (frame->near_reflect.cube_count > 0 && reflections_use_cubes(method))
    TRY(lists_look_up(frame, method, bounce, left, &counts, log));
  else if (method == REFLECTIONS_HYBRID)
    TRY(hybrid_reflect(&frame->hybrid_reflect, &frame->cube_reflect, frame->device, frame->scene, bounce->rays,
                       bounce->count, &frame->radiance, left, &frame->known_hits, &counts, log));
  else
    TRY(cube_reflect(&frame->cube_reflect, frame->device, frame->scene, method, ask_of(frame, bounce), bounce->rays,
                     bounce->count, &frame->radiance, left, &counts.traced, log));
  stream_give_back(frame, bounce->rays);
  bounce->rays = left;
  bounce->count = counts.traced;
  bounce->known = counts.known;

done:
  return status;
}

// Makes rays whose hits are known part of a bounce that is traced.
static Status known_hits_join(Frame *frame, Bounce *bounce, Log *log)
{
  LeftRays left = {bounce->count, bounce->known};
  bounce->count += bounce->known;
  bounce->known = 0;
  return known_hits_append(&frame->known_hits, frame->device, &left, bounce->rays, &frame->hits, log);
}

// What a bounce's rays hit, traced or known.
static Status hits_find(Frame *frame, const Wave *wave, Bounce *bounce, Coherence coherence, Log *log)
{
  Status status = STATUS_OK;
  if (bounce->first) return first_hits_find(frame, wave, bounce, log);
  if (bounce->count > 0)
    TRY(trace_closest(&frame->tracer, frame->device, frame->scene, bounce->rays, bounce->count, 0, &frame->hits,
                      coherence, bounce->depth ? "trace reflected rays" : "trace transmitted rays", log));
  if (frame->request.sights && !frame->request.sights->axes && bounce->reflected && bounce->depth == 1)
    TRY(reflection_sights_keep(frame->request.sights, frame->device, bounce->rays, bounce->count, &frame->hits,
                               &frame->radiance, log));
  TRY(known_hits_join(frame, bounce, log));

done:
  return status;
}

// Verdicts that shading may ask and leave: those of the picture's own camera rays.
static const KeptVerdicts *verdicts_of(const Frame *frame)
{
  const bool own = !frame->marking && !frame->request.doubt && frame_camera(frame) == &frame->camera;
  return own ? &frame->shadow_hybrid.verdicts : NULL;
}

Status bounce_render(Frame *frame, const Wave *wave, const Bounce *waited, Bounce waiting[FRAME_STREAMS],
                     uint32_t *waiting_count, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  const FrameRequest *request = &frame->request;
  Bounce own = *waited;
  const Bounce *bounce = &own;
  TRY(reflections_look_up(frame, wave, &own, log));
  if (bounce->count + bounce->known == 0) {
    stream_give_back(frame, bounce->rays);
    return STATUS_OK;
  }
  Coherence coherence = coherence_of(frame, bounce->depth);
  ShadeInfo info = bounce_shade_info(frame, wave, bounce);
  RayStream *reflected, *transmitted;
  TRY(stream_take(&reflected, frame, info.reflect, log));
  TRY(stream_take(&transmitted, frame, request->plan.transmitted_rays, log));
  ShadeStreams streams = {.rays = bounce->rays,
                          .hits = &frame->hits,
                          .shadow = &frame->shadow,
                          .reflected = reflected,
                          .transmitted = transmitted,
                          .radiance = info.to_picture ? &frame->film.sums : &frame->radiance,
                          .maps = &frame->shadow_maps,
                          .camera = frame_camera(frame),
                          .sure = &frame->shadow_hybrid.maps,
                          .keys = &frame->raster.keys,
                          .verdicts = verdicts_of(frame)};
  TRY(hits_find(frame, wave, &own, coherence, log));
  if (bounce->first && request->aovs & AOV_SET_SURFACE)
    TRY(film_aov(&frame->film, device, frame->scene, &frame->camera, wave, bounce->rays, &frame->hits, log));
  if (bounce->first && request->aovs & AOV_SET_SHADOW) TRY(aov_shadow(frame, &streams, wave, bounce, log));
  uint32_t counts[STREAM_COUNTS];
  TRY(bounce_shade(frame, &streams, bounce->count, &info, coherence, counts, log));
  stream_give_back(frame, bounce->rays);
  Bounce spawned[] = {{.rays = reflected,
                       .count = counts[STREAM_COUNT_REFLECTED],
                       .depth = bounce->depth + 1,
                       .reflected = true,
                       .path = hash_pcg(bounce->path + 1)},
                      {.rays = transmitted,
                       .count = counts[STREAM_COUNT_TRANSMITTED],
                       .depth = bounce->depth,
                       .path = hash_pcg(bounce->path + 2)}};
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
