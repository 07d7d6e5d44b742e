// Picture files appear whole or not at all, whatever the place.
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "image/output_file.h"
#include "support/image_fixture.h"

// The only entry of the folder but for `.` and `..`; "" where it is empty.
static const char *only_entry(const char *path)
{
  static char name[256];
  int count = 0;
  name[0] = 0;
  DIR *open_folder = opendir(path);
  assert_non_null(open_folder);
  for (struct dirent *entry; (entry = readdir(open_folder));)
    if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0 && count++ < 1)
      snprintf(name, sizeof name, "%s", entry->d_name);
  closedir(open_folder);
  return count > 1 ? "(several)" : name;
}

static void unwritable_places_are_errors(void **state)
{
  assert_fails(write_noise(path_of("none/a.png"), NULL), STATUS_OUTPUT, "No such file or directory: make the folder");
  file_save(path_of("file"), "x", 1);
  assert_fails(write_noise(path_of("file/a.png"), NULL), STATUS_OUTPUT, "a part of the path is a file");
  assert_fails(write_noise(image_folder, "png"), STATUS_OUTPUT, "Is a directory");
  assert_fails(write_noise("/dev/full", "png"), STATUS_OUTPUT, "/dev/full: No space left on device: free some space");
  struct stat device;
  assert_true(stat("/dev/full", &device) == 0 && S_ISCHR(device.st_mode));
  mkdir(path_of("locked"), 0555);
  if (geteuid() == 0)
    fprintf(stderr, "SKIPPED: a folder without write permission stops no root\n");
  else
    assert_fails(write_noise(path_of("locked/a.png"), NULL), STATUS_OUTPUT, "Permission denied");
}

static void full_disk_keeps_the_old_file_and_nothing_else(void **state)
{
  char disk[IMAGE_PATH_BYTES];
  strcpy(disk, path_of("disk"));
  mkdir(disk, 0777);
  if (mount("tmpfs", disk, "tmpfs", 0, "size=64k") != 0) {
    fprintf(stderr, "SKIPPED: a full disk: cannot mount one: %s\n", strerror(errno));
    return;
  }
  file_save(path_of("disk/a.png"), "old", 3);
  static const char *const formats[] = {"png", "exr", "hdr", "jpg"};
  Status status[4];
  char messages[4][1024], entry[256];
  for (int i = 0; i < 4; i++) {
    status[i] = write_noise(path_of("disk/a.png"), formats[i]);
    strcpy(messages[i], image_log.error);
    image_log_clear(NULL);
  }
  uint8_t *bytes;
  size_t size = file_load(path_of("disk/a.png"), &bytes);
  strcpy(entry, only_entry(disk));
  umount(disk);
  for (int i = 0; i < 4; i++) {
    assert_int_equal(status[i], STATUS_OUTPUT);
    assert_non_null(strstr(messages[i], "disk/a.png: No space left on device: free some space"));
  }
  assert_int_equal(size, 3);
  assert_string_equal(entry, "a.png");
  free(bytes);
}

static void a_signal_handler_can_remove_temporary_files(void **state)
{
  OutputFile file;
  char place[IMAGE_PATH_BYTES];
  strcpy(place, path_of("place"));
  mkdir(place, 0777);
  assert_ok(output_file_open(&file, path_of("place/a.png"), &image_log));
  assert_int_equal(strncmp(only_entry(place), ".frugal-", 8), 0);
  image_remove_temporaries();
  assert_string_equal(only_entry(place), "");
  assert_fails(output_file_commit(&file, &image_log), STATUS_OUTPUT, "place/a.png: ");

  assert_ok(output_file_open(&file, path_of("place/a.png"), &image_log));
  assert_ok(output_file_write(&file, "x", 1, &image_log));
  assert_ok(output_file_commit(&file, &image_log));
  image_remove_temporaries();
  assert_string_equal(only_entry(place), "a.png");
}

static void modes_and_links_are_kept(void **state)
{
  struct stat file;
  mode_t before = umask(027);
  assert_ok(write_noise(path_of("mode.png"), NULL));
  umask(before);
  stat(path_of("mode.png"), &file);
  assert_int_equal(file.st_mode & 07777, 0640);
  chmod(path_of("mode.png"), 0604);
  assert_int_equal(symlink("mode.png", path_of("link.png")), 0);
  assert_ok(write_noise(path_of("link.png"), NULL));
  lstat(path_of("link.png"), &file);
  assert_true(S_ISLNK(file.st_mode));
  stat(path_of("mode.png"), &file);
  assert_int_equal(file.st_mode & 07777, 0604);
}

static void standard_output_takes_pictures_and_survives_its_reader(void **state)
{
  int saved = dup(STDOUT_FILENO), ends[2];
  fflush(stdout);
  int fd = open(path_of("out.png"), O_RDWR | O_CREAT | O_TRUNC, 0666);
  dup2(fd, STDOUT_FILENO);
  Status to_file = write_noise("-", "png");
  assert_int_equal(pipe(ends), 0);
  close(ends[0]);
  dup2(ends[1], STDOUT_FILENO);
  Status to_nobody = write_noise("-", "png");
  dup2(saved, STDOUT_FILENO);
  close(saved), close(fd), close(ends[1]);
  assert_fails(to_nobody, STATUS_OUTPUT, "standard output: Broken pipe: the program that reads it has ended");
  assert_ok(to_file);

  uint8_t *piped, *direct;
  assert_ok(write_noise(path_of("direct.png"), NULL));
  size_t size = file_load(path_of("out.png"), &piped);
  assert_int_equal(size, file_load(path_of("direct.png"), &direct));
  assert_memory_equal(piped, direct, size);
  free(piped), free(direct);
}

static void what_a_format_cannot_hold_is_a_usage_error(void **state)
{
  float data[4] = {0};
  ImageChannels groups[2] = {{{"R", "G", "B", "A"}, 4, 4, data, 0}, {{"id"}, 1, 1, data, 1}};
  ImageOutput output = {1, 1, groups, 1, 8, 95, NULL, NULL, 0};
  assert_fails(write_noise(path_of("a.gif"), NULL), STATUS_USAGE, "a.gif: unknown image format: use .png");
  assert_fails(write_noise("-", NULL), STATUS_USAGE, "-: unknown image format");
  assert_string_equal(image_format_of("x/a.JPEG"), "jpg");
  assert_string_equal(image_format_of("a.exr"), "exr");
  assert_null(image_format_of("a.png/b"));
  output.bit_depth = 12;
  assert_fails(image_write(image_helper, "a.png", NULL, &output, &image_log), STATUS_USAGE,
               "a.png: PNG has 8 or 16 bits");
  output.quality = 0;
  assert_fails(image_write(image_helper, "a.jpg", NULL, &output, &image_log), STATUS_USAGE, "a.jpg: JPEG quality");
  output.compression = "zap";
  assert_fails(image_write(image_helper, "a.exr", NULL, &output, &image_log), STATUS_USAGE,
               "a.exr: unknown compression");
  output.group_count = 2;
  assert_fails(image_write(image_helper, "a.hdr", NULL, &output, &image_log), STATUS_USAGE,
               "a.hdr: this format holds one");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      IMAGE_TEST(unwritable_places_are_errors),
      IMAGE_TEST(full_disk_keeps_the_old_file_and_nothing_else),
      IMAGE_TEST(a_signal_handler_can_remove_temporary_files),
      IMAGE_TEST(modes_and_links_are_kept),
      IMAGE_TEST(standard_output_takes_pictures_and_survives_its_reader),
      IMAGE_TEST(what_a_format_cannot_hold_is_a_usage_error),
  };
  return cmocka_run_group_tests(tests, image_set_up, image_tear_down);
}
