#include "render/picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/large_array.h"
#include "render/exposure.h"
#include "shared/aov.h"

uint32_t aov_set_of(uint32_t names)
{
  uint32_t set = AOV_SET_NONE;
  if (names & (AOV_NAME_SHADOW - 1)) set |= AOV_SET_SURFACE;
  if (names & AOV_NAME_SHADOW) set |= AOV_SET_SHADOW;
  if (names & AOV_NAME_REFLECTION) set |= AOV_SET_REFLECTION;
  return set;
}

// Everything that a picture's groups point into.
typedef struct PictureData {
  BufferView picture;                    // [pixels][4]
  float *values;                         // [AOV_VALUE_PLANES][pixels]
  uint32_t *ids;                         // [AOV_ID_PLANES][pixels]
  float *direct;                         // [pixels][4]
  float *normals, *albedos, *positions;  // [pixels][3]
  float *shadows;                        // [pixels]
  ImageChannels groups[16];
  uint32_t group_count;
} PictureData;

static void picture_data_free(PictureData *data)
{
  void *arrays[] = {data->values,  data->ids,       data->direct, data->normals,
                    data->albedos, data->positions, data->shadows};
  for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) free(arrays[i]);
  buffer_view_close(&data->picture);
}

static void group_add(PictureData *data, ImageChannels group) { data->groups[data->group_count++] = group; }

// Planes of one quantity, interleaved and scaled.
static float *planes_interleave(const float *planes, size_t pixels, float scale)
{
  float *out = large_array(pixels * 3, sizeof *out);
  for (size_t i = 0; i < pixels && out; i++)
    for (int c = 0; c < 3; c++) out[3 * i + c] = planes[c * pixels + i] * scale;
  return out;
}

static Status aov_surface_groups(PictureData *data, Frame *frame, uint32_t names, size_t pixels, Log *log)
{
  Status status = STATUS_OK;
  float scale = 1.0f / (float)frame->request.samples;
  data->values = large_array(pixels * AOV_VALUE_PLANES, sizeof *data->values);
  data->ids = large_array(pixels * AOV_ID_PLANES, sizeof *data->ids);
  if (!data->values || !data->ids) return log_no_memory(log, "AOVs");
  TRY(buffer_read(frame->device, &frame->film.aov_values, data->values, pixels * AOV_VALUE_PLANES * sizeof(float),
                  log));
  TRY(buffer_read(frame->device, &frame->film.aov_ids, data->ids, pixels * AOV_ID_PLANES * sizeof(uint32_t), log));
  data->positions = planes_interleave(data->values + AOV_POSITION * pixels, pixels, 1);
  data->normals = planes_interleave(data->values + AOV_NORMAL * pixels, pixels, scale);
  data->albedos = planes_interleave(data->values + AOV_ALBEDO * pixels, pixels, scale);
  if (!data->positions || !data->normals || !data->albedos) return log_no_memory(log, "AOVs");
  if (names & AOV_NAME_DEPTH) group_add(data, (ImageChannels){{"depth.Z"}, 1, 1, data->values + AOV_DEPTH * pixels, 0});
  if (names & AOV_NAME_POSITION)
    group_add(data, (ImageChannels){{"position.X", "position.Y", "position.Z"}, 3, 3, data->positions, 0});
  if (names & AOV_NAME_NORMAL)
    group_add(data, (ImageChannels){{"normal.X", "normal.Y", "normal.Z"}, 3, 3, data->normals, 0});
  if (names & AOV_NAME_ALBEDO)
    group_add(data, (ImageChannels){{"albedo.R", "albedo.G", "albedo.B"}, 3, 3, data->albedos, 0});
  if (names & AOV_NAME_OBJECT)
    group_add(data, (ImageChannels){{"object.id"}, 1, 1, data->ids + AOV_OBJECT * pixels, 1});
  if (names & AOV_NAME_PRIMITIVE)
    group_add(data, (ImageChannels){{"primitive.id"}, 1, 1, data->ids + AOV_PRIMITIVE * pixels, 1});
  if (names & AOV_NAME_MATERIAL)
    group_add(data, (ImageChannels){{"material.id"}, 1, 1, data->ids + AOV_MATERIAL * pixels, 1});

done:
  return status;
}

static size_t pixel_count(const Frame *frame) { return (size_t)frame->camera.info.width * frame->camera.info.height; }

Status picture_lit_shares(float *out, Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const DeviceBuffer *buffers[3] = {&frame->lit_sums, &frame->own_sums, &frame->unshadowed_sums};
  BufferView views[3] = {{0}};
  const float *sums[3];
  size_t pixels = pixel_count(frame);
  for (int i = 0; i < 3; i++) {
    TRY(buffer_view_open(&views[i], frame->device, buffers[i], "AOVs", log));
    sums[i] = views[i].data;
  }
  for (size_t i = 0; i < pixels; i++) {
    float arrives = 0, unshadowed = 0;
    for (int c = 0; c < 3; c++) {
      arrives += sums[0][4 * i + c] - sums[1][4 * i + c];
      unshadowed += sums[2][4 * i + c] - sums[1][4 * i + c];
    }
    out[i] = unshadowed > 0 ? fminf(fmaxf(arrives / unshadowed, 0), 1) : 1;
  }

done:
  for (int i = 0; i < 3; i++) buffer_view_close(&views[i]);
  return status;
}

static Status aov_shadow_group(PictureData *data, Frame *frame, size_t pixels, Log *log)
{
  Status status = STATUS_OK;
  data->shadows = large_array(pixels, sizeof *data->shadows);
  if (!data->shadows) return log_no_memory(log, "AOVs");
  TRY(picture_lit_shares(data->shadows, frame, log));
  group_add(data, (ImageChannels){{"shadow.Y"}, 1, 1, data->shadows, 0});

done:
  return status;
}

// reflection: all radiance less that of the first hits, as linear as the picture.
static Status aov_reflection_group(PictureData *data, Frame *frame, size_t pixels, float scale, Log *log)
{
  Status status = STATUS_OK;
  BufferView view = {0};
  data->direct = large_array(pixels * 4, sizeof *data->direct);
  if (!data->direct) return log_no_memory(log, "AOVs");
  TRY(buffer_read(frame->device, &frame->direct_sums, data->direct, pixels * 4 * sizeof *data->direct, log));
  TRY(buffer_view_open(&view, frame->device, &frame->film.sums, "AOVs", log));
  const float *sums = view.data;
  for (size_t i = 0; i < 4 * pixels; i++) data->direct[i] = (sums[i] - data->direct[i]) * scale;
  group_add(data, (ImageChannels){{"reflection.R", "reflection.G", "reflection.B"}, 3, 4, data->direct, 0});

done:
  buffer_view_close(&view);
  return status;
}

uint64_t picture_memory_bytes(const PictureArea *area, uint32_t aovs)
{
  enum { FLOAT4 = 16, PICTURE = 5 * FLOAT4, SURFACE = 3 * 4 * (AOV_VALUE_PLANES + AOV_ID_PLANES), SHADOW = 7 * FLOAT4 };
  uint32_t set = aov_set_of(aovs);
  uint64_t pixel_bytes =
      PICTURE + (set & AOV_SET_SURFACE ? SURFACE : 0) + (set & (AOV_SET_SHADOW | AOV_SET_REFLECTION) ? SHADOW : 0);
  return (uint64_t)area->width * area->height * pixel_bytes;
}

Status picture_auto_exposure(float *ev, Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  BufferView sums = {0};
  TRY(buffer_view_open(&sums, frame->device, &frame->film.sums, "the picture", log));
  LightMeter meter = light_meter_read(sums.data, pixel_count(frame), frame->request.samples);
  *ev = light_meter_exposure_ev(&meter);
  if (!meter.lit_pixels) log_warn(log, "--exposure auto: nothing in view is lit: exposure 0 is taken");

done:
  buffer_view_close(&sums);
  return status;
}

// A line about a picture in which nothing can be made out.
static Status picture_check(Frame *frame, const float *picture, const char *path, Log *log)
{
  Status status = STATUS_OK;
  BufferView sums = {0};
  size_t pixels = pixel_count(frame);
  uint32_t samples = frame->request.samples;
  TRY(buffer_view_open(&sums, frame->device, &frame->film.sums, "the picture", log));
  PictureVerdict verdict = picture_judge(picture, sums.data, pixels, samples);
  if (verdict == PICTURE_FINE) goto done;
  LightMeter meter = light_meter_read(sums.data, pixels, samples);
  if (verdict == PICTURE_EMPTY)
    log_warn(log, "%s: shows no surface: try --camera fit", path);
  else if (!meter.lit_pixels)
    log_warn(log, "%s: comes out black, for no light reaches what is in view: try --environment sky", path);
  else
    log_warn(log, "%s: comes out %s: try --exposure %.2f", path, verdict == PICTURE_BLACK ? "black" : "blown out",
             (double)light_meter_exposure_ev(&meter));

done:
  buffer_view_close(&sums);
  return status;
}

ResolveInfo picture_resolve_info(const PictureOptions *options, const Frame *frame, uint32_t samples, bool display)
{
  return (ResolveInfo){
      .pixel_count = (uint32_t)pixel_count(frame),
      .scale = exp2f(options->exposure_ev) / (float)samples,
      .coverage_scale = 1.0f / (float)samples,
      .tone = options->tone,
      .display = display,
      .opaque = options->opaque,
      .has_background = options->has_background,
      .background = {options->background[0], options->background[1], options->background[2]},
  };
}

Status picture_write(Frame *frame, const PictureOptions *options, ImageHelper *images, const char *path,
                     const char *format, Log *log)
{
  Status status = STATUS_OK;
  PictureData data = {0};
  const CameraInfo *camera = &frame->camera.info;
  size_t pixels = pixel_count(frame);
  if (!format) format = image_format_of(path);
  if (!format) return log_fail(log, STATUS_USAGE, "%s: unknown kind of picture: use .png, .jpg, .exr or .hdr", path);
  bool exr = !strcmp(format, "exr"), linear = exr || !strcmp(format, "hdr");
  if (options->aovs && !exr) return log_fail(log, STATUS_USAGE, "%s: --aov needs a format with layers: use .exr", path);

  ResolveInfo resolve = picture_resolve_info(options, frame, frame->request.samples, !linear);
  TRY(film_develop(&frame->film, frame->device, &frame->film.sums, &resolve, log));
  TRY(buffer_view_open(&data.picture, frame->device, &frame->film.picture, path, log));
  if (!linear) TRY(picture_check(frame, data.picture.data, path, log));
  bool alpha = exr || (!options->opaque && !strcmp(format, "png"));
  group_add(&data, (ImageChannels){{"R", "G", "B", "A"}, alpha ? 4 : 3, 4, data.picture.data, 0});
  if (frame->request.aovs & AOV_SET_SURFACE) TRY(aov_surface_groups(&data, frame, options->aovs, pixels, log));
  if (options->aovs & AOV_NAME_SHADOW) TRY(aov_shadow_group(&data, frame, pixels, log));
  if (options->aovs & AOV_NAME_REFLECTION) TRY(aov_reflection_group(&data, frame, pixels, resolve.scale, log));

  ImageOutput output = {
      .width = camera->width,
      .height = camera->height,
      .groups = data.groups,
      .group_count = data.group_count,
      .bit_depth = options->bit_depth,
      .quality = options->quality,
      .compression = options->compression,
      .attributes = options->attributes,
      .attribute_count = options->attribute_count,
  };
  TRY(image_write(images, path, format, &output, log));

done:
  picture_data_free(&data);
  return status;
}
