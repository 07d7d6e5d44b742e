// frugal-image: decodes and encodes image files for the program that started it, over the socket that is its standard
// input, so that OpenImageIO's start-up is hidden and a hostile file can break nothing but this process.

#include <fcntl.h>
#include <malloc.h>
#include <math.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "image/helper/oiio_shim.h"
#include "image/helper/signature.h"
#include "image/message.h"

// There in a build under the leak sanitizer alone. This process ends by _exit or by a signal, where it would not look.
extern void __lsan_do_recoverable_leak_check(void) __attribute__((weak));

enum { WATCHER_STACK_BYTES = 1 << 17 };

// Memory of a decode: the pixels as radiance, as much again for the decoder, and the libraries with their threads.
static const uint64_t DECODE_BYTES_PER_PIXEL = 32, BASE_BYTES = 2ull << 30;

typedef struct FdPath {
  char text[32];
} FdPath;

static FdPath fd_path(int fd)
{
  FdPath path;
  snprintf(path.text, sizeof path.text, "/proc/self/fd/%d", fd);
  return path;
}

static void memory_limit(uint64_t bytes)
{
  struct rlimit limit;
  getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = bytes < limit.rlim_max ? bytes : limit.rlim_max;
#ifndef __SANITIZE_ADDRESS__  // its shadow memory is address space as well, terabytes of it
  setrlimit(RLIMIT_AS, &limit);
#endif
}

static float linear_from_srgb(float v) { return v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f); }

static void radiance_clean(float *pixels, uint64_t count, bool is_srgb, ImageReply *reply)
{
  for (float *p = pixels; p < pixels + 4 * count; p += 4) {
    if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]) || !isfinite(p[3])) {
      p[0] = p[1] = p[2] = 0;
      if (!isfinite(p[3])) p[3] = 1;
      reply->not_finite++;
    }
    bool negative = p[0] < 0 || p[1] < 0 || p[2] < 0 || p[3] < 0;
    reply->negative += negative;
    for (int c = 0; negative && c < 4; c++)
      if (p[c] < 0) p[c] = 0;
    for (int c = 0; is_srgb && c < 3; c++) p[c] = linear_from_srgb(p[c]);
  }
}

// The file behind `fd` in memory; *bytes stays MAP_FAILED where it is empty. The caller unmaps it.
static Status file_map(uint8_t **bytes, size_t *size, int fd, Log *log)
{
  struct stat file = {0};
  if (fstat(fd, &file) != 0 || file.st_size <= 0) return STATUS_OK;
  *size = (size_t)file.st_size;
  *bytes = mmap(NULL, *size, PROT_READ, MAP_PRIVATE, fd, 0);
  if (*bytes == MAP_FAILED) return log_fail(log, STATUS_NO_MEMORY, "%zu bytes: the file is too large to map", *size);
  return STATUS_OK;
}

static Status values_map(void **values, int *fd, size_t size, const ImageReply *reply, Log *log)
{
  *fd = memfd_create("pixels", MFD_CLOEXEC);
  if (*fd >= 0 && ftruncate(*fd, (off_t)size) == 0)
    *values = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, *fd, 0);
  if (*values == MAP_FAILED)
    return log_fail(log, STATUS_NO_MEMORY, "%u x %u pixels: out of memory", reply->width, reply->height);
  return STATUS_OK;
}

// Pixels for image_read: RGBA of one kind, cleaned where it is radiance.
static Status image_decode(ImageReply *reply, int *pixels_fd, OiioInput *input, ImageKind kind, bool is_srgb, Log *log)
{
  Status status = STATUS_OK;
  void *pixels = MAP_FAILED;
  uint64_t count = (uint64_t)reply->width * reply->height;
  size_t bytes = count * (kind == IMAGE_TEXTURE ? 4 : 4 * sizeof(float));
  if (kind == IMAGE_TEXTURE && !is_srgb)
    return log_fail(log, STATUS_BAD_IMAGE, "holds radiance, not a texture: convert it to PNG or JPEG");
  TRY(values_map(&pixels, pixels_fd, bytes, reply, log));
  TRY(oiio_decode(input, kind, pixels, log));
  if (kind == IMAGE_RADIANCE) radiance_clean(pixels, count, is_srgb, reply);

done:
  if (pixels != MAP_FAILED) munmap(pixels, bytes);
  return status;
}

// Values for image_read_layer.
static Status layer_decode(ImageReply *reply, int *values_fd, OiioInput *input, const char *channel, bool is_srgb,
                           Log *log)
{
  Status status = STATUS_OK;
  OiioLayer layer;
  void *values = MAP_FAILED;
  size_t bytes = 0;
  TRY(oiio_layer_find(&layer, input, channel, log));
  bytes = (size_t)reply->width * reply->height * layer.channels * image_element_bytes(layer.element);
  reply->channels = layer.channels;
  reply->element = layer.element;
  reply->is_display = is_srgb;
  TRY(values_map(&values, values_fd, bytes, reply, log));
  TRY(oiio_layer_decode(input, &layer, values, log));

done:
  if (values != MAP_FAILED) munmap(values, bytes);
  return status;
}

static Status decode(ImageReply *reply, int *pixels_fd, const ImageRequest *request, int fd, Log *log)
{
  Status status = STATUS_OK;
  uint8_t *bytes = MAP_FAILED;
  size_t file_bytes = 0;
  OiioInput *input = NULL;
  ImageFormat format = IMAGE_PNG;

  memory_limit(BASE_BYTES + DECODE_BYTES_PER_PIXEL * request->max_pixels);
  TRY(file_map(&bytes, &file_bytes, fd, log));
  TRY(signature_check(&format, bytes, file_bytes, request->max_pixels, log));
  bool is_srgb = format == IMAGE_PNG || format == IMAGE_JPEG;
  TRY(oiio_open(&input, &reply->width, &reply->height, format, fd_path(fd).text, log));
  TRY(pixel_count_check(reply->width, reply->height, request->max_pixels, log));
  if (request->operation == IMAGE_DECODE_LAYER)
    TRY(layer_decode(reply, pixels_fd, input, request->channel, is_srgb, log));
  else
    TRY(image_decode(reply, pixels_fd, input, request->kind, is_srgb, log));

done:
  oiio_close(input);
  if (bytes != MAP_FAILED) munmap(bytes, file_bytes);
  return status;
}

static Status encode(int *encoded_fd, const ImageRequest *request, int fd, Log *log)
{
  memory_limit(RLIM_INFINITY);
  size_t size = request->pixel_bytes + request->text_bytes;
  const uint8_t *pixels = mmap(NULL, size, PROT_READ, MAP_PRIVATE, fd, 0);
  *encoded_fd = memfd_create("encoded", MFD_CLOEXEC);
  if (pixels == MAP_FAILED || *encoded_fd < 0) return log_no_memory(log, "image helper");
  Status status =
      oiio_encode(fd_path(*encoded_fd).text, request, pixels, (const char *)pixels + request->pixel_bytes, log);
  munmap((void *)pixels, size);
  return status;
}

// One line, without the names that files have in this process.
static void message_clean(char *out, size_t size, const char *message)
{
  static const char fd_folder[] = "/proc/self/fd/";
  size_t used = 0;
  for (const char *p = message; *p && used + 1 < size; p++) {
    if (strncmp(p, fd_folder, sizeof fd_folder - 1) == 0) {
      p += sizeof fd_folder - 1;
      while (p[1] >= '0' && p[1] <= '9') p++;
      memcpy(out + used, "file", size - used > 4 ? 4 : 0);
      used += size - used > 4 ? 4 : 0;
      continue;
    }
    out[used++] = (unsigned char)*p < ' ' ? ' ' : *p;
  }
  out[used] = 0;
}

// Ends this process as soon as the other side is gone, also in the middle of a request. (A parent-death signal would
// come when the thread that started the helper ends.)
static void *connection_watch(void *unused)
{
  struct pollfd connection = {.fd = STDIN_FILENO};
  while (poll(&connection, 1, -1) < 1 || !(connection.revents & (POLLHUP | POLLERR))) continue;
  _exit(0);
}

static void set_up(void)
{
  pthread_t watcher;
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, WATCHER_STACK_BYTES);
  pthread_create(&watcher, &attributes, connection_watch, NULL);
  pthread_attr_destroy(&attributes);
  setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
  mallopt(M_ARENA_MAX, 2);  // each arena would take 64 MB of the address space that memory_limit allows
  oiio_set_up();
}

// After each of the first requests and each that failed; among many, which take the same path, now and then: a look
// takes as long as decoding.
static void leaks_look(uint32_t number, Status status)
{
  enum { FIRST = 8, STEP = 16 };
  if (__lsan_do_recoverable_leak_check && (number < FIRST || number % STEP == 0 || status))
    __lsan_do_recoverable_leak_check();
}

int main(void)
{
  int type = 0;
  socklen_t type_size = sizeof type;
  if (getsockopt(STDIN_FILENO, SOL_SOCKET, SO_TYPE, &type, &type_size) != 0 || type != SOCK_SEQPACKET) {
    fputs("frugal-image: a part of frugal, which starts it; it works\n", stderr);
    return 2;
  }
  set_up();
  for (uint32_t number = 0;; number++) {
    ImageRequest request;
    ImageReply reply = {.protocol = IMAGE_PROTOCOL};
    Log log = {0};
    int fd, result_fd = -1;
    ssize_t length = message_receive(STDIN_FILENO, &request, sizeof request, &fd);
    if (length != sizeof request || request.protocol != IMAGE_PROTOCOL || fd < 0) _exit(length == 0 ? 0 : 2);
    reply.status = request.operation == IMAGE_ENCODE ? encode(&result_fd, &request, fd, &log)
                                                     : decode(&reply, &result_fd, &request, fd, &log);
    message_clean(reply.message, sizeof reply.message, log.error);
    if (!message_send(STDIN_FILENO, &reply, sizeof reply, reply.status ? -1 : result_fd)) _exit(0);
    close(fd);
    if (result_fd >= 0) close(result_fd);
    leaks_look(number, (Status)reply.status);
  }
}
