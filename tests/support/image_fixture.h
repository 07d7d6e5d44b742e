// A running image helper, a folder of its own and a clean log for each test of image files.
#pragma once

#include "image/image.h"

enum { IMAGE_MAX_PIXELS = 1 << 24, IMAGE_PATH_BYTES = 512 };

extern char image_folder[];
extern ImageHelper *image_helper;
extern Log image_log;
extern char image_warnings[4096];  // all of this test's, in a row

int image_set_up(void **state);
int image_tear_down(void **state);
int image_log_clear(void **state);

#define IMAGE_TEST(name) cmocka_unit_test_setup(name, image_log_clear)

// A name inside the folder, valid for three further calls.
const char *path_of(const char *name);

void assert_ok(Status status);

// Checks a failure and a part of its message, then clears the log.
void assert_fails(Status got, Status expected, const char *message);

// The bytes of a file; the caller frees them.
size_t file_load(const char *path, uint8_t **bytes);
void file_save(const char *path, const void *bytes, size_t size);

// Writes [height][width][channels] floats, read back as an image that the caller frees.
void write_floats(const char *path, uint32_t width, uint32_t height, uint32_t channels, const float *data,
                  uint32_t bit_depth);
Image read_image(const char *path, ImageKind kind);

// Numbers in [0, 1), the same on every run; the caller frees them.
float *noise(size_t count);

// A picture of them, 256 x 256.
Status write_noise(const char *path, const char *format);
