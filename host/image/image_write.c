#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/parallel.h"
#include "image/helper_process.h"
#include "image/output_file.h"

static const struct FormatName {
  const char *name;
  ImageFormat format;
} format_names[] = {
    {"png", IMAGE_PNG}, {"jpg", IMAGE_JPEG}, {"jpeg", IMAGE_JPEG}, {"exr", IMAGE_EXR}, {"hdr", IMAGE_HDR}};

static const struct FormatName *format_find(const char *name)
{
  for (size_t i = 0; i < sizeof format_names / sizeof *format_names; i++)
    if (strcasecmp(name, format_names[i].name) == 0) return &format_names[i];
  return NULL;
}

static const struct FormatName *format_of_path(const char *path)
{
  const char *dot = strrchr(path, '.');
  return dot && !strchr(dot, '/') ? format_find(dot + 1) : NULL;
}

const char *image_format_of(const char *path)
{
  const struct FormatName *found = format_of_path(path);
  if (!found) return NULL;
  return found->format == IMAGE_JPEG ? "jpg" : found->name;
}

static bool compression_is_known(ImageFormat format, const char *compression)
{
  static const char *const exr[] = {"none", "rle", "zip", "zips", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"};
  if (!compression) return true;
  if (format == IMAGE_PNG) return compression[0] >= '0' && compression[0] <= '9' && !compression[1];
  for (size_t i = 0; format == IMAGE_EXR && i < sizeof exr / sizeof *exr; i++)
    if (strcmp(compression, exr[i]) == 0) return true;
  return format == IMAGE_JPEG || format == IMAGE_HDR;
}

bool image_compression_is_known(const char *format, const char *compression)
{
  const struct FormatName *found = format_find(format);
  return found && compression_is_known(found->format, compression);
}

static Status output_check(const ImageOutput *output, ImageFormat format, const char *path, Log *log)
{
  const char *fault = NULL;
  if (!output->width || !output->height || output->width > INT_MAX || output->height > INT_MAX)
    fault = "a picture without pixels: ask for a size of 1x1 or more";
  else if (!output->group_count)
    fault = "a picture without channels: ask for one";
  else if (format != IMAGE_EXR && (output->group_count != 1 || output->groups[0].is_uint))
    fault = "this format holds one picture of colours: use .exr for more";
  else if (format == IMAGE_HDR && output->groups[0].count < 3)
    fault = "HDR holds red, green and blue: use .exr for less";
  else if (format == IMAGE_PNG && output->bit_depth != 8 && output->bit_depth != 16)
    fault = "PNG has 8 or 16 bits a channel: set --bit-depth to either";
  else if (format == IMAGE_JPEG && (output->quality < 1 || output->quality > 100))
    fault = "JPEG quality goes from 1 to 100: set --quality within it";
  else if (!compression_is_known(format, output->compression))
    fault = "unknown compression: use 0 to 9 for PNG; none, rle, zip, zips, piz, pxr24, b44, b44a, dwaa, dwab for EXR";
  for (uint32_t g = 0; !fault && g < output->group_count; g++) {
    const ImageChannels *group = &output->groups[g];
    if (group->count < 1 || group->count > 4 || group->stride < group->count || !group->data)
      fault = "a channel group is not made of 1 to 4 channels: report this as a defect";
    for (uint32_t c = 0; !fault && format == IMAGE_EXR && c < group->count; c++)
      if (!group->names[c] || !*group->names[c]) fault = "a channel without a name: report this as a defect";
  }
  return fault ? log_fail(log, STATUS_USAGE, "%s: %s", path, fault) : STATUS_OK;
}

// How many of a group's channels the format holds: JPEG and HDR have no alpha.
static uint32_t group_channels(const ImageChannels *group, ImageFormat format)
{
  if (format == IMAGE_JPEG) return group->count < 3 ? 1 : 3;
  return format == IMAGE_HDR ? 3 : group->count;
}

typedef struct Packing {
  const ImageOutput *output;
  ImageFormat format;
  uint32_t channels, element_bytes;
  uint8_t *pixels;  // [height][width][channels]
} Packing;

// In double every product and sum below is exact, so that contraction cannot change a rounding. NaN becomes 0.
static uint32_t quantise(float value, double largest)
{
  if (!(value > 0)) return 0;
  return value < 1 ? (uint32_t)(value * largest + 0.5) : (uint32_t)largest;
}

// RGBE has neither NaN, nor signs, nor room above 2^127.
static float radiance_clamp(float value)
{
  if (!(value > 0)) return 0;
  return value < 0x1p127f ? value : 0x1.fep126f;
}

static void row_pack(void *context, size_t y)
{
  const Packing *packing = context;
  uint32_t width = packing->output->width, channels = packing->channels;
  uint8_t *row = packing->pixels + y * width * channels * packing->element_bytes;
  for (uint32_t g = 0, offset = 0; g < packing->output->group_count; g++) {
    const ImageChannels *group = &packing->output->groups[g];
    uint32_t count = group_channels(group, packing->format);
    const float *from = (const float *)group->data + y * width * group->stride;
    uint8_t *to = row + offset * packing->element_bytes;
    for (uint32_t x = 0; x < width; x++, from += group->stride, to += channels * packing->element_bytes) {
      if (packing->format == IMAGE_EXR)
        memcpy(to, from, count * sizeof *from);
      else if (packing->format == IMAGE_HDR)
        for (uint32_t c = 0; c < count; c++) ((float *)to)[c] = radiance_clamp(from[c]);
      else if (packing->element_bytes == 1)
        for (uint32_t c = 0; c < count; c++) to[c] = (uint8_t)quantise(from[c], 255);
      else
        for (uint32_t c = 0; c < count; c++) ((uint16_t *)to)[c] = (uint16_t)quantise(from[c], 65535);
    }
    offset += count;
  }
}

// Appends a type letter (none where it is 0) and a string to the text, or only counts them where `text` is NULL.
static size_t text_add(char *text, size_t used, char type, const char *string)
{
  size_t size = strlen(string) + 1;
  if (text && type) text[used] = type;
  if (type) used++;
  if (text) memcpy(text + used, string, size);
  return used + size;
}

static size_t text_fill(char *text, const ImageOutput *output, ImageFormat format)
{
  size_t used = text_add(text, 0, 0, output->compression ? output->compression : "");
  for (uint32_t g = 0; g < output->group_count; g++)
    for (uint32_t c = 0; c < group_channels(&output->groups[g], format); c++)
      used = text_add(text, used, output->groups[g].is_uint ? 'u' : 'f',
                      format == IMAGE_EXR ? output->groups[g].names[c] : "");
  for (uint32_t a = 0; a < output->attribute_count; a++) {
    used = text_add(text, used, 0, output->attributes[a].name);
    used = text_add(text, used, 0, output->attributes[a].value);
  }
  return used;
}

// Pixels and text in shared memory, as protocol.h lays them out. The caller closes *fd.
static Status request_fill(ImageRequest *request, int *fd, const ImageOutput *output, ImageFormat format,
                           const char *path, Log *log)
{
  uint32_t channels = 0;
  for (uint32_t g = 0; g < output->group_count; g++) channels += group_channels(&output->groups[g], format);
  uint32_t bits = format == IMAGE_PNG ? output->bit_depth : format == IMAGE_JPEG ? 8 : 32;
  *request = (ImageRequest){
      .operation = IMAGE_ENCODE,
      .format = format,
      .width = output->width,
      .height = output->height,
      .channels = channels,
      .element_bits = bits,
      .quality = output->quality,
      .pixel_bytes = (uint64_t)output->width * output->height * channels * (bits / 8),
      .text_bytes = text_fill(NULL, output, format),
  };
  size_t size = request->pixel_bytes + request->text_bytes;

  // Allocated in full before it is touched: out of memory is then an error, and no signal.
  *fd = memfd_create("pixels", MFD_CLOEXEC);
  if (*fd < 0 || posix_fallocate(*fd, 0, (off_t)size) != 0) return log_no_memory(log, path);
  uint8_t *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED, *fd, 0);
  if (memory == MAP_FAILED) return log_no_memory(log, path);
  parallel_for(
      output->height, row_pack,
      &(Packing){
          .output = output, .format = format, .channels = channels, .element_bytes = bits / 8, .pixels = memory});
  text_fill((char *)memory + request->pixel_bytes, output, format);
  munmap(memory, size);
  return STATUS_OK;
}

// OpenImageIO gives a Radiance header no attributes: ours go behind its first line, the one of the program's command
// line as it is, which is the format's custom. *done becomes how much of the encoded file they stand for.
// From: Ward, "The RADIANCE Picture File Format", 1992 (header variables).
static Status hdr_header_write(OutputFile *file, off_t *done, int fd, const ImageOutput *output, Log *log)
{
  static const char first_line[] = "#?RADIANCE\n",
                    rec_709[] = "PRIMARIES=0.64 0.33 0.30 0.60 0.15 0.06 0.3127 0.3290\n";
  enum { FIRST_LINE_BYTES = sizeof first_line - 1 };
  Status status = STATUS_OK;
  char line[FIRST_LINE_BYTES];
  if (pread(fd, line, sizeof line, 0) != sizeof line || memcmp(line, first_line, sizeof line) != 0) return STATUS_OK;
  TRY(output_file_write(file, first_line, FIRST_LINE_BYTES, log));
  TRY(output_file_write(file, rec_709, sizeof rec_709 - 1, log));
  for (uint32_t i = 0; i < output->attribute_count; i++) {
    const ImageAttribute *attribute = &output->attributes[i];
    if (!strcmp(attribute->name, "Software")) TRY(output_file_write(file, "SOFTWARE=", 9, log));
    TRY(output_file_write(file, attribute->value, strlen(attribute->value), log));
    TRY(output_file_write(file, "\n", 1, log));
  }
  *done = FIRST_LINE_BYTES;

done:
  return status;
}

// From byte `done` on.
static Status output_file_copy(OutputFile *file, int fd, off_t done, Log *log)
{
  enum { CHUNK_BYTES = 1 << 18 };
  Status status = STATUS_OK;
  ssize_t got;
  char *chunk = malloc(CHUNK_BYTES);
  if (!chunk) return log_no_memory(log, file->path);
  while ((got = pread(fd, chunk, CHUNK_BYTES, done)) != 0) {
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      status = log_fail(log, STATUS_OUTPUT, "%s: %s: try again", file->path, strerror(errno));
      goto done;
    }
    TRY(output_file_write(file, chunk, (size_t)got, log));
    done += got;
  }

done:
  free(chunk);
  if (!status && done == 0)
    status = log_fail(log, STATUS_OUTPUT, "%s: the encoder wrote nothing: try again", file->path);
  return status;
}

Status image_write(ImageHelper *helper, const char *path, const char *format, const ImageOutput *output, Log *log)
{
  Status status = STATUS_OK;
  int pixels_fd = -1, encoded_fd = -1;
  off_t written = 0;
  OutputFile file = {.fd = -1, .slot = -1};
  ImageRequest request;
  ImageReply reply;

  const struct FormatName *found = format ? format_find(format) : format_of_path(path);
  if (!found)
    return log_fail(log, STATUS_USAGE, "%s: unknown image format: use .png, .jpg, .exr or .hdr",
                    format ? format : path);
  TRY(output_check(output, found->format, path, log));
  TRY(output_file_open(&file, path, log));
  TRY(request_fill(&request, &pixels_fd, output, found->format, path, log));
  TRY(helper_exchange(helper, &request, pixels_fd, request.pixel_bytes, &reply, &encoded_fd, path, STATUS_OUTPUT, log));
  if (found->format == IMAGE_HDR) TRY(hdr_header_write(&file, &written, encoded_fd, output, log));
  TRY(output_file_copy(&file, encoded_fd, written, log));
  TRY(output_file_commit(&file, log));

done:
  if (status) output_file_discard(&file);
  if (pixels_fd >= 0) close(pixels_fd);
  if (encoded_fd >= 0) close(encoded_fd);
  return status;
}
