#include "render/shadow_receivers.h"

#include "shared/stream.h"

enum { PROBE_PX = 8 };

// What probes follow: no rays but those whose neighbours go the same way (hybrid shadows trace the others).
static FrameRequest probe_request(const FrameRequest *request)
{
  FrameRequest probing = *request;
  bool mirrors = request->plan.reflected_rays && !plan_samples_lobes(&request->plan);
  probing.samples = 1;
  probing.plan.primary = PRIMARY_RAYS;
  probing.aovs = AOV_SET_NONE;
  probing.plan.environment_light = ENVIRONMENT_LIGHT_NONE;
  probing.plan.reflected_rays = mirrors;
  probing.plan.reflections = probing.plan.deep_reflections = REFLECTIONS_RAYS;  // no map is there yet
  probing.plan.rough_by_maps = false;
  probing.plan.max_depth = mirrors ? 1 : 0;
  return probing;
}

static Status probes_mark(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const CameraInfo *camera = &frame->camera.info;
  uint32_t tiles = camera->tiles_per_row * ((camera->height + TILE_SIZE - 1) / TILE_SIZE);
  uint32_t wave_tiles = frame->capacity / TILE_PIXELS;
  for (uint32_t tile = 0; tile < tiles; tile += wave_tiles) {
    Wave wave = {tile, tiles - tile < wave_tiles ? tiles - tile : wave_tiles, 0, 1};
    TRY(frame_render_wave(frame, &wave, log));
  }

done:
  return status;
}

// Those of all samples of a picture.
static uint64_t picture_slots(const Frame *frame)
{
  const CameraInfo *camera = &frame->camera.info;
  uint64_t tiles = (uint64_t)camera->tiles_per_row * ((camera->height + TILE_SIZE - 1) / TILE_SIZE);
  return tiles * frame->camera.view_count * TILE_PIXELS * frame->request.samples;
}

Status shadow_receivers_prepare(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const FrameRequest request = frame->request;
  CameraRays picture = frame->camera;
  const ShadowReceivers receivers = {&picture.info, request.samples, PROBE_PX * PROBE_PX};
  ShadowHybrid *before = request.before ? &request.before->shadow_hybrid : NULL;
  if (shadow_hybrid_take(&frame->shadow_hybrid, frame->scene, &receivers, before))
    return shadow_hybrid_keep(&frame->shadow_hybrid, frame->device, picture_slots(frame), before, log);
  const uint64_t slots = picture_slots(frame);
  CameraInfo info = camera_info_blocks(&picture.info, PROBE_PX);
  frame->camera = (CameraRays){0};
  frame->marking = true;
  frame->request = probe_request(&request);
  TRY(camera_rays_make(&frame->camera, frame->device, &info, 1, log));
  if (frame->scene->triangle_count > 0) TRY(probes_mark(frame, log));  // a frame may be there for its programs alone
  TRY(shadow_hybrid_draw(&frame->shadow_hybrid, frame->device, frame->scene, &frame->raster_scene, &receivers, before,
                         log));
  TRY(shadow_hybrid_keep(&frame->shadow_hybrid, frame->device, slots, before, log));

done:
  camera_rays_free(&frame->camera);
  frame->camera = picture;
  frame->request = request;
  frame->marking = false;
  return status;
}
