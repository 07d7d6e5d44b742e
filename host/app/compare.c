// frugal compare: how far one picture is from another, and whether that is too far.

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "app/app.h"
#include "app/compare_options.h"
#include "base/parallel.h"
#include "report/compare_files.h"
#include "report/profile.h"

// A second helper pays off (0.2 s of processor time) for files that take longer than that to decode.
enum { LARGE_FILE_BYTES = 4 << 20 };

// One of the two pictures. The second may have no helper of its own: it is then read after the first by that one's.
typedef struct Reading {
  const CompareOptions *options;
  const char *path;
  ImageHelper *helper;
  ComparePicture picture;
  Log log;
  Status status;
} Reading;

typedef struct Comparison {
  CompareOptions options;
  Reading readings[2];
  uint8_t *mask;  // NULL: everything
  uint32_t metrics;
  ImageError error;
} Comparison;

static void comparison_free(Comparison *job)
{
  for (int i = 0; i < 2; i++) {
    image_free(&job->readings[i].picture.image);
    image_helper_stop(job->readings[i].helper);
  }
  free(job->mask);
}

static bool file_is_large(const char *path)
{
  struct stat file;
  return stat(path, &file) == 0 && file.st_size > LARGE_FILE_BYTES;
}

static void picture_read(Reading *reading, ImageHelper *helper)
{
  reading->status =
      compare_picture_read(&reading->picture, helper, reading->path, reading->options->ignore_alpha, &reading->log);
}

static void picture_read_beside(void *context, size_t i)
{
  Reading *reading = (Reading *)context + i;
  picture_read(reading, reading->helper);
}

static Status pictures_read(Comparison *job, Log *log)
{
  Status status = STATUS_OK;
  const CompareOptions *options = &job->options;
  Reading *readings = job->readings;
  for (int i = 0; i < 2; i++)
    readings[i] =
        (Reading){.options = options, .path = options->paths[i], .log = {.sink = log->sink, .context = log->context}};
  bool large = file_is_large(options->paths[0]) && file_is_large(options->paths[1]);
  TRY(image_helper_start(&readings[0].helper, options->max_image_pixels, log));
  if (large) TRY(image_helper_start(&readings[1].helper, options->max_image_pixels, log));
  if (large)
    parallel_for(2, picture_read_beside, readings);
  else
    for (int i = 0; i < 2; i++) picture_read(&readings[i], readings[0].helper);
  for (int i = 0; i < 2; i++)
    if (readings[i].status) return log_fail(log, readings[i].status, "%s", readings[i].log.error);
  const ComparePicture pictures[2] = {readings[0].picture, readings[1].picture};
  TRY(compare_channels_check(pictures, options->paths, log));

done:
  return status;
}

static bool metric_is_chosen(const Comparison *job, const char *name)
{
  return job->metrics >> image_metric_find(name, strlen(name)) & 1;
}

// What --metrics names, or all but HDR-FLIP, and what there are limits on.
static Status metrics_choose(Comparison *job, Log *log)
{
  const CompareOptions *options = &job->options;
  job->metrics = options->metrics;
  if (!job->metrics) job->metrics = COMPARE_ALL_METRICS & ~(1u << image_metric_find("hdr-flip", strlen("hdr-flip")));
  for (size_t i = 0; i < options->limits.count; i++) job->metrics |= 1u << options->limits.items[i].metric;
  for (int i = 0; i < 2; i++)
    if (metric_is_chosen(job, "hdr-flip") && job->readings[i].picture.is_display)
      return log_fail(log, STATUS_USAGE, "%s: holds no radiance for hdr-flip: compare .exr or .hdr files, or use flip",
                      options->paths[i]);
  return STATUS_OK;
}

static Status mask_make(Comparison *job, Log *log)
{
  Status status = STATUS_OK;
  const Image *image = &job->readings[0].picture.image;
  const CompareMasks *masks = &job->options.masks;
  if (!masks->count) return STATUS_OK;
  job->mask = malloc((size_t)image->width * image->height);
  if (!job->mask) return log_no_memory(log, job->options.paths[0]);
  memset(job->mask, 1, (size_t)image->width * image->height);
  for (size_t i = 0; i < masks->count; i++)
    TRY(compare_mask_select(job->mask, image->width, image->height, job->readings[0].helper, masks->items[i], log));

done:
  return status;
}

static Status pictures_compare(Comparison *job, Log *log)
{
  Status status = STATUS_OK;
  const CompareOptions *options = &job->options;
  ImageCompareOptions compare = {
      .threshold = options->threshold,
      .mask = job->mask,
      .pixels_per_degree = options->pixels_per_degree,
      .flip = metric_is_chosen(job, "flip"),
      .hdr_flip = metric_is_chosen(job, "hdr-flip"),
      .ssim = metric_is_chosen(job, "ssim"),
      .names = {options->paths[0], options->paths[1]},
  };
  const Image *a = &job->readings[0].picture.image, *b = &job->readings[1].picture.image;
  TRY(image_compare(&job->error, a, b, &compare, log));
  if (options->difference_path)
    TRY(image_difference_write(job->readings[0].helper, options->difference_path, a, b, &compare, log));

done:
  return status;
}

static const CompareLimit *limit_of(const CompareOptions *options, int metric)
{
  const CompareLimit *strictest = NULL;
  double sign = image_metrics[metric].larger_is_better ? -1 : 1;
  for (size_t i = 0; i < options->limits.count; i++) {
    const CompareLimit *limit = &options->limits.items[i];
    if (limit->metric == metric && (!strictest || sign * limit->value < sign * strictest->value)) strictest = limit;
  }
  return strictest;
}

static void table_print(const Comparison *job)
{
  const ImageError *error = &job->error;
  for (int i = 0; i < IMAGE_METRIC_COUNT; i++) {
    if (!(job->metrics >> i & 1)) continue;
    const CompareLimit *limit = limit_of(&job->options, i);
    printf("%-14s %12.6g  %s", image_metrics[i].name, image_metric_value(i, error), image_metrics[i].help);
    if (limit)
      printf(" (%s %g: %s)", image_metrics[i].larger_is_better ? "at least" : "at most", limit->value,
             image_metric_within(i, error, limit->value) ? "passed" : "FAILED");
    putchar('\n');
  }
  printf("%llu of %llu pixels are over %g", (unsigned long long)error->over, (unsigned long long)error->pixels,
         job->options.threshold);
  if (error->max_displayed > 0) printf("; the worst is at %u,%u", error->worst_x, error->worst_y);
  putchar('\n');
}

static json_t *number_json(double value) { return isfinite(value) ? json_real(value) : json_null(); }

static json_t *metrics_json(const Comparison *job)
{
  json_t *metrics = json_object();
  for (int i = 0; i < IMAGE_METRIC_COUNT && metrics; i++) {
    char key[32];
    snprintf(key, sizeof key, "%s", image_metrics[i].name);
    for (char *dash = key; (dash = strchr(dash, '-'));) *dash = '_';
    if (job->metrics >> i & 1) json_object_set_new(metrics, key, number_json(image_metric_value(i, &job->error)));
  }
  return metrics;
}

static json_t *limits_json(const Comparison *job)
{
  json_t *limits = json_array();
  for (size_t i = 0; i < job->options.limits.count && limits; i++) {
    const CompareLimit *limit = &job->options.limits.items[i];
    json_array_append_new(
        limits, json_pack("{s:s, s:f, s:b}", "metric", image_metrics[limit->metric].name, "limit", limit->value,
                          "passed", image_metric_within(limit->metric, &job->error, limit->value)));
  }
  return limits;
}

static Status json_print(const Comparison *job, bool passed, Log *log)
{
  const Image *image = &job->readings[0].picture.image;
  json_t *report = json_pack(
      "{s:s, s:s, s:i, s:i, s:I, s:I, s:f, s:o, s:{s:i, s:i}, s:o, s:b}", "reference", job->options.paths[0], "picture",
      job->options.paths[1], "width", image->width, "height", image->height, "pixels", (json_int_t)job->error.pixels,
      "pixels_over", (json_int_t)job->error.over, "threshold", job->options.threshold, "metrics", metrics_json(job),
      "worst", "x", job->error.worst_x, "y", job->error.worst_y, "limits", limits_json(job), "passed", passed);
  Status status = json_write("-", report, log);
  json_decref(report);
  return status;
}

// STATUS_FAILED at the first limit that is not kept. One on a number that there is none of is an error of input.
static Status limits_check(const Comparison *job, Log *log)
{
  const CompareOptions *options = &job->options;
  for (size_t i = 0; i < options->limits.count; i++) {
    const CompareLimit *limit = &options->limits.items[i];
    const ImageMetric *metric = &image_metrics[limit->metric];
    double value = image_metric_value(limit->metric, &job->error);
    if (isnan(value))
      return log_fail(log, STATUS_BAD_IMAGE, "%s: no %s of so few pixels: leave its limit out, or compare more",
                      options->paths[1], metric->name);
    if (!image_metric_within(limit->metric, &job->error, limit->value))
      return log_fail(log, STATUS_FAILED, "%s: %s is %g, %s %g: %s", options->paths[1], metric->name, value,
                      metric->larger_is_better ? "below" : "above", limit->value,
                      options->difference_path ? options->difference_path : "--diff FILE shows where");
  }
  return STATUS_OK;
}

int app_compare(int argc, char **argv)
{
  Status status = STATUS_OK;
  Log log = {.sink = app_log_sink, .context = &(bool){true}};
  Comparison job = {0};
  TRY(compare_options_parse(&job.options, argc, argv, &log));
  if (job.options.help) {
    compare_help(stdout);
    goto done;
  }
  parallel_set_threads(job.options.threads);
  TRY(pictures_read(&job, &log));
  TRY(metrics_choose(&job, &log));
  TRY(mask_make(&job, &log));
  TRY(pictures_compare(&job, &log));
  Log verdict_log = {0};
  Status verdict = limits_check(&job, &verdict_log);
  if (job.options.json)
    TRY(json_print(&job, verdict == STATUS_OK, &log));
  else
    table_print(&job);
  if (verdict) status = log_fail(&log, verdict, "%s", verdict_log.error);

done:
  comparison_free(&job);
  return app_end_output(status ? app_fail(&log, status) : 0);
}
