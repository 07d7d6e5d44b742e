#include "render/compile_ahead.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#include "base/process.h"
#include "render/frame.h"
#include "shared/stream.h"

// What the process is told, by one of the same program.
typedef struct Request {
  char choice[256];  // empty: none
  DeviceScene features;
  Plan plan;
} Request;

static const char sentence[] = "compile";

static volatile pid_t process;  // 0: none
static int request_pipe;

Status compile_ahead_start(const char *choice, const DeviceScene *features, const Plan *plan)
{
  Request request;
  int ends[2];
  pid_t pid;
  char *arguments[] = {"frugal", COMPILE_AHEAD_COMMAND, NULL};
  memset(&request, 0, sizeof request);
  request.features = *features;
  request.plan = *plan;
  if (process || (choice && strlen(choice) >= sizeof request.choice)) return STATUS_USAGE;
  if (choice) strcpy(request.choice, choice);
  if (pipe2(ends, O_CLOEXEC) != 0) return STATUS_NO_MEMORY;
  // It fits into the pipe: nobody waits.
  bool started = write(ends[1], &request, sizeof request) == sizeof request &&
                 process_spawn(&pid, "/proc/self/exe", arguments, ends[0]) == 0;
  close(ends[0]);
  if (!started) {
    close(ends[1]);
    return STATUS_NO_MEMORY;
  }
  request_pipe = ends[1];
  process = pid;
  return STATUS_OK;
}

void compile_ahead_end(void)
{
  pid_t pid = process;
  if (!pid) return;
  process = 0;
  close(request_pipe);
  process_bury(pid);
}

void compile_ahead_kill(void)
{
  if (process) kill(-process, SIGKILL);
}

// Ends the process, and the linker that PoCL may just run, when the caller ends.
static void *caller_watch(void *input)
{
  char byte;
  while (read(*(int *)input, &byte, 1) > 0) continue;
  if (getpgrp() == getpid()) kill(0, SIGKILL);
  _exit(1);
}

static Status streams_make(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  TRY(ray_stream_make(&frame->streams[0], device, TILE_PIXELS, 1, "rays", log));
  TRY(ray_stream_make(&frame->shadow, device, TILE_PIXELS, 1, "shadow rays", log));
  TRY(hit_stream_make(&frame->hits, device, TILE_PIXELS, log));
  TRY(buffer_create(&frame->radiance, device, TILE_PIXELS * sizeof(Float4), NULL, "radiance", log));
  TRY(buffer_zero(device, &frame->streams[0].rays, log));
  TRY(buffer_zero(device, &frame->streams[0].slots, log));
  TRY(buffer_zero(device, &frame->shadow.rays, log));
  TRY(buffer_zero(device, &frame->shadow.slots, log));
  TRY(buffer_fill_words(device, &frame->hits.ids, HIT_NONE, log));

done:
  return status;
}

static Status film_compile(Frame *frame, const Wave *wave, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  float values[TILE_PIXELS][4];
  const ResolveInfo info = {.scale = 1, .coverage_scale = 1, .pixel_count = TILE_PIXELS};
  TRY(film_make(&frame->film, device, frame->scene, &frame->camera.info, false, NULL, log));
  TRY(film_resolve(&frame->film, device, &frame->film.sums, &info, values[0], log));
  // What the caller builds first, and is at now.
  TRY(camera_rays_make(&frame->camera, device, &frame->camera.info, 1, log));
  TRY(film_accumulate(&frame->film, device, &frame->camera, wave, &frame->radiance, &frame->film.sums, true, log));
  TRY(device_finish(device, log));

done:
  return status;
}

static Status trace_compile(Frame *frame, Coherence coherence, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  const Plan *plan = &frame->request.plan;
  const Tracer *tracer = &frame->tracer;
  // As a frame has it: reflected rays run side by side where none comes off a rough surface.
  bool reflected = plan->reflected_rays && (coherence == RAYS_INCOHERENT) == plan_samples_lobes(plan);
  bool camera = coherence == RAYS_COHERENT && (plan->primary == PRIMARY_RAYS || plan->transmitted_rays);
  if (reflected || camera)
    TRY(trace_closest(tracer, device, frame->scene, &frame->streams[0], TILE_PIXELS, 0, &frame->hits, coherence,
                      sentence, log));
  TRY(device_finish(device, log));
  if (plan->shadow_rays || plan->environment_light == ENVIRONMENT_LIGHT_SAMPLED)
    TRY(trace_any(tracer, device, frame->scene, &frame->shadow, 0, TILE_PIXELS, &frame->radiance, coherence, sentence,
                  log));
  TRY(device_finish(device, log));

done:
  return status;
}

static Status shade_compile(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  uint32_t counts[STREAM_COUNTS];
  const RayStream *none = &frame->shadow;
  const ShadeStreams streams = {.rays = &frame->streams[0],
                                .hits = &frame->hits,
                                .shadow = &frame->shadow,
                                .reflected = none,
                                .transmitted = none,
                                .radiance = &frame->radiance,
                                .camera = &frame->camera};
  const ShadeInfo info = {.tile_count = 1, .tiles_per_row = 1, .tile_rows = 1, .first_batch = 1, .primary = 1};
  TRY(buffer_fill_words(device, &frame->hits.ids, HIT_NONE, log));
  TRY(shader_make(&frame->shader, device, frame->scene, &frame->request.plan, log));
  TRY(shade(&frame->shader, device, frame->scene, &streams, TILE_PIXELS, &info, counts, sentence, log));
  TRY(device_finish(device, log));

done:
  return status;
}

static Status raster_compile(Frame *frame, const Wave *wave, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  const RasterOptions options = {0};
  TRY(raster_scene_make(&frame->raster_scene, device, frame->scene, &options, log));
  TRY(raster_visibility_make(&frame->raster, device, frame->scene, &options, log));
  TRY(raster_visibility_aim(&frame->raster, device, &frame->raster_scene, &frame->camera, 1, TILE_PIXELS, log));
  TRY(raster_visibility(&frame->raster, device, frame->scene, &frame->raster_scene, &frame->camera, wave, &frame->hits,
                        TILE_PIXELS, log));
  TRY(device_finish(device, log));

done:
  return status;
}

// Each kernel is waited for: a program built meanwhile would be one that the caller builds too.
static Status kernels_compile(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  Device *device = frame->device;
  const Plan *plan = &frame->request.plan;
  const Wave wave = {.tile_count = 1, .sample_count = 1};
  const Camera camera = {
      .kind = CAMERA_PERSPECTIVE, .yfov_rad = 1, .znear_m = 1, .zfar_m = 2, .world_from_camera = mat4_identity()};
  frame->camera.info = camera_info(&camera, &(PictureArea){8, 8, 0, 0, 8, 8});
  TRY(streams_make(frame, log));
  TRY(film_compile(frame, &wave, log));
  TRY(tracer_make(&frame->tracer, device, frame->scene, log));
  TRY(trace_compile(frame, RAYS_COHERENT, log));
  if (plan->lobes) TRY(trace_compile(frame, RAYS_INCOHERENT, log));
  TRY(shade_compile(frame, log));
  bool cubes = plan_uses_cubes(plan) && plan->cubes.visibility != PRIMARY_RAYS;
  if (plan->primary == PRIMARY_RASTER || cubes) TRY(raster_compile(frame, &wave, log));

done:
  return status;
}

Status compile_ahead_run(int input, Log *log)
{
  Status status = STATUS_OK;
  Request request;
  Device *device = NULL;
  DeviceScene scene = {0};
  Frame frame = {0};
  pthread_t watch;
  const Scene nothing = {.environment = {.kind = ENVIRONMENT_CONSTANT}};
  if (read(input, &request, sizeof request) != sizeof request)
    return log_fail(log, STATUS_USAGE,
                    COMPILE_AHEAD_COMMAND ": nothing to do: this program itself calls it, nobody else");
  if (pthread_create(&watch, NULL, caller_watch, &input)) return log_no_memory(log, COMPILE_AHEAD_COMMAND);
  TRY(device_open(&device, request.choice[0] ? request.choice : NULL, 1, NULL, log));
  DeviceTraits traits = *device_traits(device);
  traits.wide_bvh = request.plan.lobes;  // other frames seldom need what walks it
  device_override_traits(device, &traits);
  TRY(device_scene_make(&scene, device, &nothing, NULL, log));
  scene.has_textures = request.features.has_textures;
  scene.has_second_uvs = request.features.has_second_uvs;
  scene.has_normal_maps = request.features.has_normal_maps;
  scene.has_masks = request.features.has_masks;
  scene.has_blends = request.features.has_blends;
  scene.has_colors = request.features.has_colors;
  scene.has_shadowless = request.features.has_shadowless;
  frame.device = device;
  frame.scene = &scene;
  frame.request.plan = request.plan;
  TRY(kernels_compile(&frame, log));

done:
  frame_free(&frame);
  device_scene_free(&scene);
  device_close(device);
  return status;
}
