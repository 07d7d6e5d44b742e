// frugal render: one picture of one scene.

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/app.h"
#include "app/options.h"
#include "base/clock.h"
#include "base/parallel.h"
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
  Device *device;
  DeviceScene device_scene;
  Frame frame;
  Plan plan;
  double begin_ms;
  double progress_ms;  // when the progress line was last drawn
  bool progress_shown;
} Job;

static void job_free(Job *job)
{
  frame_free(&job->frame);
  device_scene_free(&job->device_scene);
  device_close(job->device);
  scene_free(&job->scene);
  image_helper_stop(job->images);
  timeline_free(&job->timeline);
}

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

static Status environment_read(Job *job)
{
  const RenderOptions *options = &job->options;
  Environment *environment = &job->scene.environment;
  Status status = STATUS_OK;
  switch (options->environment) {
    case ENVIRONMENT_UNSET: TRY(scene_add_default_lighting(&job->scene, options->key_light, job->log)); break;
    case ENVIRONMENT_NONE: *environment = (Environment){.kind = ENVIRONMENT_CONSTANT}; break;
    case ENVIRONMENT_SKY: scene_set_sky(&job->scene); break;
    case ENVIRONMENT_COLOR:
      environment->kind = ENVIRONMENT_CONSTANT;
      memcpy(environment->constant, options->environment_color, sizeof environment->constant);
      break;
    case ENVIRONMENT_FILE:
      TRY(image_read(&environment->image, job->images, IMAGE_RADIANCE, options->environment_path, NULL, 0, job->log));
      environment->kind = ENVIRONMENT_IMAGE;
      break;
  }
  environment->intensity = options->environment_intensity;
  environment->rotation_rad = options->environment_rotation_rad;

done:
  return status;
}

static Status scene_read(Job *job)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &job->options;
  GltfOptions gltf = {.scene = NONE, .allow_outside = options->allow_outside, .max_memory_bytes = options->max_memory_bytes};
  double begin_ms = clock_ms();
  TRY(gltf_read(&job->scene, options->scene_path, &gltf, job->images, job->log));
  TRY(environment_read(job));
  double aspect = (double)options->settings.width / options->settings.height;
  TRY(scene_camera_choose(&job->camera, &job->scene, options->camera, aspect, job->log));
  timeline_end(&job->timeline, "read the scene", begin_ms);

done:
  return status;
}

static Status picture_render(Job *job)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &job->options;
  const RenderSettings *settings = &options->settings;
  bool timed = options->profile || options->stats_path || options->trace_path;
  double begin_ms = clock_ms();
  TRY(device_open(&job->device, options->device, options->threads, timed ? &job->timeline : NULL, job->log));
  timeline_end(&job->timeline, "open the device", begin_ms);
  TRY(device_scene_make(&job->device_scene, job->device, &job->scene, &job->timeline, job->log));

  SceneFacts facts = {.light_count = job->device_scene.light_count,
                      .has_mirrors = job->device_scene.has_mirrors,
                      .has_blends = job->device_scene.has_blends,
                      .environment_lights = job->device_scene.environment_lights};
  job->plan = plan_make(settings, &facts);
  FrameRequest request = {
      .camera = &job->camera,
      .area = {settings->width, settings->height, 0, 0, settings->width, settings->height},
      .samples = settings->samples,
      .plan = job->plan,
      .aovs = aov_set_of(options->picture.aovs),
      .progress = !options->quiet && isatty(STDERR_FILENO) ? progress_draw : NULL,
      .progress_context = job,
  };
  begin_ms = clock_ms();
  TRY(frame_make(&job->frame, job->device, &job->device_scene, &request, job->log));
  timeline_end(&job->timeline, "prepare the frame", begin_ms);
  begin_ms = clock_ms();
  TRY(frame_render(&job->frame, job->log));
  timeline_end(&job->timeline, "render", begin_ms);
  begin_ms = clock_ms();
  TRY(picture_write(&job->frame, &options->picture, job->images, options->output_path, options->format, job->log));
  timeline_end(&job->timeline, "write the picture", begin_ms);

done:
  if (job->progress_shown) fprintf(stderr, "\r              \r");
  return status;
}

static Status stats_write(const Job *job, double total_ms)
{
  const RenderSettings *settings = &job->options.settings;
  const DeviceInfo *device = device_info(job->device);
  const DeviceTraits *traits = device_traits(job->device);
  json_t *stats = json_pack(
      "{s:s, s:s, s:s, s:{s:s, s:s, s:s, s:i}, s:[i,i], s:i, s:{s:i, s:i, s:i, s:i}, s:{s:s, s:s, s:s, s:s, s:i, s:b}, s:o, s:f}",
      "version", FRUGAL_VERSION, "scene", job->options.scene_path, "output", job->options.output_path, "device", "name",
      device->name, "platform", device->platform, "driver", device->driver, "lanes", traits->lanes, "size", settings->width,
      settings->height, "samples", settings->samples, "counts", "triangles", job->device_scene.triangle_count, "objects",
      job->device_scene.object_count, "materials", job->device_scene.material_count, "lights", job->device_scene.light_count,
      "plan", "lighting", job->plan.lighting == LIGHTING_PHONG ? "phong" : "pbr", "primary", "rays", "shadows",
      job->plan.shadow_rays ? "rays" : "none", "reflections", job->plan.reflected_rays ? "rays" : "none", "max_depth",
      job->plan.max_depth, "environment_light", job->plan.environment_light, "passes", profile_json(&job->timeline), "total_ms",
      total_ms);
  Status status = json_write(job->options.stats_path, stats, job->log);
  json_decref(stats);
  return status;
}

static Status reports_write(const Job *job)
{
  Status status = STATUS_OK;
  double total_ms = clock_ms() - job->begin_ms;
  if (job->options.profile) profile_print(stderr, &job->timeline, total_ms);
  if (job->options.stats_path) TRY(stats_write(job, total_ms));
  if (job->options.trace_path) TRY(profile_write_trace(job->options.trace_path, &job->timeline, job->log));

done:
  return status;
}

int app_render(int argc, char **argv)
{
  Status status = STATUS_OK;
  Job job = {.begin_ms = clock_ms()};
  Log log = {.sink = app_log_sink, .context = &job.options.quiet};
  job.log = &log;
  TRY(render_options_parse(&job.options, argc, argv, &log));
  if (job.options.help) {
    fputs(render_usage, stdout);
    goto done;
  }
  ImageAttribute attributes[] = {{"Software", "Frugal " FRUGAL_VERSION}};
  job.options.picture.attributes = attributes;
  job.options.picture.attribute_count = 1;
  parallel_set_threads(job.options.threads);
  TRY(image_helper_start(&job.images, job.options.max_image_pixels, &log));
  TRY(scene_read(&job));
  TRY(picture_render(&job));
  TRY(reports_write(&job));

done:
  job_free(&job);
  return status ? app_fail(&log, status) : 0;
}
