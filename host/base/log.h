// Messages. A library function reports through a Log and never prints: the program gives the Log a sink.
#pragma once

#include <stdarg.h>
#include <stdbool.h>

#include "base/status.h"

typedef enum LogLevel { LOG_ERROR, LOG_WARNING, LOG_INFO, LOG_DEBUG } LogLevel;

typedef void (*LogSink)(void *context, LogLevel level, const char *message);

// `error` holds the first failure since the log was made or cleared, as `file: cause: hint`.
typedef struct Log {
  LogSink sink;  // NULL: messages below LOG_ERROR are dropped
  void *context;
  char error[1024];
} Log;

// Records a failure (the first one stays) and returns `status`, so that it can be returned in one line. The failure
// is not sent to the sink: whoever ends the work prints `error` once.
Status log_fail(Log *log, Status status, const char *format, ...) __attribute__((format(printf, 3, 4)));

// Sends a warning, a note, or a detail that only who asks wants to know, to the sink at once.
void log_warn(Log *log, const char *format, ...) __attribute__((format(printf, 2, 3)));
void log_info(Log *log, const char *format, ...) __attribute__((format(printf, 2, 3)));
void log_debug(Log *log, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Records that there was no memory for `what`, and returns STATUS_NO_MEMORY.
Status log_no_memory(Log *log, const char *what);
