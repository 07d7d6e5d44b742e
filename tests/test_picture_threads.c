// The program writes the same file on every run and for any number of threads.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/cli.h"

// Renders with so many threads, all where it is NULL.
static char *rendered(size_t *size, const char *scene, const char *primary, const char *model, const char *reflections,
                      const char *threads, const char *ending)
{
  const char *path = cli_path("picture.%s", ending), *aovs = "depth,position,normal,albedo,object,shadow,reflection";
  bool exr = !strcmp(ending, "exr");
  CliRun run = cli_run("render", scene, "-q", "-o", path, "-s", "190x107", "-n", "3", "--primary", primary,
                       "--lighting", model, "--reflections", reflections, exr ? "--aov" : "--exposure",
                       exr ? aovs : "0", threads ? "--threads" : NULL, threads, NULL);
  if (run.exit_code != 0) fail_msg("%s", run.err);
  cli_free(&run);
  char *bytes = cli_load(path, size);
  assert_non_null(bytes);
  return bytes;
}

static void check(const char *scene, const char *primary, const char *model, const char *reflections,
                  const char *ending)
{
  static const char *const threads[] = {NULL, "1", "2", "3"};
  size_t size, other_size;
  char *bytes = rendered(&size, scene, primary, model, reflections, NULL, ending);
  assert_true(size > 5000);  // a picture of nothing is smaller
  for (size_t i = 0; i < sizeof threads / sizeof *threads; i++) {
    char *other = rendered(&other_size, scene, primary, model, reflections, threads[i], ending);
    if (size != other_size || memcmp(bytes, other, size) != 0)
      fail_msg("%s, %s: another file with %s threads", scene, ending, threads[i] ? threads[i] : "all");
    free(other);
  }
  free(bytes);
}

static void a_room_is_the_same_file_for_any_number_of_threads(void **state)
{
  check("scenes/room.glb", "raster", "pbr", "rays", "exr");
  check("scenes/room.glb", "rays", "phong", "rays", "png");
}

static void mirrors_are_the_same_file_for_any_number_of_threads(void **state)
{
  check("scenes/chrome.glb", "raster", "pbr", "rays", "png");
}

static void cube_maps_are_the_same_file_for_any_number_of_threads(void **state)
{
  check("scenes/chrome.glb", "raster", "pbr", "impostor", "png");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_room_is_the_same_file_for_any_number_of_threads),
      cmocka_unit_test(mirrors_are_the_same_file_for_any_number_of_threads),
      cmocka_unit_test(cube_maps_are_the_same_file_for_any_number_of_threads),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
