// The subcommands. Each returns the exit code of the program.
#pragma once

#include "base/log.h"

#define FRUGAL_VERSION "0.1.0"

int app_render(int argc, char **argv);
int app_devices(int argc, char **argv);

// Sends warnings to standard error, and notes too unless quiet.
void app_log_sink(void *quiet, LogLevel level, const char *message);

// Prints a failure as `frugal: file: cause: hint` and returns its exit code.
int app_fail(const Log *log, Status status);

// Of `names` (ended by NULL) the one that differs least from `word`, for "did you mean".
const char *app_nearest(const char *word, const char *const *names);
