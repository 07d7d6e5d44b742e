// The subcommands and what they share.
#pragma once

#include <stddef.h>

#include <jansson.h>

#include "base/log.h"

#define FRUGAL_VERSION "0.1.0"

// Each takes its command line (argv[0] is the subcommand's name) and returns the exit code of the program: results on
// standard output, messages on standard error.
int app_render(int argc, char **argv);
int app_compare(int argc, char **argv);
int app_stability(int argc, char **argv);
int app_info(int argc, char **argv);
int app_devices(int argc, char **argv);

// Sends warnings to standard error, and notes too unless quiet.
void app_log_sink(void *quiet, LogLevel level, const char *message);

// Sends everything there.
void app_log_sink_verbose(void *unused, LogLevel level, const char *message);

// Prints a failure as `frugal: file: cause: hint` and returns its exit code.
int app_fail(const Log *log, Status status);

// Copies what a file says for print, with control characters as '?'.
void app_text(char *out, size_t size, const char *text);

// A JSON string of a path, which may be no UTF-8: other bytes are then '?'. NULL when out of memory.
json_t *app_json_text(const char *text);

// Flushes standard output: 5 and a message where what was printed did not arrive, else `exit_code`. The last call of a
// command that prints results.
int app_end_output(int exit_code);
