#include "render/warm_up.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/parallel.h"
#include "device/kernel_cache.h"
#include "render/compile_ahead.h"
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
  bool opened, taken, has_scene, built, ended;
  Status status;
  Device *device;
  DeviceScene features;
  Plan plan;
};

// A frame of a scene that is empty, but for what decides which kernels it takes. Failures show again when the real
// frame is made.
static void *kernels_build(void *argument)
{
  WarmUp *warm_up = argument;
  Frame frame = {0};
  Camera camera = {
      .kind = CAMERA_PERSPECTIVE, .yfov_rad = 1, .znear_m = 1, .zfar_m = 2, .world_from_camera = mat4_identity()};
  FrameRequest request = {.camera = &camera, .area = {8, 8, 0, 0, 8, 8}, .samples = 1, .plan = warm_up->plan};
  if (frame_make(&frame, warm_up->device, &warm_up->features, &request, &warm_up->log) == STATUS_OK) frame_free(&frame);
  pthread_mutex_lock(&warm_up->lock);
  warm_up->built = true;
  pthread_cond_broadcast(&warm_up->changed);
  pthread_mutex_unlock(&warm_up->lock);
  return NULL;
}

// Another process can compile beside this one, to its use.
static bool can_compile_ahead(const Device *device)
{
  const DeviceInfo *info = device_info(device);
  return info->is_pocl && !info->is_gpu && kernel_cache_is_kept() && parallel_threads() > 1;
}

// Waits until the kernels are built. Where that takes longer than from a cache, another process compiles too.
static void build_watch(WarmUp *warm_up, pthread_t builder)
{
  enum { CACHED_NS = 200000000, INTERVAL_NS = 10000000, SECOND_NS = 1000000000 };
  clockid_t clock;
  bool watch = can_compile_ahead(warm_up->device) && pthread_getcpuclockid(builder, &clock) == 0;
  pthread_mutex_lock(&warm_up->lock);
  while (!warm_up->built && watch) {
    struct timespec until, computed;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += INTERVAL_NS;
    until.tv_sec += until.tv_nsec / SECOND_NS;
    until.tv_nsec %= SECOND_NS;
    pthread_cond_timedwait(&warm_up->changed, &warm_up->lock, &until);
    watch = clock_gettime(clock, &computed) == 0 && computed.tv_sec == 0 && computed.tv_nsec < CACHED_NS;
    if (!watch && !warm_up->built &&
        compile_ahead_start(warm_up->choice, &warm_up->features, &warm_up->plan) == STATUS_OK)
      log_debug(&warm_up->log, "%s: compiling kernels in a second process too", device_info(warm_up->device)->name);
  }
  pthread_mutex_unlock(&warm_up->lock);
  pthread_join(builder, NULL);
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
  pthread_t builder;
  if (build && pthread_create(&builder, NULL, kernels_build, warm_up) == 0) build_watch(warm_up, builder);
  return NULL;
}

Status warm_up_start(WarmUp **out, const char *choice, uint32_t threads, Timeline *timeline, const Log *log)
{
  WarmUp *warm_up = calloc(1, sizeof *warm_up);
  if (!warm_up) return STATUS_NO_MEMORY;
  *warm_up = (WarmUp){
      .choice = choice, .threads = threads, .timeline = timeline, .log = {.sink = log->sink, .context = log->context}};
  pthread_mutex_init(&warm_up->lock, NULL);
  pthread_condattr_t monotonic;
  pthread_condattr_init(&monotonic);
  pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
  pthread_cond_init(&warm_up->changed, &monotonic);
  pthread_condattr_destroy(&monotonic);
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
  warm_up->plan.light_shadows = NULL;  // a frame without lights asks none
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
  compile_ahead_end();
  if (!warm_up->taken) device_close(warm_up->device);
  pthread_mutex_destroy(&warm_up->lock);
  pthread_cond_destroy(&warm_up->changed);
  free(warm_up);
}
