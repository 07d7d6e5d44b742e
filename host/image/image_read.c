#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "image/helper_process.h"

void image_free(Image *image)
{
  free(image->texels);
  free(image->pixels);
  *image = (Image){0};
}

static Status file_open(int *fd, uint64_t *size, const char *name, Log *log)
{
  struct stat file;
  *fd = open(name, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (*fd < 0 || fstat(*fd, &file) != 0)
    return log_fail(log, STATUS_NOT_FOUND, "%s: %s: check the name and its permissions", name, strerror(errno));
  if (!S_ISREG(file.st_mode))
    return log_fail(log, STATUS_BAD_IMAGE, "%s: %s: name an image file", name,
                    S_ISDIR(file.st_mode) ? "is a folder" : "is not a regular file");
  *size = (uint64_t)file.st_size;
  return STATUS_OK;
}

static Status memory_open(int *fd, const void *bytes, size_t size, const char *name, Log *log)
{
  *fd = memfd_create("image", MFD_CLOEXEC);
  if (*fd < 0) return log_no_memory(log, name);
  for (size_t done = 0; done < size;) {
    ssize_t written = write(*fd, (const char *)bytes + done, size - done);
    if (written < 0 && errno != EINTR) return log_no_memory(log, name);
    if (written > 0) done += (size_t)written;
  }
  return STATUS_OK;
}

// The first `size` bytes behind `fd`. Read, not mapped: what the other side may shrink must not be able to fault here.
static bool memory_read(void *out, size_t size, int fd)
{
  for (size_t done = 0; done < size;) {
    ssize_t got = pread(fd, (char *)out + done, size - done, (off_t)done);
    if (got == 0 || (got < 0 && errno != EINTR)) return false;
    if (got > 0) done += (size_t)got;
  }
  return true;
}

// Asks the helper to decode the file, or the `size` bytes of it in memory where `bytes` is not NULL. The caller closes
// *values_fd.
static Status decode_ask(ImageReply *reply, int *values_fd, ImageHelper *helper, ImageRequest *request,
                         const char *name, const void *bytes, size_t size, Log *log)
{
  Status status = STATUS_OK;
  int fd = -1;
  uint64_t file_bytes = size;
  request->max_pixels = helper->max_image_pixels;
  if (bytes)
    TRY(memory_open(&fd, bytes, size, name, log));
  else
    TRY(file_open(&fd, &file_bytes, name, log));
  TRY(helper_exchange(helper, request, fd, file_bytes, reply, values_fd, name, STATUS_BAD_IMAGE, log));

done:
  if (fd >= 0) close(fd);
  return status;
}

// Takes over what the helper has decoded, at `pixel_bytes` a pixel. The caller frees *values.
static Status values_take(void **values, ImageHelper *helper, const ImageReply *reply, uint64_t pixel_bytes, int fd,
                          const char *name, Log *log)
{
  uint64_t count = (uint64_t)reply->width * reply->height;
  if (count == 0 || count > helper->max_image_pixels || pixel_bytes == 0 || count > SIZE_MAX / pixel_bytes)
    return helper_distrust(helper, name, STATUS_BAD_IMAGE, log);
  *values = malloc(count * pixel_bytes);
  if (!*values) return log_no_memory(log, name);
  if (!memory_read(*values, count * pixel_bytes, fd)) return helper_distrust(helper, name, STATUS_BAD_IMAGE, log);
  return STATUS_OK;
}

Status image_read(Image *out, ImageHelper *helper, ImageKind kind, const char *name, const void *bytes, size_t size,
                  Log *log)
{
  Status status = STATUS_OK;
  int pixels_fd = -1;
  void *pixels = NULL;
  ImageReply reply;
  ImageRequest request = {.operation = IMAGE_DECODE, .kind = kind};

  TRY(decode_ask(&reply, &pixels_fd, helper, &request, name, bytes, size, log));
  uint64_t pixel_bytes = kind == IMAGE_TEXTURE ? 4 : 4 * sizeof(float);
  TRY(values_take(&pixels, helper, &reply, pixel_bytes, pixels_fd, name, log));
  if (reply.not_finite)
    log_warn(log, "%s: %llu pixels are not finite: they are read as black", name, (unsigned long long)reply.not_finite);
  if (reply.negative)
    log_warn(log, "%s: %llu pixels have negative values: these are read as 0", name,
             (unsigned long long)reply.negative);
  *out = (Image){.width = reply.width, .height = reply.height};
  if (kind == IMAGE_TEXTURE)
    out->texels = pixels;
  else
    out->pixels = pixels;

done:
  if (pixels_fd >= 0) close(pixels_fd);
  if (status) free(pixels);
  return status;
}

void image_layer_free(ImageLayer *layer)
{
  free(layer->values);
  *layer = (ImageLayer){0};
}

Status image_read_layer(ImageLayer *out, ImageHelper *helper, const char *path, const char *channel, Log *log)
{
  Status status = STATUS_OK;
  int values_fd = -1;
  void *values = NULL;
  ImageReply reply;
  ImageRequest request = {.operation = IMAGE_DECODE_LAYER};
  if (channel && strlen(channel) >= sizeof request.channel)
    return log_fail(log, STATUS_BAD_IMAGE, "%s: no channel %s: look at their names", path, channel);
  if (channel) strcpy(request.channel, channel);

  TRY(decode_ask(&reply, &values_fd, helper, &request, path, NULL, 0, log));
  uint64_t pixel_bytes = reply.channels > 4 ? 0 : reply.channels * image_element_bytes(reply.element);
  TRY(values_take(&values, helper, &reply, pixel_bytes, values_fd, path, log));
  *out = (ImageLayer){reply.width, reply.height, reply.channels, reply.element, reply.is_display, values};

done:
  if (values_fd >= 0) close(values_fd);
  if (status) free(values);
  return status;
}
