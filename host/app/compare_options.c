#include "app/compare_options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/command_line.h"
#include "base/nearest.h"
#include "report/flip.h"

static Status metric_read(int *metric, const Option *option, const char *name, size_t length, Log *log)
{
  char word[32];
  const char *names[IMAGE_METRIC_COUNT + 1] = {0};
  *metric = image_metric_find(name, length);
  if (*metric >= 0) return STATUS_OK;
  for (int i = 0; i < IMAGE_METRIC_COUNT; i++) names[i] = image_metrics[i].name;
  snprintf(word, sizeof word, "%.*s", (int)(length < sizeof word ? length : sizeof word - 1), name);
  return log_fail(log, STATUS_USAGE, "--%s %s: no such metric: did you mean '%s'?", option->name, word,
                  nearest_name(word, names));
}

// METRIC=X. A metric that is better when larger has limits below, the others above.
static Status read_limit(void *field, const Option *option, const char *text, Log *log)
{
  Status status = STATUS_OK;
  CompareLimits *limits = field;
  const char *equals = strchr(text, '=');
  char *end = NULL;
  CompareLimit limit;
  if (!equals) return option_fail(log, option, text, "METRIC=X, such as over=0.001");
  TRY(metric_read(&limit.metric, option, text, (size_t)(equals - text), log));
  limit.value = strtod(equals + 1, &end);
  if (end == equals + 1 || *end || !isfinite(limit.value))
    return option_fail(log, option, text, "a number after the =, such as over=0.001");
  bool below = strcmp(option->name, "fail-under") == 0;
  if (below != image_metrics[limit.metric].larger_is_better)
    return log_fail(log, STATUS_USAGE, "--%s %s: %s is better when %s: use --fail-%s", option->name, text,
                    image_metrics[limit.metric].name, below ? "smaller" : "larger", below ? "over" : "under");
  if (limits->count == COMPARE_MAX_LIMITS) return option_fail(log, option, text, "no more limits than 32");
  limits->items[limits->count++] = limit;

done:
  return status;
}

static Status read_metrics(void *field, const Option *option, const char *text, Log *log)
{
  Status status = STATUS_OK;
  uint32_t set = 0;
  for (const char *name = text; strcmp(text, "all") != 0; name++) {
    int metric;
    size_t length = strcspn(name, ",");
    TRY(metric_read(&metric, option, name, length, log));
    set |= 1u << metric;
    name += length;
    if (!*name) break;
  }
  *(uint32_t *)field = set ? set : COMPARE_ALL_METRICS;

done:
  return status;
}

static Status read_mask(void *field, const Option *option, const char *text, Log *log)
{
  CompareMasks *masks = field;
  if (masks->count == COMPARE_MAX_MASKS) return option_fail(log, option, text, "no more masks than 8");
  masks->items[masks->count++] = text;
  return STATUS_OK;
}

// A number or a fraction of two.
static Status read_threshold(void *field, const Option *option, const char *text, Log *log)
{
  char *end = NULL;
  double value = strtod(text, &end);
  bool good = end != text;
  if (good && *end == '/') {
    const char *divisor = end + 1;
    value /= strtod(divisor, &end);
    good = end != divisor;
  }
  if (!good || *end || !(value > 0 && value < 1))
    return option_fail(log, option, text, "a number between 0 and 1, such as 2/255 or 0.01");
  *(double *)field = value;
  return STATUS_OK;
}

#define FIELD(member) offsetof(CompareOptions, member)

static const Option compare_options[] = {
    OPTION_HEADING("Verdict:"),
    {"fail-over", 0, "METRIC=X", read_limit, FIELD(limits),
     .help = "exit with 1 where the metric is above X; may be given again for others"},
    {"fail-under", 0, "METRIC=X", read_limit, FIELD(limits), .help = "the same below X, for psnr and ssim"},
    {"threshold", 0, "X", read_threshold, FIELD(threshold),
     .help = "displayed difference above which a pixel is over (2/255)"},

    OPTION_HEADING("What is compared:"),
    {"mask", 0, "FILE:AOV=IDS", read_mask, FIELD(masks),
     .help = "only pixels with these ids, such as a.exr:object=3,5; -1 is the\n"
             "background; given again, pixels that all of them leave"},
    {"ignore-alpha", 0, NULL, option_read_true, FIELD(ignore_alpha), .help = "the colours alone"},
    {"metrics", 0, "LIST", read_metrics, FIELD(metrics),
     .help = "over, rmse, relative-mse, max, p99, max-displayed, p99-displayed,\n"
             "psnr, ssim, flip, hdr-flip, or all (all but hdr-flip, which is for\n"
             "EXR and HDR alone and takes as long as flip for each exposure)"},
    {"pixels-per-degree", 0, "N", option_read_float, FIELD(pixels_per_degree), FLIP_MIN_PIXELS_PER_DEGREE,
     FLIP_MAX_PIXELS_PER_DEGREE, .help = "viewing distance of FLIP (67.02: 0.7 m wide, 3840 pixels, 0.7 m away)"},

    OPTION_HEADING("Output:"),
    {"diff", 0, "FILE", option_read_text, FIELD(difference_path),
     .help = "picture of the displayed difference: black to blue up to the\n"
             "threshold, then green, yellow, red, white; outside the mask grey"},
    {"json", 0, NULL, option_read_true, FIELD(json),
     .help = "the numbers as JSON; null where there is none, and for the psnr of\n"
             "equal pictures"},

    OPTION_HEADING("Machine:"),
    {"threads", 0, "N", option_read_u32, FIELD(threads), 1, 256, .help = "threads (all)"},
    {"max-image-pixels", 0, "N", option_read_u64, FIELD(max_image_pixels), 1, (double)(1ull << 40),
     .help = "limit on the size of a picture (268435456)"},
};

static const CommandLine compare_command_line = {
    .name = "compare",
    .usage =
        "Examples:\n"
        "  frugal compare reference.exr picture.exr\n"
        "  frugal compare reference.png picture.png --fail-over over=0.001 --diff difference.png\n"
        "  frugal compare reference.exr picture.exr --fail-over flip=0.01 --fail-under ssim=0.99\n"
        "  frugal compare reference.exr picture.exr --mask reference.exr:object=3,5 --json\n"
        "\n"
        "Usage: frugal compare REFERENCE PICTURE [OPTIONS]\n"
        "\n"
        "Says how far PICTURE is from REFERENCE: EXR, HDR, PNG or JPEG files of one size and with the same channels.\n"
        "\"Linear\" is radiance; \"displayed\" is sRGB-encoded, clamped to 0..1, over black. A pixel's error is that "
        "of its\n"
        "worst channel, alpha included.\n",
    .closing =
        "\nExit codes: 0 done, within the limits; 1 over a limit; 2 usage; 4 input: not a picture, another size, "
        "other\n"
        "channels, values that are not finite; 5 output.\n",
    .options = compare_options,
    .option_count = sizeof compare_options / sizeof *compare_options,
};

void compare_help(FILE *out) { command_line_help(&compare_command_line, out); }

Status compare_options_parse(CompareOptions *out, int argc, char **argv, Log *log)
{
  Status status = STATUS_OK;
  *out = (CompareOptions){.threshold = IMAGE_THRESHOLD, .max_image_pixels = 1ull << 28};
  TRY(command_line_parse(&out->help, out->paths, 2, out, &compare_command_line, argc, argv, log));
  if (out->help) goto done;
  if (!out->paths[1])
    status = log_fail(log, STATUS_USAGE, "compare: needs two pictures: frugal compare REFERENCE PICTURE");
  else if (out->difference_path && !image_format_of(out->difference_path))
    status = log_fail(log, STATUS_USAGE, "%s: unknown kind of picture: end it in .png, .jpg, .exr or .hdr",
                      out->difference_path);

done:
  return status;
}
