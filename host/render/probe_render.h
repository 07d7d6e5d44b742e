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

// Pictures that are right in the probes' tiles and nowhere else; what is NULL is left out.
typedef struct ProbePictures {
  float *whole,
      *half;   // [height][width][4], as a display shows them; half: of the first half of the passes, left alone
               // where there is one
  float *lit;  // [height][width], picture_lit_shares
} ProbePictures;

// The request's picture. Cost: about 0.4 ms a probe and pass more than its rays, twice that with `lit`. Errors: those
// of frame_make and frame_render.
Status probes_render(const ProbePictures *out, Device *device, const DeviceScene *scene, const ProbeRender *render,
                     Log *log);
