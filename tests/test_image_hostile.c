// Image files and helpers that are damaged, hostile, missing or slow: each costs one request and nothing else.
#include <fcntl.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/clock.h"
#include "image/helper_process.h"
#include "support/image_fixture.h"

static void memory_images_are_known_by_their_bytes(void **state)
{
  float data[3] = {1, 0.5f, 0};
  static const char *const names[] = {"a.png", "a.exr", "a.hdr", "a.jpg"};
  for (int i = 0; i < 4; i++) {
    uint8_t *bytes;
    Image image;
    write_floats(path_of(names[i]), 1, 1, 3, data, 8);
    size_t size = file_load(path_of(names[i]), &bytes);
    assert_ok(image_read(&image, image_helper, IMAGE_RADIANCE, names[(i + 1) % 4], bytes, size, &image_log));
    assert_true(image.pixels[0] > 0.9f);
    image_free(&image);
    free(bytes);
  }
}

static void read_fails(const char *name, ImageKind kind, const void *bytes, size_t size, Status expected,
                       const char *message)
{
  Image image = {.width = 7};
  assert_fails(image_read(&image, image_helper, kind, name, bytes, size, &image_log), expected, message);
  assert_int_equal(image.width, 7);
}

static void bad_files_are_refused_by_name(void **state)
{
  read_fails("empty.png", IMAGE_TEXTURE, "", 0, STATUS_BAD_IMAGE, "empty.png: the file is empty");
  read_fails("t.png", IMAGE_TEXTURE, "hello, world", 12, STATUS_BAD_IMAGE, "t.png: not a PNG, JPEG, EXR or HDR file");
  read_fails(image_folder, IMAGE_TEXTURE, NULL, 0, STATUS_BAD_IMAGE, "is a folder");
  read_fails("/dev/zero", IMAGE_TEXTURE, NULL, 0, STATUS_BAD_IMAGE, "not a regular file");
  read_fails(path_of("none.png"), IMAGE_TEXTURE, NULL, 0, STATUS_NOT_FOUND, "none.png: No such file or directory");
  file_save(path_of("empty.hdr"), "", 0);
  read_fails(path_of("empty.hdr"), IMAGE_RADIANCE, NULL, 0, STATUS_BAD_IMAGE, "the file is empty");

  float data[3] = {1, 1, 1};
  write_floats(path_of("a.hdr"), 1, 1, 3, data, 0);
  read_fails(path_of("a.hdr"), IMAGE_TEXTURE, NULL, 0, STATUS_BAD_IMAGE, "holds radiance, not a texture");
}

static void size_is_checked_before_decoding(void **state)
{
  uint8_t bomb[33] = "\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\xff\xff\0\0\xff\xff\x08\x06\0\0\0\0\0\0";
  read_fails("b.png", IMAGE_TEXTURE, bomb, sizeof bomb, STATUS_TOO_LARGE,
             "b.png: 65535 x 65535 pixels: raise --max-image-pixels");
  uint64_t limit = image_helper->max_image_pixels;
  image_helper->max_image_pixels = 1ull << 34;  // allowed by size: what the decoder does of it must stay in the helper
  read_fails("b.png", IMAGE_TEXTURE, bomb, sizeof bomb, STATUS_BAD_IMAGE, "b.png: ");
  image_helper->max_image_pixels = 15;
  float *data = noise(16 * 3);
  static const char *const names[] = {"a.png", "a.jpg", "a.hdr", "a.exr"};
  for (int i = 0; i < 4; i++) {
    write_floats(path_of(names[i]), 8, 2, 3, data, 8);
    read_fails(path_of(names[i]), IMAGE_RADIANCE, NULL, 0, STATUS_TOO_LARGE, "8 x 2 pixels: raise --max-image-pixels");
  }
  image_helper->max_image_pixels = limit;
  free(data);
}

static void truncated_and_damaged_files_fail_or_decode_but_never_hurt(void **state)
{
  enum { SIDE = 24, CUTS = 12, FLIPS = 40 };
  float *data = noise(SIDE * SIDE * 3);
  static const char *const names[] = {"a.png", "a.jpg", "a.hdr", "a.exr"};
  uint32_t seed = 7;
  for (int i = 0; i < 4; i++) {
    uint8_t *bytes;
    write_floats(path_of(names[i]), SIDE, SIDE, 3, data, 8);
    size_t size = file_load(path_of(names[i]), &bytes);
    for (size_t cut = 0; cut < CUTS; cut++)
      read_fails(names[i], IMAGE_RADIANCE, bytes, size * cut / CUTS + (cut ? 0 : 1), STATUS_BAD_IMAGE, names[i]);
    for (int flip = 0; flip < FLIPS; flip++) {
      Image image;
      size_t at = (seed = seed * 1664525u + 1013904223u) % (flip % 2 ? size : 120);
      uint8_t before = bytes[at];
      bytes[at] = (uint8_t)(seed >> 24);
      Status status = image_read(&image, image_helper, IMAGE_RADIANCE, names[i], bytes, size, &image_log);
      if (!status) image_free(&image);
      assert_true(!status || status == STATUS_BAD_IMAGE || status == STATUS_TOO_LARGE || status == STATUS_NO_MEMORY);
      assert_true(!status || strstr(image_log.error, names[i]));
      image_log_clear(NULL);
      bytes[at] = before;
    }
    free(bytes);
    Image image = read_image(path_of(names[i]), IMAGE_RADIANCE);
    image_free(&image);
  }
  free(data);
}

static void *kill_soon(void *argument)
{
  usleep(100000);
  kill(*(pid_t *)argument, SIGKILL);
  return NULL;
}

static void a_dying_or_hanging_helper_costs_one_request(void **state)
{
  float data[3] = {1, 1, 1};
  pthread_t killer;
  write_floats(path_of("a.png"), 1, 1, 3, data, 8);

  pid_t pid = image_helper->pid;  // stopped, so that the kill comes in the middle of the request
  kill(pid, SIGSTOP);
  pthread_create(&killer, NULL, kill_soon, &pid);
  read_fails(path_of("a.png"), IMAGE_TEXTURE, NULL, 0, STATUS_BAD_IMAGE, "a.png: the decoder died (signal 9): ");
  pthread_join(killer, NULL);
  Image image = read_image(path_of("a.png"), IMAGE_TEXTURE);
  image_free(&image);

  kill(image_helper->pid, SIGKILL);  // between two requests nobody is harmed
  siginfo_t info;
  waitid(P_PID, (id_t)image_helper->pid, &info, WEXITED | WNOWAIT);
  image = read_image(path_of("a.png"), IMAGE_TEXTURE);
  image_free(&image);

  image_helper->time_limit_ms = 200;
  kill(image_helper->pid, SIGSTOP);
  read_fails(path_of("a.png"), IMAGE_TEXTURE, NULL, 0, STATUS_BAD_IMAGE, "a.png: the decoder did not answer within");
  image_helper->time_limit_ms = 60000;

  write_floats(path_of("b.png"), 1, 1, 3, data, 8);  // the next one works, and starts the helper anew
  pid = image_helper->pid;
  kill(pid, SIGSTOP);
  pthread_create(&killer, NULL, kill_soon, &pid);
  ImageChannels group = {.count = 3, .stride = 3, .data = data};
  ImageOutput output = {1, 1, &group, 1, 8, 0, NULL, NULL, 0};
  assert_fails(image_write(image_helper, path_of("c.png"), NULL, &output, &image_log), STATUS_OUTPUT,
               "c.png: the encoder died (signal 9): ");
  pthread_join(killer, NULL);
  assert_int_equal(access(path_of("c.png"), F_OK), -1);
}

static void helper_that_is_missing_or_someone_else(void **state)
{
  ImageHelper *other = NULL;
  setenv("FRUGAL_IMAGE_HELPER", path_of("nobody"), 1);
  assert_fails(image_helper_start(&other, IMAGE_MAX_PIXELS, &image_log), STATUS_NOT_FOUND, "frugal-image: not found");
  assert_null(other);

  static const struct {
    const char *script, *message;
  } rows[] = {{"#!/bin/sh\nexit 3\n", "x.png: the decoder ended (exit code 3)"},
              {"#!/bin/sh\necho nonsense >&0\nsleep 9\n", "x.png: the image helper's answer makes no sense"},
              {"#!/bin/sh\nhead -c 200 /dev/zero >&0\nsleep 9\n", "x.png: the image helper's answer makes no sense"},
              {"#!/bin/sh\nhead -c 9000 /dev/zero >&0\nsleep 9\n", "x.png: the image helper's answer makes no sense"},
              {"not a program", "Exec format error"}};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
    const char *script = path_of("script");
    Image image;
    file_save(script, rows[i].script, strlen(rows[i].script));
    chmod(script, 0755);
    setenv("FRUGAL_IMAGE_HELPER", script, 1);
    Status status = image_helper_start(&other, IMAGE_MAX_PIXELS, &image_log);
    if (status) {
      assert_fails(status, STATUS_NOT_FOUND, rows[i].message);
      continue;
    }
    assert_fails(image_read(&image, other, IMAGE_TEXTURE, "x.png", "x", 1, &image_log), STATUS_BAD_IMAGE,
                 rows[i].message);
    image_helper_stop(other);
  }
  unsetenv("FRUGAL_IMAGE_HELPER");
}

enum { FD_LIMIT = 256 };

static void descriptors_list(bool open_now[FD_LIMIT])
{
  for (int fd = 0; fd < FD_LIMIT; fd++) open_now[fd] = fcntl(fd, F_GETFD) >= 0;
}

static void nothing_leaks_and_starting_does_not_wait(void **state)
{
  Image image;
  ImageHelper *other;
  bool before[FD_LIMIT], after[FD_LIMIT];
  float data[3] = {1, 1, 1};
  write_floats(path_of("a.png"), 1, 1, 3, data, 8);
  descriptors_list(before);
  double start_ms = clock_ms();
  assert_ok(image_helper_start(&other, IMAGE_MAX_PIXELS, &image_log));
  assert_true(clock_ms() - start_ms < 50);
  assert_ok(image_read(&image, other, IMAGE_TEXTURE, path_of("a.png"), NULL, 0, &image_log));
  image_free(&image);
  assert_int_equal(image_read(&image, other, IMAGE_TEXTURE, "x", "x", 1, &image_log), STATUS_BAD_IMAGE);
  for (int fd = 0; fd < FD_LIMIT; fd++)
    if (!before[fd] && fcntl(fd, F_GETFD) >= 0) assert_true(fcntl(fd, F_GETFD) & FD_CLOEXEC);
  kill(other->pid, SIGSTOP);
  pid_t pid = other->pid;
  image_helper_stop(other);
  descriptors_list(after);
  assert_memory_equal(before, after, sizeof before);
  assert_int_equal(kill(pid, 0), -1);  // reaped: not even a zombie
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      IMAGE_TEST(memory_images_are_known_by_their_bytes),
      IMAGE_TEST(bad_files_are_refused_by_name),
      IMAGE_TEST(size_is_checked_before_decoding),
      IMAGE_TEST(truncated_and_damaged_files_fail_or_decode_but_never_hurt),
      IMAGE_TEST(a_dying_or_hanging_helper_costs_one_request),
      IMAGE_TEST(helper_that_is_missing_or_someone_else),
      IMAGE_TEST(nothing_leaks_and_starting_does_not_wait),
  };
  return cmocka_run_group_tests(tests, image_set_up, image_tear_down);
}
