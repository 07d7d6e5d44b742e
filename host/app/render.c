// frugal render: one picture of one scene.

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "app/app.h"
#include "app/options.h"
#include "app/outputs.h"
#include "app/record.h"
#include "app/verify.h"
#include "base/clock.h"
#include "base/parallel.h"
#include "render/warm_up.h"
#include "report/profile.h"
#include "scene/gltf.h"
#include "scene/scene_defaults.h"

// Everything that one picture needs, freed in one place.
typedef struct Job {
  RenderOptions options;
  Log *log;
  Timeline timeline;
  ImageHelper *images;
  Scene scene;
  Camera camera;
  WarmUp *warm_up;
  Device *device;
  DeviceScene device_scene;
  Frame frame;
  SceneFacts facts;
  Plan plan;
  ShadowBound shadow_bound;
  ReflectionBound reflection_bound;
  VerifyResult verify;
  float exposure_ev;
  char *record;
  double begin_ms;
  double progress_ms;   // when the progress line was last drawn
  int progress_tenths;  // said last, where there is no terminal
  bool progress_shown;
} Job;

static void job_free(Job *job)
{
  shadow_bound_free(&job->shadow_bound);
  reflection_bound_free(&job->reflection_bound);
  frame_free(&job->frame);
  device_scene_free(&job->device_scene);
  warm_up_end(job->warm_up);
  device_close(job->device);
  scene_free(&job->scene);
  image_helper_stop(job->images);
  timeline_free(&job->timeline);
  free(job->record);
}

static bool verify_is_wanted(const RenderOptions *options) { return options->verify.all || options->verify.pixels; }

// A line on a terminal for anything over a second.
static void progress_draw(void *context, double share)
{
  Job *job = context;
  double now_ms = clock_ms();
  if (now_ms - job->begin_ms < 1000 || now_ms - job->progress_ms < 100) return;
  job->progress_ms = now_ms;
  job->progress_shown = true;
  fprintf(stderr, "\rfrugal: %3.0f %%", 100 * share);
}

// A line for each tenth of the work.
static void progress_print(void *context, double share)
{
  Job *job = context;
  int tenths = (int)(10 * share + 1e-9);
  if (tenths == job->progress_tenths) return;
  job->progress_tenths = tenths;
  fprintf(stderr, "frugal: %d %%\n", 10 * tenths);
}

static FrameProgress progress_choose(const RenderOptions *options)
{
  if (isatty(STDERR_FILENO)) return options->progress || !options->quiet ? progress_draw : NULL;
  return options->progress ? progress_print : NULL;
}

static Status environment_read(Job *job)
{
  const RenderOptions *options = &job->options;
  const EnvironmentSource *source = &options->environment;
  Environment *environment = &job->scene.environment;
  Status status = STATUS_OK;
  switch (source->choice) {
    case ENVIRONMENT_UNSET: TRY(scene_add_default_lighting(&job->scene, options->key_light, job->log)); break;
    case ENVIRONMENT_NONE: *environment = (Environment){.kind = ENVIRONMENT_CONSTANT}; break;
    case ENVIRONMENT_SKY: scene_set_sky(&job->scene); break;
    case ENVIRONMENT_COLOR:
      environment->kind = ENVIRONMENT_CONSTANT;
      memcpy(environment->constant, source->color, sizeof environment->constant);
      break;
    case ENVIRONMENT_FILE:
      TRY(image_read(&environment->image, job->images, IMAGE_RADIANCE, source->text, NULL, 0, job->log));
      environment->kind = ENVIRONMENT_IMAGE;
      break;
  }
  environment->intensity = options->environment_intensity;
  environment->rotation_rad = options->environment_rotation_rad;

done:
  return status;
}

// The images are not decoded yet: any may make a mirror or a rough surface.
static void structure_known(void *context, const Scene *scene)
{
  Job *job = context;
  EnvironmentChoice environment = job->options.environment.choice;
  PictureArea area = render_area(&job->options);
  SceneFacts facts = {.light_count = scene->light_count,
                      .triangle_count = scene_triangle_count(scene),
                      .pixel_count = (uint64_t)area.width * area.height,
                      .has_mirrors = true,
                      .environment_lights =
                          environment == ENVIRONMENT_UNSET ? scene->light_count == 0 : environment != ENVIRONMENT_NONE};
  for (uint32_t i = 0; i < scene->light_count && scene->lights; i++) facts.lights_by_kind[scene->lights[i].kind]++;
  Plan plan = plan_make(&job->options.settings, &facts);
  if (job->warm_up) warm_up_scene(job->warm_up, scene, &plan);
}

static Status scene_read(Job *job)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &job->options;
  GltfOptions gltf = {.scene = NONE,
                      .allow_outside = options->allow_outside,
                      .max_memory_bytes = options->max_memory_bytes,
                      .structure_known = structure_known,
                      .context = job};
  double begin_ms = clock_ms();
  TRY(gltf_read(&job->scene, options->scene_path, &gltf, job->images, job->log));
  if (options->list_cameras) goto done;
  if (scene_triangle_count(&job->scene) == 0) {
    status = log_fail(job->log, STATUS_BAD_SCENE,
                      "%s: draws no triangle: there is nothing to render: choose another scene", options->scene_path);
    goto done;
  }
  TRY(environment_read(job));
  double aspect = (double)options->settings.width / options->settings.height;
  TRY(scene_camera_choose(&job->camera, &job->scene, options->camera, aspect, job->log));
  timeline_end(&job->timeline, "read the scene", begin_ms);

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
  if (verify_is_wanted(options)) bytes += picture_memory_bytes(&area, 0) * 3 / 2;  // one more picture, in three states
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

// Says what maps may get wrong, before anything is rendered.
static Status errors_bound(Job *job)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &job->options;
  const bool known = !options->exposure.is_auto && options->picture.tone == TONE_CURVE_NONE;
  const float scale = known ? exp2f(options->exposure.ev) : INFINITY;
  double begin_ms = clock_ms();
  if (plan_uses_shadow_maps(&job->plan) && job->plan.shadows != SHADOWS_HYBRID) {
    TRY(shadow_bound_make(&job->shadow_bound, &job->frame, scale, job->log));
    timeline_end(&job->timeline, "bound the shadow maps' error", begin_ms);
  }
  begin_ms = clock_ms();
  if (reflections_use_maps(job->plan.reflections) || job->plan.reflections == REFLECTIONS_PLANAR) {
    TRY(reflection_bound_make(&job->reflection_bound, &job->frame,
                              options->exposure.is_auto ? 1 : exp2f(options->exposure.ev), job->log));
    timeline_end(&job->timeline, "bound the reflections' error", begin_ms);
  }

done:
  return status;
}

static Status frame_prepare(Job *job)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &job->options;
  PictureArea area = render_area(options);
  job->facts = (SceneFacts){.triangle_count = job->device_scene.triangle_count,
                            .pixel_count = (uint64_t)area.width * area.height,
                            .gpu = device_info(job->device)->is_gpu,
                            .light_count = job->device_scene.light_count,
                            .has_mirrors = job->device_scene.has_mirrors,
                            .has_blends = job->device_scene.has_blends,
                            .least_roughness = job->device_scene.least_roughness,
                            .environment_lights = job->device_scene.environment_lights};
  for (uint32_t i = 0; i < job->facts.light_count; i++)
    job->facts.lights_by_kind[job->device_scene.light_infos[i].kind]++;
  job->plan = plan_make(&options->settings, &job->facts);
  FrameRequest request = {
      .camera = &job->camera,
      .area = area,
      .samples = options->settings.samples,
      .plan = job->plan,
      .seed = options->seed,
      .aovs = aov_set_of(options->picture.aovs),
      .flat_background = options->background.kind != BACKGROUND_ENVIRONMENT,
      .exposure_ev = options->exposure.is_auto ? INFINITY : options->exposure.ev,
      .progress = progress_choose(options),
      .progress_context = job,
  };
  double begin_ms = clock_ms();
  TRY(frame_make(&job->frame, job->device, &job->device_scene, &request, job->log));
  timeline_end(&job->timeline, "prepare the frame", begin_ms);
  if (options->stats_path || verify_is_wanted(options)) TRY(errors_bound(job));

done:
  return status;
}

// What was said of the first reflection's rung before the picture was rendered; NULL: nothing.
static const BoundShare *reflections_stated(const Job *job)
{
  ReflectionMethod method = job->plan.reflections;
  bool is_stated = method >= REFLECTIONS_ENVIRONMENT && method < REFLECTIONS_RAYS;
  return is_stated ? &job->reflection_bound.rungs[method - REFLECTIONS_ENVIRONMENT] : NULL;
}

static Status picture_save(Job *job)
{
  Status status = STATUS_OK;
  RenderOptions *options = &job->options;
  job->exposure_ev = options->exposure.ev;
  if (options->exposure.is_auto) {
    TRY(picture_auto_exposure(&job->exposure_ev, &job->frame, job->log));
    log_info(job->log, "%s: --exposure %.2f, by auto", options->output_path, (double)job->exposure_ev);
  }
  TRY(record_make(&job->record, options, &job->plan, &job->camera, job->exposure_ev, device_info(job->device),
                  job->log));
  const ImageAttribute attributes[] = {{"Software", "Frugal " FRUGAL_VERSION}, {"ImageDescription", job->record}};
  PictureOptions picture = options->picture;
  picture.exposure_ev = job->exposure_ev;
  picture.attributes = attributes;
  picture.attribute_count = sizeof attributes / sizeof *attributes;
  TRY(picture_write(&job->frame, &picture, job->images, options->output_path, options->format, job->log));
  log_debug(job->log, "%s: written: %s", options->output_path, job->record);
  if (!verify_is_wanted(options)) goto done;
  double begin_ms = clock_ms();
  TRY(verify_picture(&job->verify, &(VerifySources){options, &job->facts, &job->frame, &picture}, job->log));
  verify_say(&job->verify, job->shadow_bound.lights ? &job->shadow_bound : NULL, reflections_stated(job),
             options->output_path, job->log);
  timeline_end(&job->timeline, "verify", begin_ms);

done:
  return status;
}

static Status device_warm_up(Job *job)
{
  const RenderOptions *options = &job->options;
  bool timed = options->profile || options->stats_path || options->trace_path;
  return warm_up_start(&job->warm_up, options->device, options->threads, timed ? &job->timeline : NULL, job->log);
}

static Status picture_render(Job *job)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &job->options;
  double begin_ms = clock_ms();
  TRY(warm_up_device(&job->device, job->warm_up, job->log));
  timeline_end(&job->timeline, "wait for the device", begin_ms);
  const DeviceInfo *device = device_info(job->device);
  log_debug(job->log, "%s: on %s, %s, driver %s", options->output_path, device->name, device->platform, device->driver);
  TRY(device_scene_make(&job->device_scene, job->device, &job->scene, &job->timeline, job->log));
  TRY(frame_prepare(job));
  log_debug(job->log, "%s: %u triangles, %u objects, %u lights; shadows %s, reflections %s", options->scene_path,
            job->device_scene.triangle_count, job->device_scene.object_count, job->device_scene.light_count,
            job->plan.shadow_rays ? "by rays" : "not needed",
            !job->plan.reflected_rays                   ? "not needed"
            : job->plan.reflections == REFLECTIONS_RAYS ? "by rays"
                                                        : "by maps");
  begin_ms = clock_ms();
  TRY(frame_render(&job->frame, job->log));
  timeline_end(&job->timeline, "render", begin_ms);
  begin_ms = clock_ms();
  TRY(picture_save(job));
  timeline_end(&job->timeline, "write the picture", begin_ms);

done:
  if (job->progress_shown) fprintf(stderr, "\r              \r");
  return status;
}

static Status reports_write(const Job *job)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &job->options;
  double total_ms = clock_ms() - job->begin_ms;
  json_t *stats = NULL;
  if (options->profile) profile_print(stderr, &job->timeline, total_ms);
  if (options->stats_path) {
    bool raster = job->plan.primary == PRIMARY_RASTER;
    RasterCost cost;
    if (raster) TRY(raster_visibility_cost(&cost, &job->frame.raster, job->device, job->log));
    stats = record_stats(&(RecordSources){options, job->record, job->exposure_ev, &job->device_scene, job->device,
                                          &job->plan, &job->timeline, raster ? &cost : NULL, &job->frame,
                                          job->shadow_bound.lights ? &job->shadow_bound : NULL,
                                          job->reflection_bound.reflectors ? &job->reflection_bound : NULL,
                                          verify_is_wanted(options) ? &job->verify : NULL, total_ms});
    TRY(json_write(options->stats_path, stats, job->log));
  }
  if (options->trace_path) TRY(profile_write_trace(options->trace_path, &job->timeline, job->log));

done:
  json_decref(stats);
  return status;
}

int app_render(int argc, char **argv)
{
  Status status = STATUS_OK;
  Job job = {.begin_ms = clock_ms(), .progress_tenths = -1};
  Log log = {.sink = app_log_sink, .context = &job.options.quiet};
  job.log = &log;
  TRY(render_options_parse(&job.options, argc, argv, &log));
  if (job.options.help) {
    command_line_help(&render_command_line, stdout);
    goto done;
  }
  if (job.options.verbose) log.sink = app_log_sink_verbose;
  parallel_set_threads(job.options.threads);
  if (!job.options.list_cameras) {
    TRY(memory_check(&job.options, &log));
    TRY(outputs_check(&job.options, &log));
  }
  TRY(image_helper_start(&job.images, job.options.max_image_pixels, &log));
  if (!job.options.list_cameras) TRY(device_warm_up(&job));
  TRY(scene_read(&job));
  if (job.options.list_cameras) {
    cameras_print(&job.scene);
    goto done;
  }
  TRY(picture_render(&job));
  TRY(reports_write(&job));

done:
  job_free(&job);
  return status ? app_fail(&log, status) : app_end_output(0);
}
