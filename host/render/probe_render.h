// A picture at probes alone: what `frugal render --verify` holds a picture to.
#pragma once

#include "plan/probes.h"
#include "render/picture.h"

// How probes are rendered.
typedef struct ProbeRender {
  FrameRequest request;
  uint32_t passes;  // the mean of that many pictures, each with a seed of its own; 1: with the request's seed
  const ProbeSet *probes;
  const PictureOptions *picture;
} ProbeRender;

// The frame's own picture as a display shows it; out: [height][width][4]. Errors: STATUS_DEVICE.
Status picture_shown(float *out, Frame *frame, const PictureOptions *options, Log *log);

// The request's picture as a display shows it, right in the probes' tiles and nowhere else; `half`: that of the first
// half of the passes, left alone where it is NULL or there is one pass. Both: [height][width][4]. Cost: about 0.4 ms a
// probe and pass more than its rays. Errors: those of frame_make and frame_render.
Status probes_render(float *out, float *half, Device *device, const DeviceScene *scene, const ProbeRender *render,
                     Log *log);
