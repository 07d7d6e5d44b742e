#include "image/helper_process.h"

#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>

#include "base/clock.h"
#include "base/process.h"
#include "image/message.h"

enum { TIME_LIMIT_MS = 60000, PAYLOAD_BYTES_PER_MS = 4096 };

static bool helper_find(char program[PATH_MAX])
{
  const char *named = getenv("FRUGAL_IMAGE_HELPER");
  if (named && *named) return snprintf(program, PATH_MAX, "%s", named) < PATH_MAX && access(program, X_OK) == 0;

  char folder[PATH_MAX];
  ssize_t length = readlink("/proc/self/exe", folder, sizeof folder - 1);
  if (length < 0) return false;
  folder[length] = 0;
  *strrchr(folder, '/') = 0;
  // Beside the program, where it is installed, and beside build/tests.
  static const char *const places[] = {"frugal-image", "../libexec/frugal/frugal-image", "../frugal-image"};
  for (size_t i = 0; i < sizeof places / sizeof *places; i++)
    if (snprintf(program, PATH_MAX, "%s/%s", folder, places[i]) < PATH_MAX && access(program, X_OK) == 0) return true;
  return false;
}

// The helper gets its end of the connection as standard input.
static Status helper_spawn(ImageHelper *helper, Log *log)
{
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) return log_no_memory(log, "image helper");
  char *arguments[] = {helper->program, NULL};
  int error = process_spawn(&helper->pid, helper->program, arguments, ends[1]);
  close(ends[1]);
  if (!error) {
    helper->socket = ends[0];
    return STATUS_OK;
  }
  helper->pid = 0;
  close(ends[0]);
  if (error == ENOMEM || error == EAGAIN) return log_no_memory(log, "image helper");
  return log_fail(log, STATUS_NOT_FOUND, "%s: %s: install it again, or set FRUGAL_IMAGE_HELPER", helper->program,
                  strerror(error));
}

// Kills and reaps the helper. Returns its wait status: how it had ended, where it was dead already.
static int helper_bury(ImageHelper *helper)
{
  int ending = 0;
  if (helper->pid > 0) {
    // Before the kill: a helper that is already on its way out tells by its own ending what went wrong.
    close(helper->socket);
    ending = process_bury(helper->pid);
  }
  helper->pid = 0;
  helper->socket = -1;
  return ending;
}

Status image_helper_start(ImageHelper **out, uint64_t max_image_pixels, Log *log)
{
  Status status = STATUS_OK;
  ImageHelper *helper = calloc(1, sizeof *helper);
  if (!helper) return log_no_memory(log, "image helper");
  helper->socket = -1;
  helper->time_limit_ms = TIME_LIMIT_MS;
  helper->max_image_pixels = max_image_pixels;
  if (!helper_find(helper->program)) {
    status = log_fail(log, STATUS_NOT_FOUND,
                      "frugal-image: not found beside this program: build it, or set FRUGAL_IMAGE_HELPER");
    goto done;
  }
  TRY(helper_spawn(helper, log));
  *out = helper;

done:
  if (status) image_helper_stop(helper);
  return status;
}

void image_helper_stop(ImageHelper *helper)
{
  if (!helper) return;
  helper_bury(helper);
  free(helper);
}

// Waits until the reply, or the end of the connection, can be read. False: the time is over.
static bool helper_wait(const ImageHelper *helper, double limit_ms)
{
  struct pollfd connection = {.fd = helper->socket, .events = POLLIN};
  double end_ms = clock_ms() + limit_ms;
  for (;;) {
    double left_ms = end_ms - clock_ms();
    if (left_ms < 0) left_ms = 0;
    int ready = poll(&connection, 1, left_ms < INT_MAX ? (int)left_ms + 1 : INT_MAX);
    if (ready > 0) return true;
    if (ready == 0 || errno != EINTR) return false;
  }
}

static Status helper_died(ImageHelper *helper, const char *role, const char *name, Status failure, Log *log)
{
  siginfo_t info;  // it hung up: give it the moment it needs to die by itself
  for (int i = 0; i < 100; i++) {
    info.si_pid = 0;
    if (waitid(P_PID, (id_t)helper->pid, &info, WEXITED | WNOWAIT | WNOHANG) != 0 || info.si_pid) break;
    usleep(10000);
  }
  int ending = helper_bury(helper);
  if (WIFSIGNALED(ending))
    return log_fail(log, failure, "%s: the %s died (signal %d): the file is damaged or hostile, or memory ran out",
                    name, role, WTERMSIG(ending));
  return log_fail(log, failure, "%s: the %s ended (exit code %d): run %s by hand to see why", name, role,
                  WEXITSTATUS(ending), helper->program);
}

Status helper_distrust(ImageHelper *helper, const char *name, Status failure, Log *log)
{
  helper_bury(helper);
  return log_fail(log, failure, "%s: the image helper's answer makes no sense: is %s of this version?", name,
                  helper->program);
}

Status helper_exchange(ImageHelper *helper, ImageRequest *request, int fd, uint64_t payload_bytes, ImageReply *reply,
                       int *reply_fd, const char *name, Status failure, Log *log)
{
  const char *role = request->operation == IMAGE_ENCODE ? "encoder" : "decoder";
  request->protocol = IMAGE_PROTOCOL;
  *reply_fd = -1;

  // A helper that died since the last request was not killed by this one.
  siginfo_t info = {0};
  if (helper->pid > 0 && (waitid(P_PID, (id_t)helper->pid, &info, WEXITED | WNOWAIT | WNOHANG) != 0 || info.si_pid))
    helper_bury(helper);
  if (helper->pid == 0) {
    Status status = helper_spawn(helper, log);
    if (status) return status;
  }

  if (!message_send(helper->socket, request, sizeof *request, fd)) return helper_died(helper, role, name, failure, log);
  double limit_ms = helper->time_limit_ms + (double)payload_bytes / PAYLOAD_BYTES_PER_MS;
  if (!helper_wait(helper, limit_ms)) {
    helper_bury(helper);
    return log_fail(log, failure,
                    "%s: the %s did not answer within %.0f s: the file is damaged, or the machine too busy", name, role,
                    limit_ms / 1000);
  }
  ssize_t length = message_receive(helper->socket, reply, sizeof *reply, reply_fd);
  if (length == 0 || (length < 0 && errno == ECONNRESET)) return helper_died(helper, role, name, failure, log);
  if (length != sizeof *reply || reply->protocol != IMAGE_PROTOCOL || (!reply->status && *reply_fd < 0))
    return helper_distrust(helper, name, failure, log);
  if (!reply->status) return STATUS_OK;

  reply->message[sizeof reply->message - 1] = 0;
  bool known =
      reply->status == STATUS_BAD_IMAGE || reply->status == STATUS_TOO_LARGE || reply->status == STATUS_NO_MEMORY;
  return log_fail(log, known ? (Status)reply->status : failure, "%s: %s", name, reply->message);
}
