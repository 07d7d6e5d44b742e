// Pictures of the shipped scenes as they were when someone last looked at them: tests/golden/*.png.
//
// A picture fails when more than 1 pixel in 1000 is off by more than 2/255: other CPUs and OpenCL compilers flip a
// sample at an edge here and there and round colours to the neighbouring byte. Eight lanes and Intel's compiler gave
// no such pixel; contraction of multiply and add, which the kernels forbid, gave 1 in 14400. What was rendered is then
// kept in BUILD/golden, with a picture of the difference.
//
// A change that is meant: look at BUILD/golden, then run the test with FRUGAL_UPDATE_GOLDENS=1 and commit what changed.

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "report/compare_files.h"
#include "support/cli.h"
#include "support/oracle_scene.h"

#define FOLDER "tests/golden"
#define MOST_OVER 0.001

static Log golden_log;
static ImageHelper *images;

static void assert_fine(Status status)
{
  if (status) fail_msg("%s", golden_log.error);
}

// Runs beside no render: cli_run counts the processes that are left.
static void helper_start(void)
{
  golden_log = (Log){0};
  assert_fine(image_helper_start(&images, 1 << 20, &golden_log));
}

static int helper_stop(void **state)
{
  if (images) image_helper_stop(images);
  images = NULL;
  return 0;
}

static bool is_updating(void) { return getenv("FRUGAL_UPDATE_GOLDENS") && *getenv("FRUGAL_UPDATE_GOLDENS"); }

// A folder for what fails, in the build.
static const char *kept_path(const char *name, const char *ending)
{
  static char path[2][4096];
  static int turn;
  turn = !turn;
  snprintf(path[turn], sizeof path[turn], "%s/golden", cli_build);
  if (mkdir(path[turn], 0777) != 0 && errno != EEXIST) fail_msg("%s: %s", path[turn], strerror(errno));
  snprintf(path[turn], sizeof path[turn], "%s/golden/%s%s", cli_build, name, ending);
  return path[turn];
}

static void file_copy(const char *to, const char *from)
{
  size_t size;
  char *bytes = cli_load(from, &size);
  assert_non_null(bytes);
  cli_save(to, bytes, size);
  free(bytes);
}

// A picture of nothing is no golden.
static void assert_signal(const char *path)
{
  ComparePicture picture;
  assert_fine(compare_picture_read(&picture, images, path, true, &golden_log));
  float low = INFINITY, high = 0;
  for (size_t i = 0; i < 4 * (size_t)picture.image.width * picture.image.height; i += 4) {
    low = fminf(low, picture.image.pixels[i]);
    high = fmaxf(high, picture.image.pixels[i]);
  }
  image_free(&picture.image);
  if (!(high - low > 0.5f)) fail_msg("%s: hardly anything to be seen", path);
}

static void golden_check(const char *name, const char *got)
{
  char golden[256];
  ImageError error;
  snprintf(golden, sizeof golden, FOLDER "/%s.png", name);
  assert_signal(got);
  if (is_updating()) {
    file_copy(golden, got);
    print_message("%s: updated\n", golden);
    return;
  }
  remove(kept_path(name, ".png"));
  remove(kept_path(name, ".difference.png"));
  assert_fine(image_compare_files(&error, images, golden, got, NULL, &golden_log));
  print_message("%-12s %.5f of the pixels over 2/255, rmse %.1e\n", name, error.over_share, error.rmse);
  if (error.over_share <= MOST_OVER && error.rmse <= 0.005) return;

  ComparePicture wanted, rendered;
  file_copy(kept_path(name, ".png"), got);
  assert_fine(compare_picture_read(&wanted, images, golden, true, &golden_log));
  assert_fine(compare_picture_read(&rendered, images, got, true, &golden_log));
  assert_fine(image_difference_write(images, kept_path(name, ".difference.png"), &wanted.image, &rendered.image, NULL,
                                     &golden_log));
  image_free(&wanted.image);
  image_free(&rendered.image);
  fail_msg("%s: %.4f of the pixels are off, rmse %.4f: see %s", golden, error.over_share, error.rmse,
           kept_path(name, ".difference.png"));
}

static void render(const char *path, const char *scene, const char *option, const char *value, const char *size)
{
  CliRun run = cli_run("render", scene, "-q", "-o", path, "-s", size, "-n", "4", option, value, NULL);
  if (run.exit_code != 0) fail_msg("%s: %s", scene, run.err);
  cli_free(&run);
}

static void shipped_check(const char *scene, const char *model)
{
  char name[64], file[64];
  snprintf(name, sizeof name, "%s_%s", scene, model);
  snprintf(file, sizeof file, "scenes/%s.glb", scene);
  const char *path = cli_path("%s.png", name);
  render(path, file, "--lighting", model, "160x90");
  helper_start();
  golden_check(name, path);
}

static void the_room_looks_as_it_did(void **state) { shipped_check("room", "pbr"); }
static void the_room_looks_as_it_did_in_phong(void **state) { shipped_check("room", "phong"); }

static void the_chrome_looks_as_it_did(void **state) { shipped_check("chrome", "pbr"); }
static void the_room_looks_as_it_did_by_maps(void **state)
{
  const char *path = cli_path("rough.png");
  render(path, "scenes/room.glb", "--reflections", "impostor", "160x90");
  helper_start();
  golden_check("room_impostor", path);
}

static void the_colonnade_looks_as_it_did(void **state) { shipped_check("colonnade", "phong"); }

// ---- AOVs -----------------------------------------------------------------------------------------------------------

// One sheet of all AOVs, each in colours of its own.
enum { TILE_WIDTH = 96, TILE_HEIGHT = 54, TILES = 9 };
typedef struct Sheet {
  float pixels[3 * TILE_HEIGHT][3 * TILE_WIDTH][3];
} Sheet;

static float *sheet_pixel(Sheet *sheet, int tile, int pixel)
{
  return sheet->pixels[tile / 3 * TILE_HEIGHT + pixel / TILE_WIDTH][tile % 3 * TILE_WIDTH + pixel % TILE_WIDTH];
}

// Channel c of the tile shows scale x value + offset, between 0 and 1; the background's infinity is 1.
static void floats_show(Sheet *sheet, int tile, const char *path, const char *const names[3], float scale, float offset)
{
  for (int c = 0; c < 3; c++) {
    ImageLayer layer;
    assert_fine(image_read_layer(&layer, images, path, names[c], &golden_log));
    assert_true(layer.width == TILE_WIDTH && layer.height == TILE_HEIGHT && layer.element == IMAGE_FLOAT);
    for (int i = 0; i < TILE_WIDTH * TILE_HEIGHT; i++)
      sheet_pixel(sheet, tile, i)[c] = fminf(1, fmaxf(0, ((const float *)layer.values)[i] * scale + offset));
    image_layer_free(&layer);
  }
}

static void ids_show(Sheet *sheet, int tile, const char *path, const char *name)
{
  ImageLayer layer;
  assert_fine(image_read_layer(&layer, images, path, name, &golden_log));
  assert_true(layer.width == TILE_WIDTH && layer.height == TILE_HEIGHT && layer.element == IMAGE_UINT32);
  for (int i = 0; i < TILE_WIDTH * TILE_HEIGHT; i++) {
    uint32_t hash = ((const uint32_t *)layer.values)[i] * 2654435761u;
    for (int c = 0; c < 3; c++) sheet_pixel(sheet, tile, i)[c] = (float)(hash >> (8 + 8 * c) & 255) / 255;
  }
  image_layer_free(&layer);
}

static void the_aovs_of_the_chrome_look_as_they_did(void **state)
{
  const char *aovs = "depth,position,normal,albedo,object,primitive,material,shadow,reflection";
  const char *exr = cli_path("aovs.exr"), *png = cli_path("aovs.png");
  Sheet *sheet = oracle_array(1, sizeof *sheet);
  render(exr, "scenes/chrome.glb", "--aov", aovs, "96x54");
  helper_start();
  floats_show(sheet, 0, exr, (const char *const[]){"depth.Z", "depth.Z", "depth.Z"}, 0.06f, 0);
  floats_show(sheet, 1, exr, (const char *const[]){"position.X", "position.Y", "position.Z"}, 0.08f, 0.5f);
  floats_show(sheet, 2, exr, (const char *const[]){"normal.X", "normal.Y", "normal.Z"}, 0.5f, 0.5f);
  floats_show(sheet, 3, exr, (const char *const[]){"albedo.R", "albedo.G", "albedo.B"}, 1, 0);
  ids_show(sheet, 4, exr, "object.id");
  ids_show(sheet, 5, exr, "primitive.id");
  ids_show(sheet, 6, exr, "material.id");
  floats_show(sheet, 7, exr, (const char *const[]){"shadow.Y", "shadow.Y", "shadow.Y"}, 1, 0);
  floats_show(sheet, 8, exr, (const char *const[]){"reflection.R", "reflection.G", "reflection.B"}, 1, 0);
  ImageChannels group = {{"R", "G", "B"}, 3, 3, sheet->pixels, 0};
  ImageOutput output = {3 * TILE_WIDTH, 3 * TILE_HEIGHT, &group, 1, 8, 95, "9", NULL, 0};
  assert_fine(image_write(images, png, NULL, &output, &golden_log));
  free(sheet);
  golden_check("chrome_aovs", png);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_teardown(the_room_looks_as_it_did, helper_stop),
      cmocka_unit_test_teardown(the_room_looks_as_it_did_in_phong, helper_stop),
      cmocka_unit_test_teardown(the_room_looks_as_it_did_by_maps, helper_stop),
      cmocka_unit_test_teardown(the_chrome_looks_as_it_did, helper_stop),
      cmocka_unit_test_teardown(the_colonnade_looks_as_it_did, helper_stop),
      cmocka_unit_test_teardown(the_aovs_of_the_chrome_look_as_they_did, helper_stop),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
