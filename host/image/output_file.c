#include "image/output_file.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "image/image.h"

enum { TEMPORARIES = 16, NAME_TRIES = 100 };

typedef enum SlotState { SLOT_FREE, SLOT_CLAIMED, SLOT_LIVE } SlotState;

// Read by a signal handler: `path` may be looked at only while `state` is SLOT_LIVE.
static struct Temporary {
  atomic_int state;
  char path[PATH_MAX];
} temporaries[TEMPORARIES];

void image_remove_temporaries(void)
{
  for (int i = 0; i < TEMPORARIES; i++)
    if (atomic_load(&temporaries[i].state) == SLOT_LIVE) unlink(temporaries[i].path);
}

static int temporary_remember(const char *path)
{
  for (int i = 0; i < TEMPORARIES; i++) {
    int expected = SLOT_FREE;
    if (!atomic_compare_exchange_strong(&temporaries[i].state, &expected, SLOT_CLAIMED)) continue;
    memcpy(temporaries[i].path, path, strlen(path) + 1);
    atomic_store(&temporaries[i].state, SLOT_LIVE);
    return i;
  }
  return -1;
}

static void temporary_forget(int slot)
{
  if (slot >= 0) atomic_store(&temporaries[slot].state, SLOT_FREE);
}

static Status output_fail(const char *path, int error, Log *log)
{
  const char *hint = "choose another place";
  switch (error) {
    case ENOENT: hint = "make the folder first"; break;
    case ENOTDIR: hint = "a part of the path is a file, not a folder"; break;
    case ENOSPC:
    case EDQUOT: hint = "free some space, or choose another disk"; break;
    case EPIPE: hint = "the program that reads it has ended"; break;
  }
  return log_fail(log, STATUS_OUTPUT, "%s: %s: %s", path, strerror(error), hint);
}

static Status temporary_create(OutputFile *file, Log *log)
{
  const char *slash = strrchr(file->target, '/');
  int folder_length = slash ? (int)(slash - file->target) + 1 : 0;
  for (int i = 0; i < NAME_TRIES; i++) {
    unsigned number = 0;
    if (getrandom(&number, sizeof number, GRND_NONBLOCK) < 0) number = (unsigned)getpid() + (unsigned)i;
    int length = snprintf(file->temporary, sizeof file->temporary, "%.*s.frugal-%06x.tmp", folder_length, file->target,
                          number & 0xffffff);
    if (length >= (int)sizeof file->temporary) return output_fail(file->path, ENAMETOOLONG, log);
    file->slot = temporary_remember(file->temporary);
    file->fd = open(file->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file->fd >= 0) return STATUS_OK;
    int error = errno;
    temporary_forget(file->slot);
    if (error != EEXIST) return output_fail(file->path, error, log);
  }
  return output_fail(file->path, EEXIST, log);
}

Status output_file_open(OutputFile *out, const char *path, Log *log)
{
  struct stat old;
  *out = (OutputFile){.fd = -1, .slot = -1};
  if (strlen(path) >= sizeof out->path) return output_fail(path, ENAMETOOLONG, log);
  strcpy(out->path, path);
  if (strcmp(path, "-") == 0) {
    strcpy(out->path, "standard output");
    fflush(stdout);
    out->fd = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
    return out->fd < 0 ? output_fail(out->path, errno, log) : STATUS_OK;
  }

  if (!realpath(path, out->target)) strcpy(out->target, path);
  bool exists = stat(out->target, &old) == 0;
  if (exists && !S_ISREG(old.st_mode)) {
    out->fd = open(out->target, O_WRONLY | O_CLOEXEC);
    return out->fd < 0 ? output_fail(path, errno, log) : STATUS_OK;
  }
  if (exists && access(out->target, W_OK) != 0) return output_fail(path, errno, log);
  Status status = temporary_create(out, log);
  if (status) return status;
  out->is_temporary = true;
  if (exists) fchmod(out->fd, old.st_mode & 0777);
  return STATUS_OK;
}

// write(), without the SIGPIPE that a closed pipe would raise.
static ssize_t write_quietly(int fd, const void *bytes, size_t size)
{
  sigset_t pipe_signal, before, pending;
  sigemptyset(&pipe_signal);
  sigaddset(&pipe_signal, SIGPIPE);
  sigpending(&pending);
  pthread_sigmask(SIG_BLOCK, &pipe_signal, &before);
  ssize_t written = write(fd, bytes, size);
  int error = errno;
  if (written < 0 && error == EPIPE && !sigismember(&pending, SIGPIPE))
    sigtimedwait(&pipe_signal, NULL, &(struct timespec){0});
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  errno = error;
  return written;
}

Status output_file_write(OutputFile *file, const void *bytes, size_t size, Log *log)
{
  for (size_t done = 0; done < size;) {
    ssize_t written = write_quietly(file->fd, (const char *)bytes + done, size - done);
    if (written < 0 && errno == EAGAIN)
      poll(&(struct pollfd){.fd = file->fd, .events = POLLOUT}, 1, -1);
    else if (written < 0 && errno != EINTR)
      return output_fail(file->path, errno, log);
    if (written > 0) done += (size_t)written;
  }
  return STATUS_OK;
}

Status output_file_commit(OutputFile *file, Log *log)
{
  int error = close(file->fd) == 0 ? 0 : errno;
  file->fd = -1;
  if (!error && file->is_temporary && rename(file->temporary, file->target) != 0) error = errno;
  if (error) {
    output_fail(file->path, error, log);
    output_file_discard(file);
    return STATUS_OUTPUT;
  }
  temporary_forget(file->slot);
  return STATUS_OK;
}

void output_file_discard(OutputFile *file)
{
  if (file->fd >= 0) close(file->fd);
  if (file->is_temporary) unlink(file->temporary);
  temporary_forget(file->slot);
  *file = (OutputFile){.fd = -1, .slot = -1};
}
