#include "base/status.h"

int status_exit_code(Status status)
{
  switch (status) {
    case STATUS_OK: return 0;
    case STATUS_FAILED: return 1;
    case STATUS_USAGE: return 2;
    case STATUS_NO_DEVICE:
    case STATUS_DEVICE: return 3;
    case STATUS_NOT_FOUND:
    case STATUS_BAD_SCENE:
    case STATUS_BAD_IMAGE:
    case STATUS_UNSUPPORTED:
    case STATUS_TOO_LARGE:
    case STATUS_NO_MEMORY: return 4;
    case STATUS_OUTPUT: return 5;
    case STATUS_INTERRUPTED: return 130;
  }
  return 1;
}
