#include "app/app.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void app_text(char *out, size_t size, const char *text)
{
  size_t used = 0;
  for (; *text && used + 1 < size; text++) out[used++] = (unsigned char)*text < ' ' || *text == 0x7f ? '?' : *text;
  out[used] = 0;
}

// A message may quote what a file says, but not steer the terminal by it; compilers' logs have several lines.
static void message_print(const char *kind, const char *message)
{
  fprintf(stderr, "frugal: %s", kind);
  for (; *message; message++) {
    bool steers = ((unsigned char)*message < ' ' && *message != '\n' && *message != '\t') || *message == 0x7f;
    fputc(steers ? '?' : *message, stderr);
  }
  fputc('\n', stderr);
}

void app_log_sink(void *quiet, LogLevel level, const char *message)
{
  if (level == LOG_WARNING) message_print("warning: ", message);
  if (level == LOG_INFO && !*(const bool *)quiet) message_print("", message);
}

void app_log_sink_verbose(void *unused, LogLevel level, const char *message)
{
  message_print(level == LOG_WARNING ? "warning: " : "", message);
}

int app_fail(const Log *log, Status status)
{
  if (log->error[0]) message_print("", log->error);
  return status_exit_code(status);
}

json_t *app_json_text(const char *text)
{
  json_t *string = json_string(text);
  if (string) return string;
  char *ascii = strdup(text);
  for (char *c = ascii; c && *c; c++)
    if ((unsigned char)*c >= 0x80) *c = '?';
  string = ascii ? json_string(ascii) : NULL;
  free(ascii);
  return string;
}

int app_end_output(int exit_code)
{
  bool failed = fflush(stdout) != 0;
  if (!failed && !ferror(stdout)) return exit_code;
  fprintf(stderr, "frugal: standard output: %s: send it to a place that takes it\n",
          failed ? strerror(errno) : "a write failed");
  return status_exit_code(STATUS_OUTPUT);
}
