// frugal stability: where each method fails, measured, and whether it says so.

#include "stability/stability.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "app/app.h"
#include "app/command_line.h"
#include "base/nearest.h"
#include "base/parallel.h"
#include "report/image_compare.h"
#include "report/profile.h"

typedef struct StabilityOptions {
  const char *only, *output, *device;
  uint32_t threads;
  bool quick, json, list, verbose, help;
} StabilityOptions;

#define FIELD(member) offsetof(StabilityOptions, member)

static const Option stability_options[] = {
    OPTION_HEADING("What is measured:"),
    {"only", 0, "NAME", option_read_text, FIELD(only), .help = "this row or table alone, as --list names them"},
    {"quick", 0, NULL, option_read_true, FIELD(quick), .help = "fewer values, smaller pictures: about 10 s"},
    {"list", 0, NULL, option_read_true, FIELD(list), .help = "print the rows, measure nothing"},

    OPTION_HEADING("Output:"),
    {"output", 'o', "DIR", option_read_text, FIELD(output),
     .help = "a folder for each row's worst case: DIR/ROW-METHOD.png,\n"
             "-reference.png and -difference.png (as of frugal compare)"},
    {"json", 0, NULL, option_read_true, FIELD(json), .help = "rows with their curves as JSON; null: no number"},
    {"verbose", 'v', NULL, option_read_true, FIELD(verbose), .help = "the curves too"},

    OPTION_HEADING("Machine:"),
    {"device", 0, "DEVICE", option_read_text, FIELD(device),
     .help = "index or part of a name as in `frugal devices`, cpu, gpu\n(the best)"},
    {"threads", 0, "N", option_read_u32, FIELD(threads), 1, 256, .help = "of the host and of a CPU device (all)"},
};

static const CommandLine stability_command_line = {
    .name = "stability",
    .usage =
        "Examples:\n"
        "  frugal stability --quick\n"
        "  frugal stability --only acne --verbose --output worst\n"
        "  frugal stability --json | jq '.rows[] | select(.verdict == \"silent\") | .name'\n"
        "\n"
        "Usage: frugal stability [OPTIONS]\n"
        "\n"
        "The catalogue of failures: for each a small scene that triggers it, rendered by the methods that may fail "
        "there\nand by rays, over a sweep of values. A row\n"
        "  holds    where what is measured is within the stated bound everywhere\n"
        "  says so  where it is not, but within what the method itself says that it may be off by there\n"
        "  silent   where it is beyond that\n"
        "The table shows of each row the worst value: what was measured, the bound (-: none is promised there), and "
        "what the\nmethod warns of.\n",
    .closing = "\nExit codes: 0 done, 1 a row is silent, 2 usage, 3 no usable device, 4 memory, 5 output.\n",
    .options = stability_options,
    .option_count = sizeof stability_options / sizeof *stability_options,
};

// One row by one method.
typedef struct Entry {
  const char *table;
  const StabilityRow *row;
  ShadowMethod method;
  StabilityCurve curve;
} Entry;

enum { ENTRIES_MOST = 128 };

typedef struct StabilityJob {
  StabilityOptions options;
  Entry entries[ENTRIES_MOST];
  size_t entry_count, silent_count;
  Lab lab;
  ImageHelper *images;
} StabilityJob;

static void job_free(StabilityJob *job)
{
  for (size_t i = 0; i < job->entry_count; i++) stability_curve_free(&job->entries[i].curve);
  image_helper_stop(job->images);
  device_close(job->lab.device);
}

static bool is_wanted(const StabilityOptions *options, const StabilityTable *table, const StabilityRow *row)
{
  return !options->only || !strcmp(options->only, row->name) || !strcmp(options->only, table->name);
}

static Status entries_choose(StabilityJob *job, Log *log)
{
  const char *names[ENTRIES_MOST] = {0};
  size_t name_count = 0;
  for (int t = 0; t < STABILITY_TABLES; t++) {
    const StabilityTable *table = stability_tables[t];
    names[name_count++] = table->name;
    for (uint32_t i = 0; i < table->row_count; i++) {
      const StabilityRow *row = &table->rows[i];
      names[name_count++] = row->name;
      if (!is_wanted(&job->options, table, row)) continue;
      for (ShadowMethod method = SHADOWS_NONE; method <= SHADOWS_AREA; method++)
        if (stability_row_has(row, method) && job->entry_count < ENTRIES_MOST)
          job->entries[job->entry_count++] = (Entry){.table = table->name, .row = row, .method = method};
    }
  }
  if (job->entry_count) return STATUS_OK;
  return log_fail(log, STATUS_USAGE, "--only %s: no such row: did you mean '%s'? (frugal stability --list)",
                  job->options.only, nearest_name(job->options.only, names));
}

static void rows_list(const StabilityJob *job)
{
  for (size_t i = 0; i < job->entry_count; i++) {
    const StabilityRow *row = job->entries[i].row;
    if (i > 0 && job->entries[i - 1].row == row) continue;
    printf("%-10s %-22s %s: %s\n", job->entries[i].table, row->name, row->failure, row->scene);
  }
}

static Status folder_make(const char *folder, Log *log)
{
  struct stat there;
  if (mkdir(folder, 0777) == 0 || (stat(folder, &there) == 0 && S_ISDIR(there.st_mode))) return STATUS_OK;
  return log_fail(log, STATUS_OUTPUT, "%s: no folder, and none can be made: name another --output", folder);
}

static Status picture_write_png(StabilityJob *job, const char *path, const Image *image, Log *log)
{
  size_t values = (size_t)image->width * image->height * 4;
  float *shown = malloc(values * sizeof *shown);
  if (!shown) return log_no_memory(log, path);
  for (size_t i = 0; i < values; i++) shown[i] = (float)lab_displayed((double)image->pixels[i]);
  const ImageChannels group = {{"R", "G", "B"}, 3, 4, shown, 0};
  const ImageOutput output = {
      .width = image->width, .height = image->height, .groups = &group, .group_count = 1, .bit_depth = 8};
  Status status = image_write(job->images, path, "png", &output, log);
  free(shown);
  return status;
}

static Status worst_write(StabilityJob *job, const Entry *entry, Log *log)
{
  Status status = STATUS_OK;
  const LabPictures *pictures = &entry->curve.pictures;
  char stem[4096], path[4200];
  if (!pictures->method.pixels) return STATUS_OK;
  snprintf(stem, sizeof stem, "%s/%s%s%s", job->options.output, entry->row->name, entry->row->methods ? "-" : "",
           entry->row->methods ? stability_method_name(entry->row, entry->method) : "");
  snprintf(path, sizeof path, "%s.png", stem);
  TRY(picture_write_png(job, path, &pictures->method, log));
  snprintf(path, sizeof path, "%s-reference.png", stem);
  TRY(picture_write_png(job, path, &pictures->reference, log));
  snprintf(path, sizeof path, "%s-difference.png", stem);
  TRY(image_difference_write(job->images, path, &pictures->reference, &pictures->method, NULL, log));

done:
  return status;
}

static void number_print(double value)
{
  if (isinf(value))
    printf(" %9s", "-");
  else
    printf(" %9.3g", value);
}

static void entry_print(const StabilityJob *job, const Entry *entry)
{
  const StabilityCurve *curve = &entry->curve;
  const StabilityPoint *worst = &curve->points[curve->worst];
  printf("%-21s %-7s %-8s", entry->row->name, stability_method_name(entry->row, entry->method),
         stability_verdict_name(curve->verdict));
  number_print(worst->measured);
  number_print(worst->bound);
  number_print(worst->warned);
  printf("  %g %s\n", worst->value, entry->row->parameter);
  if (job->options.verbose) {
    printf("  %s; %s; bound: %s\n", entry->row->scene, entry->row->quantity, entry->row->bound);
    for (uint32_t i = 0; i < curve->count; i++) {
      printf("%38s", "");
      number_print(curve->points[i].measured);
      number_print(curve->points[i].bound);
      number_print(curve->points[i].warned);
      printf("  %g\n", curve->points[i].value);
    }
  }
  fflush(stdout);
}

static json_t *number_json(double value) { return isfinite(value) ? json_real(value) : json_null(); }

static json_t *entry_json(const Entry *entry)
{
  const StabilityRow *row = entry->row;
  const StabilityCurve *curve = &entry->curve;
  json_t *points = json_array();
  for (uint32_t i = 0; i < curve->count; i++) {
    const StabilityPoint *point = &curve->points[i];
    json_array_append_new(
        points, json_pack("{s:f, s:o, s:o, s:o}", "value", point->value, "measured", number_json(point->measured),
                          "bound", number_json(point->bound), "warned", number_json(point->warned)));
  }
  return json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:i, s:o}", "table", entry->table, "name", row->name,
                   "method", stability_method_name(row, entry->method), "failure", row->failure, "scene", row->scene,
                   "parameter", row->parameter, "quantity", row->quantity, "bound", row->bound, "verdict",
                   stability_verdict_name(curve->verdict), "worst", (int)curve->worst, "points", points);
}

static Status json_print(const StabilityJob *job, Log *log)
{
  json_t *rows = json_array();
  for (size_t i = 0; i < job->entry_count; i++) json_array_append_new(rows, entry_json(&job->entries[i]));
  json_t *report =
      json_pack("{s:s, s:s, s:b, s:I, s:o}", "version", FRUGAL_VERSION, "device", device_info(job->lab.device)->name,
                "quick", (int)job->options.quick, "silent", (json_int_t)job->silent_count, "rows", rows);
  Status status = json_write("-", report, log);
  json_decref(report);
  return status;
}

static Status entries_measure(StabilityJob *job, Log *log)
{
  Status status = STATUS_OK;
  if (!job->options.json)
    printf("%-21s %-7s %-8s %9s %9s %9s  at\n", "row", "method", "verdict", "measured", "bound", "warned");
  for (size_t i = 0; i < job->entry_count; i++) {
    Entry *entry = &job->entries[i];
    TRY(stability_measure(&entry->curve, &job->lab, entry->row, entry->method));
    job->silent_count += entry->curve.verdict == VERDICT_SILENT;
    if (!job->options.json) entry_print(job, entry);
    if (job->options.output) TRY(worst_write(job, entry, log));
    lab_pictures_free(&entry->curve.pictures);
  }
  if (job->options.json) TRY(json_print(job, log));
  if (job->silent_count)
    status = log_fail(log, STATUS_FAILED, "stability: %zu of %zu rows are silent: --output DIR shows their worst cases",
                      job->silent_count, job->entry_count);

done:
  return status;
}

int app_stability(int argc, char **argv)
{
  Status status = STATUS_OK;
  StabilityJob *job = calloc(1, sizeof *job);
  Log log = {.sink = app_log_sink, .context = &(bool){true}};
  if (!job) return app_fail(&log, log_no_memory(&log, "stability"));
  TRY(command_line_parse(&job->options.help, NULL, 0, &job->options, &stability_command_line, argc, argv, &log));
  if (job->options.help) {
    command_line_help(&stability_command_line, stdout);
    goto done;
  }
  TRY(entries_choose(job, &log));
  if (job->options.list) {
    rows_list(job);
    goto done;
  }
  parallel_set_threads(job->options.threads);
  if (job->options.output) TRY(folder_make(job->options.output, &log));
  if (job->options.output) TRY(image_helper_start(&job->images, 1 << 24, &log));
  TRY(device_open(&job->lab.device, job->options.device, job->options.threads, NULL, &log));
  job->lab.quick = job->options.quick;
  job->lab.log = &log;
  TRY(entries_measure(job, &log));

done:
  job_free(job);
  free(job);
  return app_end_output(status ? app_fail(&log, status) : 0);
}
