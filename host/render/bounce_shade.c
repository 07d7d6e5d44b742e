// What a bounce's hits send back: shaded batch by batch of lights, with the rays that each of these spawns.
#include <string.h>

#include "render/bounce.h"

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

// `judged`: by shading, which on a CPU leaves nothing to tell.
static HybridTrust trust_of(const Frame *frame, bool judged, Coherence coherence)
{
  if (judged && device_traits(frame->device)->lanes > 1) return HYBRID_TRUST_TOLD;
  if (coherence == RAYS_COHERENT) return HYBRID_TRUST_ALL;
  return plan_samples_lobes(&frame->request.plan) ? HYBRID_TRUST_NONE : HYBRID_TRUST_DARK;
}

// Lets through what light `light` sends along the rays of segment `segment` past what stands in its way.
static Status shadows_resolve(Frame *frame, const ShadeStreams *streams, uint32_t light, uint32_t segment,
                              uint32_t count, bool judged, Coherence coherence, Log *log)
{
  if (count == 0) return STATUS_OK;
  ShadowDoubt *doubt = frame->request.doubt;
  if (doubt && shadow_maps_have(doubt->maps, light))
    return shadow_doubt_add(doubt, frame->device, frame->scene, light, streams->shadow, segment, count, log);
  if (doubt && !doubt->showing) return STATUS_OK;
  if (doubt)
    return trace_any(&frame->tracer, frame->device, frame->scene, streams->shadow, segment, count, &doubt->shown,
                     coherence, "trace shadow rays", log);
  if (frame->marking)
    return coherence == RAYS_COHERENT ? shadow_hybrid_mark(&frame->shadow_hybrid, frame->device, &frame->camera, light,
                                                           streams->shadow, segment, count, log)
                                      : STATUS_OK;
  if (shadow_hybrid_has(&frame->shadow_hybrid, light))
    return shadow_hybrid_trace(&frame->shadow_hybrid, &frame->tracer, frame->device, frame->scene, light,
                               streams->shadow, segment, count, streams->radiance, trust_of(frame, judged, coherence),
                               log);
  return trace_any(&frame->tracer, frame->device, frame->scene, streams->shadow, segment, count, streams->radiance,
                   coherence, "trace shadow rays", log);
}

// The batch's lights by what is done for them, of those that `info` leaves. Sums keep the order of lights, those whose
// light arrives in shading first: what maps judge arrives there too, but only behind all of these.
static void lights_sort(ShadeInfo *batch, const ShadeInfo *info, const Frame *frame)
{
  uint32_t casting = 0, judged = 0, area = 0;
  bool are_rays = true;  // of the lights from this one on
  for (uint32_t i = batch->light_count; i-- > 0;) {
    const ShadowMethod method = frame_light_shadows(frame, batch->first_light + i);
    if (method != SHADOWS_NONE) casting |= 1u << i;
    if (method == SHADOWS_AREA) area |= 1u << i;
    if (method == SHADOWS_HYBRID && are_rays) judged |= 1u << i;
    are_rays &= method == SHADOWS_RAYS || method == SHADOWS_HYBRID;
  }
  batch->casting_lights = casting & info->casting_lights;
  batch->judged_lights = judged & info->judged_lights;
  batch->area_lights = area & info->area_lights;
}

Status bounce_shade(Frame *frame, const ShadeStreams *streams, uint32_t count, const ShadeInfo *info,
                    Coherence coherence, uint32_t counts[STREAM_COUNTS], Log *log)
{
  Status status = STATUS_OK;
  ShadeInfo batch = *info;
  uint32_t lights = frame->scene->light_count, spawned[STREAM_COUNTS];
  do {
    batch.light_count = lights - batch.first_light < LIGHTS_PER_LAUNCH ? lights - batch.first_light : LIGHTS_PER_LAUNCH;
    lights_sort(&batch, info, frame);
    TRY(shade(&frame->shader, frame->device, frame->scene, streams, count, &batch, spawned, "shade and spawn rays",
              log));
    for (uint32_t i = 0; i < batch.light_count; i++)
      TRY(shadows_resolve(frame, streams, batch.first_light + i, i, spawned[i], batch.judged_lights >> i & 1, coherence,
                          log));
    frame->shadow_hybrid.rays += spawned[STREAM_COUNT_JUDGED] - spawned[STREAM_COUNT_WAITING];
    frame->shadow_hybrid.traced -= spawned[STREAM_COUNT_WAITING];
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
