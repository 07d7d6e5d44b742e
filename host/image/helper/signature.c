#include "image/helper/signature.h"

#include <stdbool.h>
#include <string.h>

static bool starts_with(const uint8_t *bytes, size_t size, const char *magic, size_t magic_size)
{
  return size >= magic_size && memcmp(bytes, magic, magic_size) == 0;
}

static bool format_recognise(ImageFormat *out, const uint8_t *bytes, size_t size)
{
  static const struct {
    ImageFormat format;
    const char *magic;
    size_t size;
  } signatures[] = {
      {IMAGE_PNG, "\x89PNG\r\n\x1a\n", 8}, {IMAGE_JPEG, "\xff\xd8\xff", 3}, {IMAGE_EXR, "\x76\x2f\x31\x01", 4},
      {IMAGE_HDR, "#?RADIANCE", 10},       {IMAGE_HDR, "#?RGBE", 6},
  };
  for (size_t i = 0; i < sizeof signatures / sizeof *signatures; i++)
    if (starts_with(bytes, size, signatures[i].magic, signatures[i].size)) {
      *out = signatures[i].format;
      return true;
    }
  return false;
}

static uint32_t big_endian(const uint8_t *bytes, int count)
{
  uint32_t value = 0;
  for (int i = 0; i < count; i++) value = value << 8 | bytes[i];
  return value;
}

// Is there an end-of-image marker that is neither inside a segment (an EXIF thumbnail has one) nor inside entropy-coded
// data, where 0xff is followed by 0? Decoders fill what is missing with grey.
// From: ITU-T T.81, annex B.
static bool jpeg_is_whole(const uint8_t *bytes, size_t size)
{
  enum { RESTART_0 = 0xd0, RESTART_7 = 0xd7, END = 0xd9, TEMPORARY = 0x01 };
  size_t at = 2;
  while (at + 1 < size) {
    uint8_t marker = bytes[at + 1];
    if (bytes[at] != 0xff || marker == 0xff || marker == 0 || marker == TEMPORARY ||
        (marker >= RESTART_0 && marker <= RESTART_7))
      at++;
    else if (marker == END)
      return true;
    else if (at + 3 < size)
      at += 2 + (size_t)big_endian(bytes + at + 2, 2);
    else
      return false;
  }
  return false;
}

Status pixel_count_check(uint64_t width, uint64_t height, uint64_t max_pixels, Log *log)
{
  if (width == 0 || height == 0)
    return log_fail(log, STATUS_BAD_IMAGE, "%llu x %llu pixels: the file is damaged", (unsigned long long)width,
                    (unsigned long long)height);
  if (width > max_pixels / height)
    return log_fail(log, STATUS_TOO_LARGE, "%llu x %llu pixels: raise --max-image-pixels", (unsigned long long)width,
                    (unsigned long long)height);
  return STATUS_OK;
}

Status signature_check(ImageFormat *out, const uint8_t *bytes, size_t size, uint64_t max_pixels, Log *log)
{
  enum { PNG_SIZE_AT = 16, PNG_SIZE_END = 24 };
  if (size == 0) return log_fail(log, STATUS_BAD_IMAGE, "the file is empty: write it again");
  if (!format_recognise(out, bytes, size))
    return log_fail(log, STATUS_BAD_IMAGE, "not a PNG, JPEG, EXR or HDR file: convert it to one");
  if (*out == IMAGE_PNG && size < PNG_SIZE_END)
    return log_fail(log, STATUS_BAD_IMAGE, "the file ends early: write it again");
  if (*out == IMAGE_PNG)
    return pixel_count_check(big_endian(bytes + PNG_SIZE_AT, 4), big_endian(bytes + PNG_SIZE_AT + 4, 4), max_pixels,
                             log);
  if (*out == IMAGE_JPEG && !jpeg_is_whole(bytes, size))
    return log_fail(log, STATUS_BAD_IMAGE, "the file ends early: write it again");
  return STATUS_OK;
}
