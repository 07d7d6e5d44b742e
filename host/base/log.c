#include "base/log.h"

#include <stdio.h>

Status log_fail(Log *log, Status status, const char *format, ...)
{
  if (!log || log->error[0]) return status;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(log->error, sizeof log->error, format, arguments);
  va_end(arguments);
  return status;
}

static void log_send(Log *log, LogLevel level, const char *format, va_list arguments)
{
  if (!log || !log->sink) return;
  char message[1024];
  vsnprintf(message, sizeof message, format, arguments);
  log->sink(log->context, level, message);
}

void log_warn(Log *log, const char *format, ...)
{
  va_list arguments;
  va_start(arguments, format);
  log_send(log, LOG_WARNING, format, arguments);
  va_end(arguments);
}

void log_info(Log *log, const char *format, ...)
{
  va_list arguments;
  va_start(arguments, format);
  log_send(log, LOG_INFO, format, arguments);
  va_end(arguments);
}

void log_debug(Log *log, const char *format, ...)
{
  va_list arguments;
  va_start(arguments, format);
  log_send(log, LOG_DEBUG, format, arguments);
  va_end(arguments);
}

Status log_no_memory(Log *log, const char *what)
{
  return log_fail(log, STATUS_NO_MEMORY, "%s: out of memory: render a smaller scene or picture", what);
}
