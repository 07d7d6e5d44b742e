#include "stability/lab.h"

#include <stdlib.h>
#include <string.h>

#include "render/reflection_bound.h"
#include "render/shadow_bound.h"
#include "report/image_compare.h"
#include "report/loop_math.h"
#include "shared/aov.h"

void lab_pictures_free(LabPictures *pictures)
{
  image_free(&pictures->method);
  image_free(&pictures->reference);
}

void shot_free(Shot *shot)
{
  free(shot->radiance);
  free(shot->values);
  free(shot->ids);
  *shot = (Shot){0};
}

Vec3 shot_vector(const Shot *shot, size_t pixel, int plane)
{
  const float *at = shot->values + (size_t)plane * shot_pixels(shot) + pixel;
  return vec3(at[0], at[shot_pixels(shot)], at[2 * shot_pixels(shot)]);
}

RenderSettings lab_settings(uint32_t width, uint32_t height)
{
  return (RenderSettings){.width = width,
                          .height = height,
                          .samples = 1,
                          .lighting = LIGHTING_PHONG,
                          .primary = PRIMARY_RAYS,
                          .shadows = SHADOWS_RAYS,
                          .shadow_options = {.kernel_px = 3},
                          .reflections = REFLECTIONS_NONE,
                          .max_depth = 8};
}

static FrameRequest lab_request(const Lab *lab, const DeviceScene *scene, const Camera *camera,
                                const RenderSettings *settings)
{
  const SceneFacts facts = {.triangle_count = scene->triangle_count,
                            .pixel_count = (uint64_t)settings->width * settings->height,
                            .gpu = device_info(lab->device)->is_gpu,
                            .light_count = scene->light_count,
                            .has_mirrors = scene->has_mirrors,
                            .has_blends = scene->has_blends,
                            .least_roughness = scene->least_roughness,
                            .environment_lights = scene->environment_lights};
  return (FrameRequest){.camera = camera,
                        .area = {settings->width, settings->height, 0, 0, settings->width, settings->height},
                        .samples = settings->samples,
                        .plan = plan_make(settings, &facts),
                        .aovs = AOV_SET_SURFACE};
}

Status lab_render(Shot *out, Lab *lab, const DeviceScene *scene, const Camera *camera, const RenderSettings *settings)
{
  Status status = STATUS_OK;
  Frame frame = {0};
  Shot shot = {.width = settings->width, .height = settings->height};
  size_t pixels = shot_pixels(&shot);
  const FrameRequest request = lab_request(lab, scene, camera, settings);
  const float share = 1 / (float)settings->samples;
  const ResolveInfo resolve = {.pixel_count = (uint32_t)pixels, .scale = share, .coverage_scale = share, .opaque = 1};
  shot.radiance = malloc(pixels * 4 * sizeof *shot.radiance);
  shot.values = malloc(pixels * AOV_VALUE_PLANES * sizeof *shot.values);
  shot.ids = malloc(pixels * AOV_ID_PLANES * sizeof *shot.ids);
  if (!shot.radiance || !shot.values || !shot.ids) {
    status = log_no_memory(lab->log, "picture");
    goto done;
  }
  TRY(frame_make(&frame, lab->device, scene, &request, lab->log));
  TRY(frame_render(&frame, lab->log));
  TRY(film_resolve(&frame.film, lab->device, &frame.film.sums, &resolve, shot.radiance, lab->log));
  TRY(buffer_read(lab->device, &frame.film.aov_values, shot.values, pixels * AOV_VALUE_PLANES * sizeof *shot.values,
                  lab->log));
  TRY(buffer_read(lab->device, &frame.film.aov_ids, shot.ids, pixels * AOV_ID_PLANES * sizeof *shot.ids, lab->log));
  shot.camera = frame.camera.info;
  *out = shot;
  shot = (Shot){0};

done:
  frame_free(&frame);
  shot_free(&shot);
  return status;
}

Status lab_shadow_bound(double *pixels, Lab *lab, const DeviceScene *scene, const Camera *camera,
                        const RenderSettings *settings)
{
  Status status = STATUS_OK;
  Frame frame = {0};
  ShadowBound bound = {0};
  const FrameRequest request = lab_request(lab, scene, camera, settings);
  if (plan_uses_shadows(&request.plan, SHADOW_SET_LOOKED_UP)) {
    TRY(frame_make(&frame, lab->device, scene, &request, lab->log));
    TRY(shadow_bound_make(&bound, &frame, 1, lab->log));
  }
  *pixels = bound.bound * settings->width * settings->height;

done:
  shadow_bound_free(&bound);
  frame_free(&frame);
  return status;
}

Status lab_reflection_bound(double *share, Lab *lab, const DeviceScene *scene, const Camera *camera,
                            const RenderSettings *settings)
{
  Status status = STATUS_OK;
  Frame frame = {0};
  ReflectionBound bound = {0};
  const FrameRequest request = lab_request(lab, scene, camera, settings);
  TRY(frame_make(&frame, lab->device, scene, &request, lab->log));
  TRY(reflection_bound_make(&bound, &frame, 1, lab->log));
  *share = bound.rungs[settings->reflections - REFLECTIONS_ENVIRONMENT].bound;

done:
  reflection_bound_free(&bound);
  frame_free(&frame);
  return status;
}

Status lab_render_scene(Shot *out, Lab *lab, const Scene *scene, const Camera *camera, const RenderSettings *settings)
{
  Status status = STATUS_OK;
  DeviceScene on_device = {0};
  TRY(scene_check_complete(scene, lab->log));
  TRY(device_scene_make(&on_device, lab->device, scene, NULL, lab->log));
  TRY(lab_render(out, lab, &on_device, camera, settings));

done:
  device_scene_free(&on_device);
  return status;
}

static Status picture_copy(Image *out, const float *from, uint32_t width, uint32_t height, uint32_t channels, Log *log)
{
  size_t pixels = (size_t)width * height;
  Image image = {.width = width, .height = height, .pixels = malloc(pixels * 4 * sizeof *image.pixels)};
  if (!image.pixels) return log_no_memory(log, "picture");
  for (size_t i = 0; i < 4 * pixels; i++) {
    size_t channel = i % 4;
    float value = channel == 3 ? 1 : from[i / 4 * channels + (channels == 1 ? 0 : channel)];
    image.pixels[i] = isfinite(value) ? value : 1e3f;
  }
  image_free(out);
  *out = image;
  return STATUS_OK;
}

Status lab_keep(Lab *lab, const float *method, const float *reference, uint32_t width, uint32_t height,
                uint32_t channels)
{
  Status status = STATUS_OK;
  TRY(picture_copy(&lab->pictures.method, method, width, height, channels, lab->log));
  TRY(picture_copy(&lab->pictures.reference, reference, width, height, channels, lab->log));

done:
  return status;
}

double lab_displayed(double linear) { return (double)loop_srgb_encode(fminf(fmaxf((float)linear, 0), 1)); }

bool lab_differ(double a, double b)
{
  if (!isfinite(a) || !isfinite(b)) return true;
  return fabs(lab_displayed(a) - lab_displayed(b)) > IMAGE_THRESHOLD + IMAGE_ROUNDING;
}

size_t lab_count_different(const Shot *a, const Shot *b)
{
  size_t count = 0;
  for (size_t i = 0; i < shot_pixels(a); i++) {
    const float *x = a->radiance + 4 * i, *y = b->radiance + 4 * i;
    bool differs = false;
    for (int c = 0; c < 3; c++) differs |= lab_differ((double)x[c], (double)y[c]);
    count += differs;
  }
  return count;
}
