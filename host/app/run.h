// A run of `frugal render`, and each picture of it.
#pragma once

#include "app/options.h"
#include "app/progress.h"
#include "app/verify.h"
#include "render/frame.h"
#include "render/reflection_bound.h"
#include "render/shadow_bound.h"
#include "render/warm_up.h"
#include "scene/gltf_motion.h"

// What all pictures share, freed in one place.
typedef struct Run {
  RenderOptions options;  // paths may name the frame
  Log *log;
  Timeline timeline;
  ImageHelper *images;
  Scene scene;
  uint8_t *light_shadows;  // [scene.light_count], where options.settings.light_shadows points; NULL: none
  GltfMotion *motion;      // NULL: the pose at rest alone is rendered
  Camera camera;           // in the pose at rest, or that sees all
  SequenceFacts sequence;
  WarmUp *warm_up;
  Device *device;
  DeviceScene device_scene;
  Progress progress;
  double begin_ms;
} Run;

// One picture.
typedef struct FrameJob {
  RenderOptions options;           // of this frame: its own paths
  char *output_path, *stats_path;  // what they point to
  Camera camera;
  Frame frame;
  SceneFacts facts;
  Plan plan;
  ShadowBound shadow_bound;
  ReflectionBound reflection_bound;
  VerifyResult verify;
  float exposure_ev;
  char *record;
  double begin_ms;
  size_t first_span;  // of the run's timeline
} FrameJob;

// The camera in the scene's pose: one of the scene may have moved; a view of all stays. Errors: those of
// scene_camera_choose.
Status run_camera(Camera *out, const Run *run);

// Renders and writes a picture of the device's scene as it is, and its --stats. `before` is the frame before in a
// sequence, or NULL (FrameRequest.before). On failure nothing half-written is left, and *out is to be freed too.
// Errors: STATUS_DEVICE, STATUS_OUTPUT, STATUS_NO_MEMORY and others of frame_make.
Status frame_job_render(FrameJob *out, Run *run, Frame *before);
void frame_job_free(FrameJob *job);
