#include "app/outputs.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "image/output_file.h"

static Status output_check(const char *path, const RenderOptions *options, Log *log)
{
  struct stat file, scene;
  if (!path || !strcmp(path, "-")) return STATUS_OK;
  bool exists = stat(path, &file) == 0;
  if (exists && !S_ISREG(file.st_mode) && !S_ISDIR(file.st_mode)) return STATUS_OK;
  if (exists && stat(options->scene_path, &scene) == 0 && file.st_dev == scene.st_dev && file.st_ino == scene.st_ino)
    return log_fail(log, STATUS_USAGE, "%s: is the scene itself: name another output", path);
  OutputFile output;
  Status status = output_file_open(&output, path, log);
  if (!status) output_file_discard(&output);
  return status;
}

Status outputs_check(const RenderOptions *options, Log *log)
{
  Status status = STATUS_OK;
  struct stat file;
  if (!options->overwrite && lstat(options->output_path, &file) == 0)
    return log_fail(log, STATUS_OUTPUT, "%s: is there already: name another, or leave out --no-clobber",
                    options->output_path);
  if (!strcmp(options->output_path, "-") && isatty(STDOUT_FILENO))
    return log_fail(log, STATUS_OUTPUT, "standard output: is a terminal: redirect the picture to a file or a program");
  TRY(output_check(options->output_path, options, log));
  TRY(output_check(options->stats_path, options, log));
  TRY(output_check(options->trace_path, options, log));

done:
  return status;
}
