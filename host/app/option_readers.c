#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "app/command_line.h"
#include "base/nearest.h"

Status option_fail(Log *log, const Option *option, const char *text, const char *expected)
{
  return log_fail(log, STATUS_USAGE, "--%s %s: not valid: expected %s", option->name, text, expected);
}

Status option_read_true(void *field, const Option *option, const char *text, Log *log)
{
  *(bool *)field = true;
  return STATUS_OK;
}

Status option_read_false(void *field, const Option *option, const char *text, Log *log)
{
  *(bool *)field = false;
  return STATUS_OK;
}

Status option_read_text(void *field, const Option *option, const char *text, Log *log)
{
  if (!*text) return option_fail(log, option, text, "a name");
  *(const char **)field = text;
  return STATUS_OK;
}

Status option_read_u64(void *field, const Option *option, const char *text, Log *log)
{
  char *end = NULL, expected[96];
  errno = 0;
  unsigned long long value = strtoull(text, &end, 10);
  if (!isdigit((unsigned char)text[0]) || *end || errno || (double)value < option->low ||
      (double)value > option->high) {
    snprintf(expected, sizeof expected, "a whole number from %.0f to %.0f", option->low, option->high);
    return option_fail(log, option, text, expected);
  }
  *(uint64_t *)field = value;
  return STATUS_OK;
}

Status option_read_u32(void *field, const Option *option, const char *text, Log *log)
{
  uint64_t value = 0;
  Status status = option_read_u64(&value, option, text, log);
  if (!status) *(uint32_t *)field = (uint32_t)value;
  return status;
}

static Status number_read(double *out, const Option *option, const char *text, Log *log)
{
  char *end = NULL, expected[96];
  double value = strtod(text, &end);
  if (end == text || *end || !(value >= option->low && value <= option->high)) {
    snprintf(expected, sizeof expected, "a number from %g to %g", option->low, option->high);
    return option_fail(log, option, text, expected);
  }
  *out = value;
  return STATUS_OK;
}

Status option_read_float(void *field, const Option *option, const char *text, Log *log)
{
  double value = 0;
  Status status = number_read(&value, option, text, log);
  if (!status) *(float *)field = (float)value;
  return status;
}

Status option_read_radians(void *field, const Option *option, const char *text, Log *log)
{
  double degrees = 0;
  Status status = number_read(&degrees, option, text, log);
  if (!status) *(double *)field = degrees * M_PI / 180;
  return status;
}

Status option_read_bytes(void *field, const Option *option, const char *text, Log *log)
{
  char *end = NULL;
  double value = strtod(text, &end);
  static const char units[] = "kMG";
  const char *unit = end != text && *end ? strchr(units, *end) : NULL;
  if (unit) {
    value = ldexp(value, 10 * (int)(unit - units + 1));
    end++;
  }
  if (end == text || *end || !(value >= 1 && value <= 1e18))
    return option_fail(log, option, text, "a size such as 512M or 4G");
  *(uint64_t *)field = (uint64_t)value;
  return STATUS_OK;
}

Status option_read_word(void *field, const Option *option, const char *text, Log *log)
{
  for (int i = 0; option->words[i]; i++) {
    if (strcmp(option->words[i], text) != 0) continue;
    *(int *)field = i;
    return STATUS_OK;
  }
  return log_fail(log, STATUS_USAGE, "--%s %s: no such value: did you mean '%s'?", option->name, text,
                  nearest_name(text, option->words));
}

Status option_read_name(void *field, const Option *option, const char *text, Log *log)
{
  int index = 0;
  Status status = option_read_word(&index, option, text, log);
  if (!status) *(const char **)field = option->words[index];
  return status;
}

Status option_read_color(void *field, const Option *option, const char *text, Log *log)
{
  float *linear = field;
  if (text[0] != '#' || strlen(text) != 7 || strspn(text + 1, "0123456789abcdefABCDEF") != 6)
    return option_fail(log, option, text, "a colour such as #8090a0");
  unsigned long rgb = strtoul(text + 1, NULL, 16);
  for (int c = 0; c < 3; c++) {
    double s = (double)(rgb >> (16 - 8 * c) & 255) / 255;
    linear[c] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
  }
  return STATUS_OK;
}
