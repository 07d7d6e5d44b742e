// Full disks, closed pipes, signals, devices that fail: the right exit code, no broken file, nothing left behind.
#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/cli.h"
#include "support/effort.h"
#include "support/test_device.h"

enum { DEVICE = 3, OUTPUT = 5 };

// Mounts a small disk that only this process and its children see. False, and a line, where that is not allowed.
static bool disk_mount(const char *path, const char *options)
{
  static bool is_private;
  mkdir(path, 0777);
  if (!is_private) is_private = unshare(CLONE_NEWNS) == 0 && mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) == 0;
  if (is_private && mount("tmpfs", path, "tmpfs", 0, options) == 0) return true;
  fprintf(stderr, "SKIPPED: a disk of %s: cannot mount one: %s\n", options, strerror(errno));
  return false;
}

static void a_full_disk_keeps_the_old_picture(void **state)
{
  const char *disk = cli_path("disk");
  if (!disk_mount(disk, "size=64k")) return;
  cli_save(cli_path("disk/a.exr"), "old", 3);
  // 256 x 256 x 16 bytes, uncompressed.
  CLI_EXPECT(OUTPUT, "disk/a.exr: No space left on device: free some space", "render", cli_scene(), "-o",
             cli_path("disk/a.exr"), "-s", "256x256", "--compression", "none");
  char *bytes = cli_load(cli_path("disk/a.exr"), NULL);
  assert_string_equal(bytes, "old");
  free(bytes);
  assert_string_equal(cli_list(disk), "a.exr");
  umount(disk);
}

// Opens the devices and expects a temporary kernel cache in use, for that reason.
static void assert_cache_replaced(const char *reason)
{
  char line[700];
  snprintf(line, sizeof line, "kernel cache: %s: set POCL_CACHE_DIR to a folder that can be written\n", reason);
  CliRun run = cli_run("devices", "--no-self-test", NULL);
  if (run.exit_code != 0 || !strstr(run.out, line)) fail_msg("'%s' expected in:\n%s%s", line, run.out, run.err);
  cli_free(&run);
}

// Nowhere to keep kernels, or no room: a temporary cache takes the place, and goes.
static void an_unusable_kernel_cache_is_replaced(void **state)
{
  if (test_skips_on_gpu("the kernel cache of PoCL")) return;
  char variable[600], reason[600];
  const char *place = cli_path("cache");
  snprintf(variable, sizeof variable, "POCL_CACHE_DIR=%s", place);
  snprintf(reason, sizeof reason, "%s cannot be written or is full", place);
  if (!effort_is_quick() && disk_mount(place, "size=64k")) {  // compiles all kernels
    cli_setting.environment[0] = variable;
    CLI_EXPECT(0, reason, "render", cli_scene(), "-o", cli_path("cache.png"), "-s", "16x16");
    umount(place);
  }
  if (disk_mount(place, "ro,size=64m")) {
    cli_setting.environment[0] = variable;
    assert_cache_replaced(reason);
    umount(place);
  }
  place = cli_path("out/old.png/cache");
  snprintf(variable, sizeof variable, "POCL_CACHE_DIR=%s", place);
  snprintf(reason, sizeof reason, "%s cannot be written or is full", place);
  cli_setting.environment[0] = variable;
  assert_cache_replaced(reason);
}

static void without_a_home_folder_all_is_well(void **state)
{
  static const char *const homes[] = {"HOME", "HOME="};
  for (int i = 0; i < 2; i++) {
    cli_setting.environment[0] = homes[i];
    cli_setting.environment[1] = "XDG_CACHE_HOME";
    cli_setting.environment[2] = "POCL_CACHE_DIR";
    assert_cache_replaced("no home folder");
  }
}

static void closed_pipes_are_outputs_that_fail(void **state)
{
  int ends[2];
  assert_int_equal(pipe(ends), 0);
  close(ends[0]);
  cli_setting.stdout_fd = ends[1];
  CLI_EXPECT(OUTPUT, "standard output: Broken pipe: the program that reads it has ended", "render", cli_scene(), "-o",
             "-", "--format", "png", "-s", "64x48");
  cli_setting.stdout_fd = ends[1];
  CLI_EXPECT(OUTPUT, "standard output: Broken pipe", "info", cli_scene(), "--json");
  cli_setting.stdout_fd = ends[1];
  CLI_EXPECT(OUTPUT, "standard output: Broken pipe", "--version");
  close(ends[1]);
}

// A device that fails at each kind of call: early, midway, and while results come back.
static void a_device_that_fails_midway(void **state)
{
  static const struct {
    const char *fault;
    int exit_code;
    const char *message;
  } faults[] = {
      {"FRUGAL_FAULT=build:3", DEVICE, "kernel build failed"},
      {"FRUGAL_FAULT=buffer:5", 4, "CL_MEM_OBJECT_ALLOCATION_FAILURE"},
      {"FRUGAL_FAULT=launch:1", DEVICE, "failed (CL_OUT_OF_RESOURCES, -5): try another --device"},
      {"FRUGAL_FAULT=launch:4", DEVICE, "failed (CL_OUT_OF_RESOURCES, -5): try another --device"},
      {"FRUGAL_FAULT=read:1", DEVICE, "a transfer from it failed (CL_OUT_OF_RESOURCES, -5)"},
      {"FRUGAL_FAULT=read:2", DEVICE, "a transfer from it failed"},
      {"FRUGAL_FAULT=corrupt:1", DEVICE, "it computes wrong: try another --device"},
  };
  for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
    cli_setting.environment[0] = faults[i].fault;
    CLI_EXPECT(faults[i].exit_code, faults[i].message, "render", cli_scene(), "-o", cli_path("out/old.png"), "-s",
               "64x48", "--stats", cli_path("out/stats.json"));
    cli_old_check();
  }
}

// A picture of minutes, interrupted at its first line of progress. How long the end took is told, not tested.
static void interrupt(int signal, int exit_code)
{
  cli_setting.signal_after = "frugal: 0 %";
  cli_setting.signal = signal;
  CliRun run = cli_run("render", cli_scene(), "-o", cli_path("out/old.png"), "-s", "1920x1080", "-n", "4096",
                       "--progress", NULL);
  cli_expect(&run, exit_code, "frugal: interrupted\n", __FILE__, __LINE__);
  assert_true(run.signal_ms > 0);
  assert_null(strstr(run.err, "10 %"));
  print_message("ended %.0f ms after the signal\n", run.signal_ms);
  cli_free(&run);
  cli_old_check();
}

static void interrupts_end_it_at_once(void **state)
{
  interrupt(SIGINT, 130);
  interrupt(SIGTERM, 143);
}

// A picture whose encoding takes seconds: the half-written file goes.
static void interrupts_while_the_picture_is_written(void **state)
{
  cli_setting.signal_while = cli_path("out");
  cli_setting.signal = SIGTERM;
  CliRun run =
      cli_run("render", cli_scene(), "-o", cli_path("out/old.png"), "-s", "1600x1200", "--compression", "9", NULL);
  cli_expect(&run, 143, "frugal: interrupted", __FILE__, __LINE__);
  cli_free(&run);
  cli_old_check();
}

// While kernels compile into a temporary cache, which goes too.
static void interrupts_while_kernels_compile(void **state)
{
  if (test_skips_on_gpu("kernels that compile for seconds")) return;
  static char nowhere[600];
  snprintf(nowhere, sizeof nowhere, "POCL_CACHE_DIR=%s/scene.glb/cache", cli_folder);
  cli_scene();
  cli_setting.environment[0] = nowhere;
  cli_setting.signal_after = "so kernels are compiled on each run";
  cli_setting.signal = SIGTERM;
  CLI_EXPECT(143, "frugal: interrupted", "render", cli_scene(), "-o", cli_path("out/old.png"));
  cli_old_check();
}

static void an_ignored_interrupt_stays_ignored(void **state)
{
  cli_setting.ignore_interrupt = true;
  cli_setting.signal_after = "frugal: ";  // at its first line
  cli_setting.signal = SIGINT;
  CliRun run =
      cli_run("render", cli_scene(), "-o", cli_path("ignored.png"), "-s", "640x360", "-n", "8", "--progress", NULL);
  cli_expect(&run, 0, "frugal: 100 %", __FILE__, __LINE__);
  assert_true(run.signal_ms > 0);
  cli_free(&run);
  assert_int_equal(access(cli_path("ignored.png"), F_OK), 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(closed_pipes_are_outputs_that_fail),
      cmocka_unit_test(a_full_disk_keeps_the_old_picture),
      cmocka_unit_test(an_unusable_kernel_cache_is_replaced),
      cmocka_unit_test(without_a_home_folder_all_is_well),
      cmocka_unit_test(a_device_that_fails_midway),
      cmocka_unit_test(interrupts_end_it_at_once),
      cmocka_unit_test(interrupts_while_the_picture_is_written),
      cmocka_unit_test(interrupts_while_kernels_compile),
      cmocka_unit_test(an_ignored_interrupt_stays_ignored),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
