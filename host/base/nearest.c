#include "base/nearest.h"

#include <limits.h>
#include <string.h>

bool name_is_index(const char *name) { return *name && strspn(name, "0123456789") == strlen(name); }

enum { MAX_LETTERS = 63 };

static int edit_distance(const char *a, const char *b)
{
  int row[MAX_LETTERS + 1], a_length = (int)strnlen(a, MAX_LETTERS), b_length = (int)strnlen(b, MAX_LETTERS);
  for (int j = 0; j <= b_length; j++) row[j] = j;
  for (int i = 1; i <= a_length; i++) {
    int diagonal = row[0];
    row[0] = i;
    for (int j = 1; j <= b_length; j++) {
      int best = diagonal + (a[i - 1] != b[j - 1]);
      if (row[j] + 1 < best) best = row[j] + 1;
      if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
      diagonal = row[j];
      row[j] = best;
    }
  }
  return row[b_length];
}

const char *nearest_name(const char *word, const char *const *names)
{
  const char *nearest = NULL;
  int least = INT_MAX;
  for (; *names; names++) {
    int distance = edit_distance(word, *names);
    if (distance >= least) continue;
    least = distance;
    nearest = *names;
  }
  return nearest;
}
