// What ran when, for people (--profile), for scripts (--stats) and for a trace viewer (--trace).
#pragma once

#include <stdio.h>

#include <jansson.h>

#include "base/log.h"
#include "base/timeline.h"

// A table by name: launches, items, milliseconds and millions of items a second; host steps first. Spans of the same
// name are summed.
void profile_print(FILE *out, const Timeline *timeline, double total_ms);

// [{"name", "on_device", "launches", "items", "ms"}], in the order of their first start; NULL when out of memory.
json_t *profile_json(const Timeline *timeline);

// Writes the spans in Chrome's trace format (chrome://tracing, Perfetto): one row for the host, one for the device.
// Errors: STATUS_OUTPUT.
Status profile_write_trace(const char *path, const Timeline *timeline, Log *log);

// Writes a JSON value to a file, or to standard output for "-"; the file appears whole or not at all.
// Errors: STATUS_OUTPUT, STATUS_NO_MEMORY (value is NULL).
Status json_write(const char *path, const json_t *value, Log *log);
