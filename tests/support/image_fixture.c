#include "support/image_fixture.h"

#include <ftw.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

char image_folder[] = "/tmp/test_image_XXXXXX";
ImageHelper *image_helper;
Log image_log;
char image_warnings[4096];

static void warning_keep(void *context, LogLevel level, const char *message)
{
  strncat(image_warnings, message, sizeof image_warnings - strlen(image_warnings) - 1);
}

const char *path_of(const char *name)
{
  static char paths[4][IMAGE_PATH_BYTES];
  static int turn;
  char *path = paths[turn++ % 4];
  snprintf(path, IMAGE_PATH_BYTES, "%s/%s", image_folder, name);
  return path;
}

int image_log_clear(void **state)
{
  image_log = (Log){.sink = warning_keep};
  image_warnings[0] = 0;
  return 0;
}

void assert_ok(Status status)
{
  if (status) fail_msg("status %d: %s", status, image_log.error);
}

void assert_fails(Status got, Status expected, const char *message)
{
  if (got != expected || !strstr(image_log.error, message))
    fail_msg("status %d, not %d: '%s' without '%s'", got, expected, image_log.error, message);
  image_log_clear(NULL);
}

size_t file_load(const char *path, uint8_t **bytes)
{
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  fseek(file, 0, SEEK_END);
  size_t size = (size_t)ftell(file);
  rewind(file);
  *bytes = malloc(size + 1);
  assert_int_equal(fread(*bytes, 1, size, file), size);
  fclose(file);
  return size;
}

void file_save(const char *path, const void *bytes, size_t size)
{
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  fwrite(bytes, 1, size, file);
  fclose(file);
}

void write_floats(const char *path, uint32_t width, uint32_t height, uint32_t channels, const float *data,
                  uint32_t bit_depth)
{
  ImageChannels group = {.names = {"R", "G", "B", "A"}, .count = channels, .stride = channels, .data = data};
  ImageOutput output = {width, height, &group, 1, bit_depth, 95, NULL, NULL, 0};
  assert_ok(image_write(image_helper, path, NULL, &output, &image_log));
}

Image read_image(const char *path, ImageKind kind)
{
  Image image;
  assert_ok(image_read(&image, image_helper, kind, path, NULL, 0, &image_log));
  return image;
}

// A picture of noise in [0, 1), the same on every run.
float *noise(size_t count)
{
  float *values = malloc(count * sizeof *values);
  uint32_t state = 1;
  for (size_t i = 0; i < count; i++) values[i] = (float)((state = state * 1664525u + 1013904223u) >> 8) / 0x1p24f;
  return values;
}

Status write_noise(const char *path, const char *format)
{
  enum { SIDE = 256 };
  float *data = noise(SIDE * SIDE * 3);
  ImageChannels group = {{"R", "G", "B"}, 3, 3, data, 0};
  ImageOutput output = {SIDE, SIDE, &group, 1, 8, 95, NULL, NULL, 0};
  Status status = image_write(image_helper, path, format, &output, &image_log);
  free(data);
  return status;
}

static int file_remove(const char *path, const struct stat *file, int type, struct FTW *position)
{
  return remove(path);
}

int image_set_up(void **state)
{
  image_log_clear(NULL);
  return mkdtemp(image_folder) && image_helper_start(&image_helper, IMAGE_MAX_PIXELS, &image_log) == STATUS_OK ? 0 : -1;
}

int image_tear_down(void **state)
{
  image_helper_stop(image_helper);
  return nftw(image_folder, file_remove, 16, FTW_DEPTH | FTW_PHYS);
}
