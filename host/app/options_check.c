#include "app/options.h"

#include <string.h>

// An option that the format gives no meaning is a mistake that would go unnoticed otherwise.
static Status format_check(const RenderOptions *options, Log *log)
{
  const char *format = options->format, *path = options->output_path;
  const PictureOptions *picture = &options->picture;
  bool is_png = !strcmp(format, "png"), is_exr = !strcmp(format, "exr");
  if (picture->aovs && !is_exr)
    return log_fail(log, STATUS_USAGE, "%s: --aov needs a format with layers: use .exr", path);
  if (options->background.kind == BACKGROUND_TRANSPARENT && !is_png && !is_exr)
    return log_fail(log, STATUS_USAGE, "%s: --background transparent needs a format with alpha: use .png or .exr",
                    path);
  if (picture->bit_depth && !is_png)
    return log_fail(log, STATUS_USAGE, "%s: --bit-depth is for .png alone: leave it out", path);
  if (picture->bit_depth && picture->bit_depth != 8 && picture->bit_depth != 16)
    return log_fail(log, STATUS_USAGE, "--bit-depth %u: not valid: expected 8 or 16", picture->bit_depth);
  if (picture->quality && strcmp(format, "jpg") != 0)
    return log_fail(log, STATUS_USAGE, "%s: --quality is for .jpg alone: leave it out", path);
  if (picture->compression && !is_png && !is_exr)
    return log_fail(log, STATUS_USAGE, "%s: --compression is for .png and .exr: leave it out", path);
  if (picture->compression && !image_compression_is_known(format, picture->compression))
    return log_fail(log, STATUS_USAGE, "--compression %s: not one of .%s: expected %s", picture->compression, format,
                    is_png ? "0 to 9" : "none, rle, zip, zips, piz, pxr24, b44, b44a, dwaa or dwab");
  return STATUS_OK;
}

static Status frames_check(const RenderOptions *options, Log *log)
{
  const FrameRange *range = &options->frames;
  if (!range->given && !options->scene_file.document && (options->fps > 0 || options->animation))
    return log_fail(log, STATUS_USAGE, "--%s: says how the scene moves, but one picture of it at rest is asked for: %s",
                    options->animation ? "animation" : "fps", "add --frames");
  const char *const paths[] = {options->output_path, options->stats_path};
  for (int i = 0; i < 2; i++) {
    if (!paths[i] || !strcmp(paths[i], "-")) continue;
    if (!range->given && path_names_frame(paths[i]))
      return log_fail(log, STATUS_USAGE, "%s: names the frame of one picture at rest: add --frames", paths[i]);
    if ((range->all || range->last - range->first >= range->step) && !path_names_frame(paths[i]))
      return log_fail(log, STATUS_USAGE, "%s: one name for many frames: add {frame} or {frame:04} to it", paths[i]);
  }
  return STATUS_OK;
}

static Status combination_check(const RenderOptions *options, Log *log)
{
  const Crop *crop = &options->crop;
  const RenderSettings *settings = &options->settings;
  if ((uint64_t)crop->x + crop->width > settings->width || (uint64_t)crop->y + crop->height > settings->height)
    return log_fail(log, STATUS_USAGE, "--crop %u,%u,%u,%u: leaves the picture of %ux%u: stay within it", crop->x,
                    crop->y, crop->width, crop->height, settings->width, settings->height);
  const char *const outputs[] = {options->output_path, options->stats_path, options->trace_path};
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < i; k++)
      if (outputs[i] && outputs[k] && !strcmp(outputs[i], outputs[k]))
        return log_fail(log, STATUS_USAGE, "%s: named for two outputs: give each its own", outputs[i]);
  return STATUS_OK;
}

Status render_options_check(const RenderOptions *options, Log *log)
{
  Status status = STATUS_OK;
  TRY(format_check(options, log));
  TRY(combination_check(options, log));
  TRY(frames_check(options, log));

done:
  return status;
}
