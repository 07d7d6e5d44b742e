// frugal render: one picture of one scene, or the frames of its animation.

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "app/app.h"
#include "app/light_shadows.h"
#include "app/look_ahead.h"
#include "app/options.h"
#include "app/outputs.h"
#include "app/run.h"
#include "base/clock.h"
#include "base/parallel.h"
#include "report/profile.h"
#include "scene/gltf.h"
#include "scene/scene_defaults.h"

static Status environment_read(Run *run)
{
  const RenderOptions *options = &run->options;
  const EnvironmentSource *source = &options->environment;
  Environment *environment = &run->scene.environment;
  Status status = STATUS_OK;
  switch (source->choice) {
    case ENVIRONMENT_UNSET: TRY(scene_add_default_lighting(&run->scene, options->key_light, run->log)); break;
    case ENVIRONMENT_NONE: *environment = (Environment){.kind = ENVIRONMENT_CONSTANT}; break;
    case ENVIRONMENT_SKY: scene_set_sky(&run->scene); break;
    case ENVIRONMENT_COLOR:
      environment->kind = ENVIRONMENT_CONSTANT;
      memcpy(environment->constant, source->color, sizeof environment->constant);
      break;
    case ENVIRONMENT_FILE:
      TRY(image_read(&environment->image, run->images, IMAGE_RADIANCE, source->text, NULL, 0, run->log));
      environment->kind = ENVIRONMENT_IMAGE;
      break;
  }
  environment->intensity = options->environment_intensity;
  environment->rotation_rad = options->environment_rotation_rad;

done:
  return status;
}

// What compiles kernels ahead cannot know what will move.
static SequenceFacts sequence_guess(const RenderOptions *options)
{
  const FrameRange *range = &options->frames;
  const uint32_t frames = range->all ? (uint32_t)options->fps : (uint32_t)frames_count(range);
  return (SequenceFacts){.frames = frames, .kept = {1, 1, 1}};
}

// The images are not decoded yet: any may make a mirror or a rough surface.
static void structure_known(void *context, const Scene *scene)
{
  Run *run = context;
  EnvironmentChoice environment = run->options.environment.choice;
  PictureArea area = render_area(&run->options);
  const bool unlit = environment == ENVIRONMENT_UNSET && scene->light_count == 0;
  const bool has_sun = unlit && run->options.key_light;  // scene_add_default_lighting
  SceneFacts facts = {
      .light_count = scene->light_count + has_sun,
      .triangle_count = scene_triangle_count(scene),
      .pixel_count = (uint64_t)area.width * area.height,
      .has_mirrors = true,
      .sequence = sequence_guess(&run->options),
      .environment_lights = unlit || (environment != ENVIRONMENT_UNSET && environment != ENVIRONMENT_NONE)};
  facts.lights_by_kind[LIGHT_DIRECTIONAL] += has_sun;
  for (uint32_t i = 0; i < scene->light_count && scene->lights; i++) facts.lights_by_kind[scene->lights[i].kind]++;
  RenderSettings settings = run->options.settings;
  uint8_t *light_shadows = NULL;
  Log unheard = {0};  // what is wrong shows again when the scene is whole
  light_shadows_resolve(&light_shadows, &run->options, scene, &unheard);
  settings.light_shadows = light_shadows;
  Plan plan = plan_make(&settings, &facts);
  if (run->warm_up) warm_up_scene(run->warm_up, scene, &plan);
  free(light_shadows);
}

// A view of all holds the scene wherever its animation takes it.
static Status camera_fit_motion(Run *run, double aspect)
{
  enum { POSES = 32 };
  Status status = STATUS_OK;
  Vec3 low = vec3(INFINITY, INFINITY, INFINITY), high = vec3_neg(low);
  for (int i = -1; i <= POSES; i++) {
    Vec3 pose_low = low, pose_high = high;
    if (i >= 0)
      TRY(gltf_motion_pose(run->motion, &run->scene, gltf_motion_length_s(run->motion) * i / POSES, run->log));
    if (!scene_bounds(&run->scene, &pose_low, &pose_high)) continue;
    low = vec3_min(low, pose_low);
    high = vec3_max(high, pose_high);
  }
  if (vec3_is_finite(vec3_sub(high, low))) scene_camera_fit(&run->camera, low, high, aspect);

done:
  return status;
}

static Status scene_read(Run *run)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &run->options;
  GltfOptions gltf = {.scene = NONE,
                      .allow_outside = options->allow_outside,
                      .max_memory_bytes = options->max_memory_bytes,
                      .changes = options->scene_file.document ? &options->scene_file : NULL,
                      .structure_known = structure_known,
                      .context = run};
  double begin_ms = clock_ms();
  if (options->frames.given)
    TRY(gltf_motion_open(&run->motion, &run->scene, options->gltf_path, &gltf, options->animation, run->images,
                         run->log));
  else
    TRY(gltf_read(&run->scene, options->gltf_path, &gltf, run->images, run->log));
  if (options->list_cameras) goto done;
  if (scene_triangle_count(&run->scene) == 0) {
    status = log_fail(run->log, STATUS_BAD_SCENE,
                      "%s: draws no triangle: there is nothing to render: choose another scene", options->scene_path);
    goto done;
  }
  TRY(environment_read(run));
  TRY(light_shadows_resolve(&run->light_shadows, options, &run->scene, run->log));
  run->options.settings.light_shadows = run->light_shadows;
  double aspect = (double)options->settings.width / options->settings.height;
  TRY(scene_camera_choose(&run->camera, &run->scene, options->camera, aspect, run->log));
  if (run->motion && !run->camera.name) TRY(camera_fit_motion(run, aspect));
  timeline_end(&run->timeline, "read the scene", begin_ms);

done:
  return status;
}

static void cameras_print(const Scene *scene)
{
  for (uint32_t i = 0; i < scene->camera_count; i++) {
    const Camera *camera = &scene->cameras[i];
    char name[256];
    app_text(name, sizeof name, camera->name);
    if (camera->kind == CAMERA_PERSPECTIVE)
      printf("%u\t%s\tperspective, %.4g degrees high\n", i, name, camera->yfov_rad * 180 / M_PI);
    else
      printf("%u\t%s\torthographic, %.4g high\n", i, name, 2 * camera->ymag_m);
  }
  printf("fit\t\ta view of the whole scene\n");
}

// Address space that an OpenCL runtime takes for itself: measured with PoCL 3.1 and LLVM 15, on 2 threads.
static uint64_t runtime_bytes(void) { return (512 + 72 * (uint64_t)parallel_threads()) << 20; }

// Refuses a picture that would not fit before anything is allocated for it. PoCL does not survive a failed allocation.
static Status memory_check(const RenderOptions *options, Log *log)
{
  PictureArea area = render_area(options);
  uint64_t bytes = picture_memory_bytes(&area, options->picture.aovs);
  if (options->verify.all || options->verify.pixels)
    bytes += picture_memory_bytes(&area, 0) * 3 / 2;  // one more picture, in three states
  struct rlimit space = {RLIM_INFINITY, RLIM_INFINITY};
  getrlimit(RLIMIT_AS, &space);
  if (bytes > options->max_memory_bytes || (uint64_t)area.width * area.height > INT32_MAX)
    return log_fail(log, STATUS_TOO_LARGE,
                    "%ux%u pixels: need %.1f GB, with --max-memory at %.1f: use a smaller --size or --crop", area.width,
                    area.height, 1e-9 * (double)bytes, 1e-9 * (double)options->max_memory_bytes);
  if (space.rlim_cur != RLIM_INFINITY && bytes + runtime_bytes() > space.rlim_cur)
    return log_fail(
        log, STATUS_TOO_LARGE,
        "%ux%u pixels: need %.2f GB with OpenCL, where ulimit -v allows %.2f: raise it, or use a smaller --size",
        area.width, area.height, 1e-9 * (double)(bytes + runtime_bytes()), 1e-9 * (double)space.rlim_cur);
  return STATUS_OK;
}

static void run_free(Run *run)
{
  device_scene_free(&run->device_scene);
  warm_up_end(run->warm_up);
  device_close(run->device);
  gltf_motion_close(run->motion);
  scene_free(&run->scene);
  image_helper_stop(run->images);
  timeline_free(&run->timeline);
  free(run->light_shadows);
  render_options_free(&run->options);
}

static Status device_warm_up(Run *run)
{
  const RenderOptions *options = &run->options;
  bool timed = options->profile || options->stats_path || options->trace_path;
  return warm_up_start(&run->warm_up, options->device, options->threads, timed ? &run->timeline : NULL, run->log);
}

static Status device_prepare(Run *run)
{
  Status status = STATUS_OK;
  double begin_ms = clock_ms();
  TRY(warm_up_device(&run->device, run->warm_up, run->log));
  timeline_end(&run->timeline, "wait for the device", begin_ms);
  const DeviceInfo *device = device_info(run->device);
  log_debug(run->log, "%s: on %s, %s, driver %s", run->options.output_path, device->name, device->platform,
            device->driver);
  TRY((run->motion ? device_scene_make_movable : device_scene_make)(&run->device_scene, run->device, &run->scene,
                                                                    &run->timeline, run->log));

done:
  return status;
}

static Status scene_pose(Run *run, uint32_t frame)
{
  Status status = STATUS_OK;
  double begin_ms = clock_ms();
  TRY(gltf_motion_pose(run->motion, &run->scene, frame / (double)run->options.fps, run->log));
  timeline_end(&run->timeline, "pose the scene", begin_ms);
  TRY(device_scene_move(&run->device_scene, run->device, &run->timeline, run->log));

done:
  return status;
}

static Status frame_paths(FrameJob *job, const RenderOptions *options, uint32_t number, Log *log)
{
  Status status = STATUS_OK;
  job->options = *options;
  if (!options->frames.given) return STATUS_OK;
  TRY(path_of_frame(&job->output_path, options->output_path, number, log));
  TRY(path_of_frame(&job->stats_path, options->stats_path, number, log));
  job->options.frames.first = job->options.frames.last = number;
  job->options.output_path = job->output_path;
  job->options.stats_path = job->stats_path;

done:
  return status;
}

// Of the frame before there is what the next may take.
static Status pictures_render(Run *run)
{
  Status status = STATUS_OK;
  const FrameRange *range = &run->options.frames;
  FrameJob job = {0}, before = {0};
  for (uint64_t i = 0; i < run->progress.pictures; i++) {
    job.begin_ms = i == 0 ? run->begin_ms : clock_ms();
    job.first_span = i == 0 ? 0 : run->timeline.count;
    TRY(frame_paths(&job, &run->options, range->first + (uint32_t)i * range->step, run->log));
    if (run->motion) TRY(scene_pose(run, job.options.frames.first));
    TRY(frame_job_render(&job, run, i == 0 ? NULL : &before.frame));
    run->progress.done++;
    frame_job_free(&before);
    before = job;
    frame_retire(&before.frame);
    job = (FrameJob){0};
  }

done:
  progress_end(&run->progress);
  frame_job_free(&job);
  frame_job_free(&before);
  return status;
}

// Settles how many frames there are, and that each one's outputs can be written.
static Status frames_settle(Run *run)
{
  Status status = STATUS_OK;
  FrameRange *range = &run->options.frames;
  if (range->all) range->last = frames_last(gltf_motion_length_s(run->motion), (double)run->options.fps);
  run->progress.pictures = frames_count(range);
  if (run->progress.pictures > FRAMES_MOST)
    return log_fail(run->log, STATUS_USAGE, "--frames: %" PRIu64 " frames are over %d: render them in parts",
                    run->progress.pictures, FRAMES_MOST);
  for (uint64_t i = 0; i < run->progress.pictures && !status; i++) {
    FrameJob job = {0};
    status = frame_paths(&job, &run->options, range->first + (uint32_t)i * range->step, run->log);
    if (!status) status = outputs_check(&job.options, run->log);
    frame_job_free(&job);
  }
  return status;
}

static Status reports_write(const Run *run)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &run->options;
  if (options->profile) profile_print(stderr, &run->timeline, clock_ms() - run->begin_ms);
  if (options->trace_path) TRY(profile_write_trace(options->trace_path, &run->timeline, run->log));

done:
  return status;
}

int app_render(int argc, char **argv)
{
  Status status = STATUS_OK;
  Run run = {.begin_ms = clock_ms()};
  const RenderOptions *options = &run.options;
  Log log = {.sink = app_log_sink, .context = &run.options.quiet};
  run.log = &log;
  TRY(render_options_parse(&run.options, argc, argv, &log));
  if (options->help) {
    command_line_help(&render_command_line, stdout);
    goto done;
  }
  if (options->verbose) log.sink = app_log_sink_verbose;
  run.progress = (Progress){options->progress, options->quiet, run.begin_ms, .tenths = -1};
  parallel_set_threads(options->threads);
  if (!options->list_cameras) TRY(memory_check(options, &log));
  if (!options->list_cameras && !options->frames.all) TRY(frames_settle(&run));
  TRY(image_helper_start(&run.images, options->max_image_pixels, &log));
  if (!options->list_cameras) TRY(device_warm_up(&run));
  TRY(scene_read(&run));
  if (options->list_cameras) {
    cameras_print(&run.scene);
    goto done;
  }
  if (options->frames.all) TRY(frames_settle(&run));
  TRY(look_ahead(&run));
  TRY(device_prepare(&run));
  TRY(pictures_render(&run));
  TRY(reports_write(&run));

done:
  run_free(&run);
  return status ? app_fail(&log, status) : app_end_output(0);
}
