// One step of all rays of a wave: trace, shade, spawn; and where what is spawned waits for its turn.
#pragma once

#include "render/frame.h"

// Rays that wait for their turn: camera rays, what a bounce reflected, or what BLEND surfaces let through.
typedef struct Bounce {
  RayStream *rays;
  uint32_t count;
  uint32_t depth;    // reflections so far
  bool first;        // nothing was hit before
  bool from_camera;  // there is no stream of the rays: the shader makes them from the camera
  bool reflected;    // just now: not let through since
  uint32_t known;    // rays besides, in frame->known_hits
  uint32_t path;     // hash of what happened so far: reflected, let through
} Bounce;

// The first bounce of a wave.
Bounce bounce_first(const Frame *frame, const Wave *wave);

// Is the picture's share of a wave done by one launch of shading, pixel by pixel? Its radiance is then in the sums.
bool bounce_fills_picture(const Frame *frame, const Wave *wave);

// A stream that is not in use; `no_rays` where none is wanted. Errors: STATUS_TOO_LARGE.
Status stream_take(RayStream **out, Frame *frame, bool wanted, Log *log);
void stream_give_back(Frame *frame, const RayStream *stream);

// Traces and shades one bounce, gives its stream back and adds what it spawned to `waiting`.
Status bounce_render(Frame *frame, const Wave *wave, const Bounce *bounce, Bounce waiting[FRAME_STREAMS],
                     uint32_t *waiting_count, Log *log);

// What shading is told of a bounce.
ShadeInfo bounce_shade_info(const Frame *frame, const Wave *wave, const Bounce *bounce);

// Shades rays [0, count) by batches of lights, in the lights' order, and traces what shadow rays that takes. counts: of
// what else was spawned.
Status bounce_shade(Frame *frame, const ShadeStreams *streams, uint32_t count, const ShadeInfo *info,
                    Coherence coherence, uint32_t counts[STREAM_COUNTS], Log *log);

// Adds the wave's radiance to sums like the film's.
Status radiance_accumulate(Frame *frame, const Wave *wave, const DeviceBuffer *sums, Log *log);
