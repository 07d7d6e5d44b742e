#include "app/frames.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char field_name[] = "frame";
enum { MOST_DIGITS = 9 };

// A whole number at *text, which moves behind it; false where there is none.
static bool number_read(uint32_t *out, const char **text)
{
  char *end = NULL;
  if (**text < '0' || **text > '9') return false;
  unsigned long value = strtoul(*text, &end, 10);
  if (value > INT32_MAX) return false;
  *out = (uint32_t)value;
  *text = end;
  return true;
}

// What stands behind `sign` at *text, if that is there.
static bool part_read(uint32_t *out, char sign, const char **text)
{
  if (**text != sign) return true;
  ++*text;
  return number_read(out, text);
}

Status option_read_frames(void *field, const Option *option, const char *text, Log *log)
{
  FrameRange range = {.given = true, .step = 1, .all = !strcmp(text, "all")};
  const char *at = text;
  bool valid = range.all || number_read(&range.first, &at);
  range.last = range.first;
  valid = valid && (range.all || (part_read(&range.last, '-', &at) && part_read(&range.step, 'x', &at) && !*at));
  if (!valid || range.last < range.first || range.step == 0)
    return option_fail(log, option, text, "a frame such as 12, frames such as 0-47, each second one, 0-47x2, or all");
  *(FrameRange *)field = range;
  return STATUS_OK;
}

uint32_t frames_last(double length_s, double fps)
{
  double last = floor(length_s * fps * (1 + 1e-9));
  return last < INT32_MAX ? (uint32_t)last : INT32_MAX;
}

uint64_t frames_count(const FrameRange *range)
{
  return range->given ? 1ull + (range->last - range->first) / range->step : 1;
}

// Behind the `{frame...}` that `text` starts with; NULL where it does not. *digits are those at least.
static const char *field_end(const char *text, int *digits)
{
  const size_t length = strlen(field_name);
  *digits = 0;
  if (*text++ != '{' || strncmp(text, field_name, length) != 0) return NULL;
  text += length;
  if (*text == ':' && text[1] >= '0' && text[1] <= '9') {
    char *end = NULL;
    unsigned long value = strtoul(text + 1, &end, 10);
    if (value > MOST_DIGITS) return NULL;
    *digits = (int)value;
    text = end;
  }
  return *text == '}' ? text + 1 : NULL;
}

bool path_names_frame(const char *path)
{
  int digits;
  for (; path && *path; path++) {
    if (path[0] == '{' && path[1] == '{')
      path++;
    else if (field_end(path, &digits))
      return true;
  }
  return false;
}

Status path_of_frame(char **out, const char *path, uint32_t frame, Log *log)
{
  Status status = STATUS_OK;
  char *text = NULL;
  size_t size = 0;
  *out = NULL;
  if (!path) return STATUS_OK;
  FILE *stream = open_memstream(&text, &size);
  if (!stream) return log_no_memory(log, path);
  for (const char *at = path; *at && !status;) {
    int digits;
    const char *end = field_end(at, &digits);
    if (end)
      fprintf(stream, "%0*u", digits, frame);
    else if (*at == '{' && at[1] != '{')
      status =
          log_fail(log, STATUS_USAGE, "%s: unknown name in braces: write {frame} or {frame:04}, {{ for a brace", path);
    else
      fputc(*at, stream);
    at = end ? end : at + (*at == '{' ? 2 : 1);
  }
  if (fclose(stream) != 0 && !status) status = log_no_memory(log, path);
  if (status)
    free(text);
  else
    *out = text;
  return status;
}
