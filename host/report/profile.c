#include "report/profile.h"

#include <stdlib.h>
#include <string.h>

#include "image/output_file.h"

typedef struct Row {
  const char *name;
  bool on_device;
  uint32_t launches;
  uint64_t items;
  double ms;
} Row;

// Sums spans by name. *out is freed by the caller; returns how many rows, 0 when out of memory.
static size_t rows_make(Row **out, const Timeline *timeline)
{
  Row *rows = calloc(timeline->count + 1, sizeof *rows);
  size_t count = 0;
  if (!rows) return 0;
  for (size_t i = 0; i < timeline->count; i++) {
    const Span *span = &timeline->spans[i];
    size_t at = 0;
    while (at < count && strcmp(rows[at].name, span->name) != 0) at++;
    if (at == count) rows[count++] = (Row){.name = span->name, .on_device = span->on_device};
    rows[at].launches++;
    rows[at].items += span->items;
    rows[at].ms += span->end_ms - span->begin_ms;
  }
  *out = rows;
  return count;
}

void profile_print(FILE *out, const Timeline *timeline, double total_ms)
{
  Row *rows = NULL;
  size_t count = rows_make(&rows, timeline);
  fprintf(out, "%-34s %8s %12s %10s %10s\n", "", "launches", "items", "ms", "M items/s");
  for (int device = 0; device < 2; device++) {
    for (size_t i = 0; i < count; i++) {
      const Row *row = &rows[i];
      if (row->on_device != device) continue;
      fprintf(out, "%-34s %8u ", row->name, row->launches);
      if (row->items)
        fprintf(out, "%12llu %10.2f %10.1f\n", (unsigned long long)row->items, row->ms,
                1e-3 * (double)row->items / row->ms);
      else
        fprintf(out, "%12s %10.2f\n", "", row->ms);
    }
  }
  fprintf(out, "%-34s %8s %12s %10.2f\n", "whole run", "", "", total_ms);
  free(rows);
}

json_t *profile_json(const Timeline *timeline)
{
  Row *rows = NULL;
  size_t count = rows_make(&rows, timeline);
  json_t *list = json_array();
  for (size_t i = 0; i < count && list; i++)
    json_array_append_new(
        list, json_pack("{s:s, s:b, s:i, s:I, s:f}", "name", rows[i].name, "on_device", rows[i].on_device, "launches",
                        rows[i].launches, "items", (json_int_t)rows[i].items, "ms", rows[i].ms));
  free(rows);
  return list;
}

Status profile_write_trace(const char *path, const Timeline *timeline, Log *log)
{
  Status status = STATUS_OK;
  json_t *events = json_array(), *root = NULL;
  for (size_t i = 0; i < timeline->count && events; i++) {
    const Span *span = &timeline->spans[i];
    json_array_append_new(events, json_pack("{s:s, s:s, s:f, s:f, s:i, s:i, s:{s:I}}", "name", span->name, "ph", "X",
                                            "ts", 1e3 * (span->begin_ms - timeline->spans[0].begin_ms), "dur",
                                            1e3 * (span->end_ms - span->begin_ms), "pid", 1, "tid",
                                            span->on_device ? 2 : 1, "args", "items", (json_int_t)span->items));
  }
  root = json_pack("{s:o, s:s}", "traceEvents", events, "displayTimeUnit", "ms");
  TRY(json_write(path, root, log));

done:
  json_decref(root);
  return status;
}

Status json_write(const char *path, const json_t *value, Log *log)
{
  Status status = STATUS_OK;
  OutputFile file = {.fd = -1, .slot = -1};
  char *text = value ? json_dumps(value, JSON_INDENT(2)) : NULL;
  if (!text) return log_no_memory(log, path);
  TRY(output_file_open(&file, path, log));
  TRY(output_file_write(&file, text, strlen(text), log));
  TRY(output_file_write(&file, "\n", 1, log));
  TRY(output_file_commit(&file, log));

done:
  if (status) output_file_discard(&file);
  free(text);
  return status;
}
