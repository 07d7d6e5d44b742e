#include "render/probe_render.h"

Status picture_shown(float *out, Frame *frame, const PictureOptions *options, Log *log)
{
  ResolveInfo resolve = picture_resolve_info(options, frame, frame->request.samples, true);
  return film_resolve(&frame->film, frame->device, &frame->film.sums, &resolve, out, log);
}

static Status pass_render(Frame *frame, const ProbeSet *probes, Log *log)
{
  Status status = STATUS_OK;
  if (probes->all) return frame_render(frame, log);
  for (uint32_t i = 0; i < probes->count; i++) {
    const Probe *probe = &probes->probes[i];
    TRY(frame_render_tile(frame, probe->x / PROBE_SIDE, probe->y / PROBE_SIDE, log));
  }

done:
  return status;
}

Status probes_render(const ProbePictures *out, Device *device, const DeviceScene *scene, const ProbeRender *render,
                     Log *log)
{
  Status status = STATUS_OK;
  Frame frame = {0};
  FrameRequest request = render->request;
  uint32_t seed = request.seed, passes = render->passes;
  if (out->lit) request.aovs |= AOV_SET_SHADOW;
  TRY(frame_make(&frame, device, scene, &request, log));
  for (uint32_t pass = 1; pass <= passes; pass++) {
    frame.request.seed = passes > 1 ? seed + pass : seed;
    frame.request.adds = pass > 1;
    TRY(pass_render(&frame, render->probes, log));
    float *to = pass == passes ? out->whole : pass == passes / 2 ? out->half : NULL;
    if (!to) continue;
    ResolveInfo resolve = picture_resolve_info(render->picture, &frame, frame.request.samples * pass, true);
    TRY(film_resolve(&frame.film, device, &frame.film.sums, &resolve, to, log));
  }
  if (out->lit) TRY(picture_lit_shares(out->lit, &frame, log));

done:
  frame_free(&frame);
  return status;
}
