// A file that appears whole or not at all: written under a hidden name in the folder it will stand in, then renamed.
#pragma once

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/log.h"

typedef struct OutputFile {
  int fd;
  int slot;               // among the temporary files that image_remove_temporaries knows; -1: none
  bool is_temporary;      // false: standard output, a device or a pipe, written directly
  char path[PATH_MAX];    // as named, for messages
  char target[PATH_MAX];  // with symbolic links resolved
  char temporary[PATH_MAX];
} OutputFile;

// "-" is standard output. A file that exists keeps its mode, a new one gets 0666 less the umask; devices and pipes are
// written as they are, never replaced. Errors: STATUS_OUTPUT.
Status output_file_open(OutputFile *out, const char *path, Log *log);

// Appends `size` bytes. Errors: STATUS_OUTPUT, `log` naming the cause.
Status output_file_write(OutputFile *file, const void *bytes, size_t size, Log *log);

// Closes the file and puts it in its place. On failure nothing is left behind. Errors: STATUS_OUTPUT.
Status output_file_commit(OutputFile *file, Log *log);

// Closes the file and removes it.
void output_file_discard(OutputFile *file);
