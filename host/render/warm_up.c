#include "render/warm_up.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "render/frame.h"

struct WarmUp {
  pthread_t thread;
  pthread_mutex_t lock;
  pthread_cond_t changed;
  const char *choice;
  uint32_t threads;
  Timeline *timeline;
  Log log;
  // under the lock
  bool opened, taken, has_scene, ended;
  Status status;
  Device *device;
  DeviceScene features;
  Plan plan;
};

// A frame of a scene that is empty, but for what decides which kernels it takes. Failures show again when the real
// frame is made.
static void kernels_build(WarmUp *warm_up)
{
  Frame frame = {0};
  Camera camera = {
      .kind = CAMERA_PERSPECTIVE, .yfov_rad = 1, .znear_m = 1, .zfar_m = 2, .world_from_camera = mat4_identity()};
  FrameRequest request = {.camera = &camera, .area = {8, 8, 0, 0, 8, 8}, .samples = 1, .plan = warm_up->plan};
  if (frame_make(&frame, warm_up->device, &warm_up->features, &request, &warm_up->log) == STATUS_OK) frame_free(&frame);
}

static void *warm_up_run(void *argument)
{
  WarmUp *warm_up = argument;
  Device *device = NULL;
  Status status = device_open(&device, warm_up->choice, warm_up->threads, warm_up->timeline, &warm_up->log);
  pthread_mutex_lock(&warm_up->lock);
  warm_up->status = status;
  warm_up->device = device;
  warm_up->opened = true;
  pthread_cond_broadcast(&warm_up->changed);
  while (!warm_up->has_scene && !warm_up->ended) pthread_cond_wait(&warm_up->changed, &warm_up->lock);
  bool build = !status && warm_up->has_scene && !warm_up->ended;
  pthread_mutex_unlock(&warm_up->lock);
  if (build) kernels_build(warm_up);
  return NULL;
}

Status warm_up_start(WarmUp **out, const char *choice, uint32_t threads, Timeline *timeline, const Log *log)
{
  WarmUp *warm_up = calloc(1, sizeof *warm_up);
  if (!warm_up) return STATUS_NO_MEMORY;
  *warm_up = (WarmUp){
      .choice = choice, .threads = threads, .timeline = timeline, .log = {.sink = log->sink, .context = log->context}};
  pthread_mutex_init(&warm_up->lock, NULL);
  pthread_cond_init(&warm_up->changed, NULL);
  if (pthread_create(&warm_up->thread, NULL, warm_up_run, warm_up) != 0) {
    free(warm_up);
    return STATUS_NO_MEMORY;
  }
  *out = warm_up;
  return STATUS_OK;
}

void warm_up_scene(WarmUp *warm_up, const Scene *scene, const Plan *plan)
{
  pthread_mutex_lock(&warm_up->lock);
  device_scene_features(&warm_up->features, scene);
  warm_up->plan = *plan;
  warm_up->has_scene = true;
  pthread_cond_broadcast(&warm_up->changed);
  pthread_mutex_unlock(&warm_up->lock);
}

Status warm_up_device(Device **out, WarmUp *warm_up, Log *log)
{
  pthread_mutex_lock(&warm_up->lock);
  while (!warm_up->opened) pthread_cond_wait(&warm_up->changed, &warm_up->lock);
  Status status = warm_up->status;
  if (status)
    log_fail(log, status, "%s", warm_up->log.error);
  else
    *out = warm_up->device;
  warm_up->taken = !status;
  pthread_mutex_unlock(&warm_up->lock);
  return status;
}

void warm_up_end(WarmUp *warm_up)
{
  if (!warm_up) return;
  pthread_mutex_lock(&warm_up->lock);
  warm_up->ended = true;
  pthread_cond_broadcast(&warm_up->changed);
  pthread_mutex_unlock(&warm_up->lock);
  pthread_join(warm_up->thread, NULL);
  if (!warm_up->taken) device_close(warm_up->device);
  pthread_mutex_destroy(&warm_up->lock);
  pthread_cond_destroy(&warm_up->changed);
  free(warm_up);
}
