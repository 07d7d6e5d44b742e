// Kernels compiled by a second process: those that the picture needs, whatever becomes of it.

#include <ftw.h>
#include <limits.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "render/compile_ahead.h"
#include "scene/gltf.h"
#include "support/cli.h"
#include "support/effort.h"
#include "support/picture_fixture.h"
#include "support/test_device.h"

static const char scene_path[] = "scenes/room.glb";
static const char remark[] = " generated";  // "1 warning generated."
static const char told[] = "compiling kernels in a second process too";

static bool skips(void)
{
  if (effort_is_quick()) fprintf(stderr, "SKIPPED: kernels compiled anew: too slow in a build like this\n");
  return effort_is_quick() || test_skips_on_gpu("kernels that compile for seconds");
}

// Compiled kernels in a cache: their paths from its top.
typedef struct Kernels {
  char paths[32][256];
  int count;
} Kernels;

static Kernels found;
static size_t top_length;

static int kernel_add(const char *path, const struct stat *file, int type, struct FTW *where)
{
  const char *end = strrchr(path, '.'), *part = path + top_length;
  if (type != FTW_F || !end || strcmp(end, ".so") != 0 || !strchr(part + 1, '/')) return 0;
  assert_true(found.count < 32 && strlen(part) < sizeof found.paths[0]);
  strcpy(found.paths[found.count++], part);
  return 0;
}

static Kernels kernels_in(const char *cache)
{
  found = (Kernels){0};
  top_length = strlen(cache);
  assert_int_equal(nftw(cache, kernel_add, 16, FTW_PHYS), 0);
  return found;
}

static bool kernels_have(const Kernels *kernels, const char *part)
{
  for (int i = 0; i < kernels->count; i++)
    if (strstr(kernels->paths[i], part)) return true;
  return false;
}

// Has the next run start with an empty cache of that name, and returns its path.
static const char *cache_take(const char *name)
{
  static char variable[PATH_MAX];
  const char *cache = cli_path("%s", name);
  snprintf(variable, sizeof variable, "POCL_CACHE_DIR=%s", cache);
  cli_setting.environment[0] = variable;
  return cache;
}

// What a frame of the scene needs, as the program knows it before images are decoded.
static void request_make(DeviceScene *features, Plan *plan)
{
  Log log = {0};
  Scene scene = {0};
  ImageHelper *images = NULL;
  const GltfOptions options = {.scene = NONE, .max_memory_bytes = 1 << 30};
  RenderSettings settings = picture_request(96, 54, 1).settings;
  settings.primary = PRIMARY_RASTER;
  assert_int_equal(image_helper_start(&images, 1 << 24, &log), STATUS_OK);
  assert_int_equal(gltf_read(&scene, scene_path, &options, images, &log), STATUS_OK);
  const SceneFacts facts = {.light_count = scene.light_count,
                            .triangle_count = scene_triangle_count(&scene),
                            .pixel_count = 96 * 54,
                            .has_mirrors = true};
  *features = (DeviceScene){0};
  device_scene_features(features, &scene);
  *plan = plan_make(&settings, &facts);
  scene_free(&scene);
  image_helper_stop(images);
  // The leak checker's process, which the helper leaves behind where it is stopped while that looks.
  while (waitpid(-1, NULL, 0) > 0) continue;
}

// Waits for the second process, which stays to be reaped. Returns its exit code, -1 for a signal.
static int process_wait(void)
{
  siginfo_t info = {0};
  assert_int_equal(waitid(P_ALL, 0, &info, WEXITED | WNOWAIT), 0);
  return info.si_code == CLD_EXITED ? info.si_status : -1;
}

// A picture of the scene; fails the test unless a second process is told of as expected.
static void render(const char *name, const char *threads, bool ahead)
{
  CliRun run = cli_run("render", scene_path, "-o", cli_path("%s.exr", name), "-s", "96x54", "--primary", "raster", "-v",
                       "--threads", threads, NULL);
  cli_expect(&run, 0, ahead ? told : "written", __FILE__, __LINE__);
  assert_true(ahead || !strstr(run.err, told));
  if (strstr(run.err, remark)) fail_msg("%s", run.err);
  cli_free(&run);
}

// Each by the path that PoCL makes of the source, the options and the device.
static void it_compiles_kernels_that_the_picture_needs(void **state)
{
  static const char *const most[] = {"/resolve/",   "/accumulate/", "/trace_closest/",
                                     "/trace_any/", "/shade/",      "/visibility_bins/"};
  DeviceScene features;
  Plan plan;
  if (skips()) return;
  request_make(&features, &plan);
  const char *ahead_cache = cli_path("ahead");
  const char *cache = getenv("POCL_CACHE_DIR");
  setenv("POCL_CACHE_DIR", ahead_cache, 1);
  assert_int_equal(compile_ahead_start(test_device(), &features, &plan), STATUS_OK);
  assert_int_equal(process_wait(), 0);
  compile_ahead_end();
  setenv("POCL_CACHE_DIR", cache, 1);
  Kernels ahead = kernels_in(ahead_cache);
  for (size_t i = 0; i < sizeof most / sizeof *most; i++)
    if (!kernels_have(&ahead, most[i])) fail_msg("%s was not compiled", most[i]);

  const char *alone_cache = cache_take("alone");
  render("alone", "1", false);
  Kernels alone = kernels_in(alone_cache);
  for (int i = 0; i < ahead.count; i++)
    if (!kernels_have(&alone, ahead.paths[i])) fail_msg("%s is none of the picture's", ahead.paths[i]);
}

// alone.exr is the picture of the test before, made without.
static void it_changes_no_byte_of_the_picture(void **state)
{
  if (skips()) return;
  cache_take("beside");
  render("beside", "2", true);
  size_t sizes[2];
  char *pictures[2] = {cli_load(cli_path("alone.exr"), &sizes[0]), cli_load(cli_path("beside.exr"), &sizes[1])};
  assert_true(pictures[0] && pictures[1] && sizes[0] == sizes[1]);
  assert_memory_equal(pictures[0], pictures[1], sizes[0]);
  free(pictures[0]);
  free(pictures[1]);
}

// The cache is the one that alone.exr was made with.
static void cached_kernels_need_none(void **state)
{
  if (skips()) return;
  cache_take("alone");
  render("again", "2", false);
}

// The runner of programs sees processes that are left behind.
static void it_ends_with_the_program(void **state)
{
  static const struct {
    int signal, exit_code;
  } ends[] = {{SIGINT, 130}, {SIGTERM, 143}, {SIGKILL, -1}};
  if (skips()) return;
  for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
    cache_take(i ? "ended_1" : "ended_0");
    cli_setting.signal_after = told;
    cli_setting.signal = ends[i].signal;
    CliRun run = cli_run("render", scene_path, "-o", cli_path("x.png"), "-s", "96x54", "-v", "--threads", "2", NULL);
    assert_int_equal(run.exit_code, ends[i].exit_code);
    assert_true(run.signal_ms > 0);
    cli_free(&run);
  }
}

static void its_failure_is_none_of_the_program(void **state)
{
  DeviceScene features;
  Plan plan;
  request_make(&features, &plan);
  assert_int_equal(compile_ahead_start("no such device", &features, &plan), STATUS_OK);
  assert_int_equal(compile_ahead_start("no such device", &features, &plan), STATUS_USAGE);  // one at a time
  assert_int_equal(process_wait(), 2);
  compile_ahead_end();
  compile_ahead_end();
  compile_ahead_kill();
  assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
  assert_int_equal(compile_ahead_start(NULL, &features, &plan), STATUS_OK);
  compile_ahead_end();
  assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
  CLI_EXPECT(2, "nothing to do", COMPILE_AHEAD_COMMAND);
}

// PoCL shows what the compiler remarks on to whoever renders. The runner of programs looks for it in what they print.
// In the cache are kernels that the tests before compiled, and looked at.
static void compiler_has_nothing_to_remark(void **state)
{
  if (skips()) skip();
  cache_take("alone");
  CliRun run = cli_run("render", scene_path, "-o", cli_path("remarks.png"), "-s", "16x16", "--primary", "raster",
                       "--shadows", "hybrid", "--reflections", "impostor", "--verify", "64", NULL);
  cli_expect(&run, 0, "compiling kernels", __FILE__, __LINE__);
  if (strstr(run.err, remark)) fail_msg("%s", run.err);
  cli_free(&run);
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(it_compiles_kernels_that_the_picture_needs),
      cmocka_unit_test(it_changes_no_byte_of_the_picture),
      cmocka_unit_test(cached_kernels_need_none),
      cmocka_unit_test(it_ends_with_the_program),
      cmocka_unit_test(its_failure_is_none_of_the_program),
      cmocka_unit_test(compiler_has_nothing_to_remark),
  };
  Log log = {0};
  if (argc > 1 && !strcmp(argv[1], COMPILE_AHEAD_COMMAND))
    return status_exit_code(compile_ahead_run(STDIN_FILENO, &log));
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
