// One picture: from the device's scene to the file.

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/record.h"
#include "app/run.h"
#include "base/clock.h"
#include "report/profile.h"
#include "scene/scene_defaults.h"

static bool verify_is_wanted(const RenderOptions *options) { return options->verify.all || options->verify.pixels; }

// Says what maps may get wrong, before anything is rendered.
static Status errors_bound(FrameJob *job, Run *run)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &job->options;
  const bool known = !options->exposure.is_auto && options->picture.tone == TONE_CURVE_NONE;
  const float scale = known ? exp2f(options->exposure.ev) : INFINITY;
  double begin_ms = clock_ms();
  if (plan_uses_shadows(&job->plan, SHADOW_SET_LOOKED_UP)) {
    TRY(shadow_bound_make(&job->shadow_bound, &job->frame, scale, run->log));
    timeline_end(&run->timeline, "bound the shadow maps' error", begin_ms);
  }
  begin_ms = clock_ms();
  if (reflections_use_maps(job->plan.reflections) || job->plan.reflections == REFLECTIONS_PLANAR) {
    TRY(reflection_bound_make(&job->reflection_bound, &job->frame,
                              options->exposure.is_auto ? 1 : exp2f(options->exposure.ev), run->log));
    timeline_end(&run->timeline, "bound the reflections' error", begin_ms);
  }

done:
  return status;
}

static SceneFacts scene_facts(const Run *run, const PictureArea *area)
{
  const DeviceScene *scene = &run->device_scene;
  SceneFacts facts = {.triangle_count = scene->triangle_count,
                      .pixel_count = (uint64_t)area->width * area->height,
                      .gpu = device_info(run->device)->is_gpu,
                      .light_count = scene->light_count,
                      .has_mirrors = scene->has_mirrors,
                      .has_blends = scene->has_blends,
                      .least_roughness = scene->least_roughness,
                      .environment_lights = scene->environment_lights,
                      .sequence = run->sequence};
  for (uint32_t i = 0; i < facts.light_count; i++) facts.lights_by_kind[scene->light_infos[i].kind]++;
  return facts;
}

Status run_camera(Camera *out, const Run *run)
{
  const RenderOptions *options = &run->options;
  *out = run->camera;
  if (!run->motion || !run->camera.name) return STATUS_OK;
  double aspect = (double)options->settings.width / options->settings.height;
  return scene_camera_choose(out, &run->scene, options->camera, aspect, run->log);
}

static Status frame_prepare(FrameJob *job, Run *run, Frame *before)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &job->options;
  PictureArea area = render_area(options);
  TRY(run_camera(&job->camera, run));
  job->facts = scene_facts(run, &area);
  job->plan = plan_make(&options->settings, &job->facts);
  log_debug(run->log, "%s: %u triangles, %u objects, %u lights; shadows %s, reflections %s", options->scene_path,
            run->device_scene.triangle_count, run->device_scene.object_count, run->device_scene.light_count,
            job->plan.shadow_rays ? "by rays" : "not needed",
            !job->plan.reflected_rays                   ? "not needed"
            : job->plan.reflections == REFLECTIONS_RAYS ? "by rays"
                                                        : "by maps");
  FrameRequest request = {
      .camera = &job->camera,
      .area = area,
      .samples = options->settings.samples,
      .plan = job->plan,
      .seed = options->seed,
      .aovs = aov_set_of(options->picture.aovs),
      .flat_background = options->background.kind != BACKGROUND_ENVIRONMENT,
      .exposure_ev = options->exposure.is_auto ? INFINITY : options->exposure.ev,
      .progress = progress_choose(&run->progress),
      .progress_context = &run->progress,
      .before = before,
  };
  double begin_ms = clock_ms();
  TRY(frame_make(&job->frame, run->device, &run->device_scene, &request, run->log));
  timeline_end(&run->timeline, "prepare the frame", begin_ms);
  if (options->stats_path || verify_is_wanted(options)) TRY(errors_bound(job, run));

done:
  return status;
}

// What was said of the first reflection's rung before the picture was rendered; NULL: nothing.
static const BoundShare *reflections_stated(const FrameJob *job)
{
  ReflectionMethod method = job->plan.reflections;
  bool is_stated = method >= REFLECTIONS_ENVIRONMENT && method < REFLECTIONS_RAYS;
  return is_stated ? &job->reflection_bound.rungs[method - REFLECTIONS_ENVIRONMENT] : NULL;
}

static Status picture_save(FrameJob *job, Run *run)
{
  Status status = STATUS_OK;
  Log *log = run->log;
  const RenderOptions *options = &job->options;
  job->exposure_ev = options->exposure.ev;
  if (options->exposure.is_auto) {
    TRY(picture_auto_exposure(&job->exposure_ev, &job->frame, log));
    log_info(log, "%s: --exposure %.2f, by auto", options->output_path, (double)job->exposure_ev);
  }
  TRY(record_make(&job->record, options, &job->plan, &job->camera, job->exposure_ev, device_info(run->device), log));
  const ImageAttribute attributes[] = {{"Software", "Frugal " FRUGAL_VERSION}, {"ImageDescription", job->record}};
  PictureOptions picture = options->picture;
  picture.exposure_ev = job->exposure_ev;
  picture.attributes = attributes;
  picture.attribute_count = sizeof attributes / sizeof *attributes;
  TRY(picture_write(&job->frame, &picture, run->images, options->output_path, options->format, log));
  log_debug(log, "%s: written: %s", options->output_path, job->record);
  if (!verify_is_wanted(options)) goto done;
  double begin_ms = clock_ms();
  TRY(verify_picture(&job->verify, &(VerifySources){options, &job->facts, &job->frame, &picture}, log));
  verify_say(&job->verify, job->shadow_bound.lights ? &job->shadow_bound : NULL, reflections_stated(job),
             options->output_path, log);
  timeline_end(&run->timeline, "verify", begin_ms);

done:
  return status;
}

static Status stats_write(const FrameJob *job, const Run *run)
{
  Status status = STATUS_OK;
  const RenderOptions *options = &job->options;
  const Timeline spans = {.spans = run->timeline.spans + job->first_span,
                          .count = run->timeline.count - job->first_span};
  const bool raster = job->plan.primary == PRIMARY_RASTER;
  RasterCost cost;
  if (raster) TRY(raster_visibility_cost(&cost, &job->frame.raster, run->device, run->log));
  json_t *stats = record_stats(
      &(RecordSources){options, job->record, job->exposure_ev, &run->device_scene, run->device, &job->plan, &spans,
                       raster ? &cost : NULL, &job->frame, job->shadow_bound.lights ? &job->shadow_bound : NULL,
                       job->reflection_bound.reflectors ? &job->reflection_bound : NULL,
                       verify_is_wanted(options) ? &job->verify : NULL, clock_ms() - job->begin_ms});
  status = json_write(options->stats_path, stats, run->log);
  json_decref(stats);

done:
  return status;
}

Status frame_job_render(FrameJob *out, Run *run, Frame *before)
{
  Status status = STATUS_OK;
  TRY(frame_prepare(out, run, before));
  double begin_ms = clock_ms();
  TRY(frame_render(&out->frame, run->log));
  timeline_end(&run->timeline, "render", begin_ms);
  begin_ms = clock_ms();
  TRY(picture_save(out, run));
  timeline_end(&run->timeline, "write the picture", begin_ms);
  if (out->options.stats_path) TRY(stats_write(out, run));

done:
  return status;
}

void frame_job_free(FrameJob *job)
{
  shadow_bound_free(&job->shadow_bound);
  reflection_bound_free(&job->reflection_bound);
  frame_free(&job->frame);
  free(job->record);
  free(job->output_path);
  free(job->stats_path);
  *job = (FrameJob){0};
}
