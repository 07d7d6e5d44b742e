// The image helper as a process: started, asked, buried, started again.
#pragma once

#include <limits.h>
#include <sys/types.h>

#include "image/image.h"
#include "image/protocol.h"

struct ImageHelper {
  pid_t pid;   // 0 where none runs
  int socket;  // -1 where none runs
  int time_limit_ms;
  uint64_t max_image_pixels;
  char program[PATH_MAX];
};

// Sends a request with the descriptor `fd` (left open) and waits for the reply, at most time_limit_ms plus 1 ms for
// each 4 kB of `payload_bytes`. *reply_fd is the descriptor that came with it, or -1; the caller closes it.
//
// A helper found dead is started anew. One that dies of the request, outlasts the time or talks nonsense is buried, and
// `failure` is returned with a message about `name`; a failure that the helper reports comes with its message.
//
// Errors: `failure`, STATUS_BAD_IMAGE, STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status helper_exchange(ImageHelper *helper, ImageRequest *request, int fd, uint64_t payload_bytes, ImageReply *reply,
                       int *reply_fd, const char *name, Status failure, Log *log);

// For a reply that contradicts itself: buries the helper, and fails.
Status helper_distrust(ImageHelper *helper, const char *name, Status failure, Log *log);
