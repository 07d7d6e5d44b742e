#include "device/fault.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

bool fault_due(const char *kind)
{
  static atomic_ulong calls;
  const char *wanted = getenv("FRUGAL_FAULT");
  size_t length = strlen(kind);
  if (!wanted || strncmp(wanted, kind, length) != 0 || wanted[length] != ':') return false;
  unsigned long call = atomic_fetch_add(&calls, 1) + 1, first = strtoul(wanted + length + 1, NULL, 10);
  return call == first || (call > first && strcmp(kind, "corrupt") != 0);
}
