#include "app/app.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

void app_log_sink(void *quiet, LogLevel level, const char *message)
{
  if (level == LOG_WARNING) fprintf(stderr, "frugal: warning: %s\n", message);
  if (level == LOG_INFO && !*(const bool *)quiet) fprintf(stderr, "frugal: %s\n", message);
}

int app_fail(const Log *log, Status status)
{
  if (log->error[0]) fprintf(stderr, "frugal: %s\n", log->error);
  return status_exit_code(status);
}

// Levenshtein distance, of words of at most 63 letters.
static int edit_distance(const char *a, const char *b)
{
  int row[64], n = (int)strnlen(b, 63);
  for (int j = 0; j <= n; j++) row[j] = j;
  for (int i = 1; a[i - 1]; i++) {
    int diagonal = row[0];
    row[0] = i;
    for (int j = 1; j <= n; j++) {
      int best = diagonal + (a[i - 1] != b[j - 1]);
      if (row[j] + 1 < best) best = row[j] + 1;
      if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
      diagonal = row[j];
      row[j] = best;
    }
  }
  return row[n];
}

const char *app_nearest(const char *word, const char *const *names)
{
  const char *nearest = names[0];
  int least = 1 << 20;
  for (; *names; names++) {
    int distance = edit_distance(word, *names);
    if (distance >= least) continue;
    least = distance;
    nearest = *names;
  }
  return nearest;
}
