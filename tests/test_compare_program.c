// `frugal compare` says what the library says, and its exit code is what a script can rely on.
#include <fcntl.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "app/app.h"
#include "report/compare_files.h"
#include "report/image_metric.h"
#include "support/compare_pictures.h"
#include "support/image_fixture.h"

static char output[1 << 16], messages[1 << 13];

// Sends a stream to a file until stream_restore, which reads what came.
static int stream_divert(FILE *stream, const char *path)
{
  fflush(stream);
  int kept = dup(fileno(stream)), file = open(path, O_CREAT | O_TRUNC | O_RDWR, 0600);
  dup2(file, fileno(stream));
  close(file);
  return kept;
}

static void stream_restore(FILE *stream, int kept, const char *path, char *text, size_t size)
{
  fflush(stream);
  dup2(kept, fileno(stream));
  close(kept);
  uint8_t *bytes;
  size_t length = file_load(path, &bytes);
  assert_true(length < size);
  memcpy(text, bytes, length);
  text[length] = 0;
  free(bytes);
}

// Runs `frugal compare` with words separated by spaces; @ stands for the folder. Returns its exit code and sets
// `output` and `messages`.
static int run(const char *words)
{
  static char text[8192];
  char *argv[32] = {"compare"}, path_out[IMAGE_PATH_BYTES], path_err[IMAGE_PATH_BYTES];
  int argc = 1;
  size_t used = 0;
  for (const char *p = words; *p; p++)
    used += (size_t)snprintf(text + used, sizeof text - used, *p == '@' ? "%s" : "%.1s", *p == '@' ? image_folder : p);
  for (char *rest = NULL, *word = strtok_r(text, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
    argv[argc++] = word;
  snprintf(path_out, sizeof path_out, "%s/stdout", image_folder);
  snprintf(path_err, sizeof path_err, "%s/stderr", image_folder);
  int out = stream_divert(stdout, path_out), err = stream_divert(stderr, path_err);
  int code = app_compare(argc, argv);
  stream_restore(stdout, out, path_out, output, sizeof output);
  stream_restore(stderr, err, path_err, messages, sizeof messages);
  return code;
}

static void assert_run(const char *words, int code, const char *message)
{
  int got = run(words);
  if (got != code || !strstr(messages, message))
    fail_msg("compare %s: exit code %d, not %d: '%s' without '%s'", words, got, code, messages, message);
}

static void write_picture(const char *name, const Image *image, uint32_t channels)
{
  ImageChannels group = {{"R", "G", "B", "A"}, channels, 4, image->pixels, 0};
  ImageOutput picture = {image->width, image->height, &group, 1, 16, 95, NULL, NULL, 0};
  assert_ok(image_write(image_helper, path_of(name), NULL, &picture, &image_log));
}

enum { SIDE = 32 };

// An EXR of one colour, red in the left half of the picture, with object ids 3 left and 5 right, primitives 0 above
// and 1 below, and the background in the last row.
static void write_objects(const char *name, float red)
{
  Image image = picture_make(SIDE, SIDE);
  uint32_t ids[SIDE * SIDE * 2];
  float depth[SIDE * SIDE];
  for (uint32_t y = 0; y < SIDE; y++)
    for (uint32_t x = 0; x < SIDE; x++) {
      picture_set(&image, x, y, x < SIDE / 2 ? red : 0.5, 0.5, 0.5);
      ids[2 * (y * SIDE + x)] = y == SIDE - 1 ? UINT32_MAX : x < SIDE / 2 ? 3 : 5;
      ids[2 * (y * SIDE + x) + 1] = y == SIDE - 1 ? UINT32_MAX : y >= SIDE / 2;
      depth[y * SIDE + x] = INFINITY;
    }
  ImageChannels groups[] = {{{"R", "G", "B", "A"}, 4, 4, image.pixels, 0},
                            {{"object.id", "primitive.id"}, 2, 2, ids, 1},
                            {{"depth.Z"}, 1, 1, depth, 0}};
  ImageOutput picture = {SIDE, SIDE, groups, 3, 8, 95, NULL, NULL, 0};
  assert_ok(image_write(image_helper, path_of(name), NULL, &picture, &image_log));
  image_free(&image);
}

static void write_all(void)
{
  PicturePair ldr = picture_pair_make(0), hdr = picture_pair_make(6), small = picture_pair_make(8);
  write_picture("a.png", &ldr.a, 3);
  write_picture("b.png", &ldr.b, 3);
  write_picture("alpha.png", &ldr.a, 4);
  write_picture("grey.png", &ldr.a, 1);
  write_picture("a.exr", &hdr.a, 3);
  write_picture("b.exr", &hdr.b, 3);
  write_picture("small_a.exr", &small.a, 3);
  write_picture("small_b.exr", &small.b, 3);
  hdr.b.pixels[4 * 1234 + 1] = NAN;
  write_picture("nan.exr", &hdr.b, 3);
  write_objects("objects_a.exr", 0.5f);
  write_objects("objects_b.exr", 0.6f);
  picture_pair_free(&ldr);
  picture_pair_free(&hdr);
  picture_pair_free(&small);
}

static ImageError compare_files(const char *a, const char *b)
{
  const ImageCompareOptions options = {.flip = true, .hdr_flip = true, .ssim = true};
  ImageError error;
  assert_ok(image_compare_files(&error, image_helper, path_of(a), path_of(b), &options, &image_log));
  return error;
}

static void assert_files_refused(const char *a, const char *b, Status expected, const char *message)
{
  ImageError error;
  Status status = image_compare_files(&error, image_helper, path_of(a), path_of(b), NULL, &image_log);
  assert_fails(status, expected, message);
}

static void json_holds_what_the_library_says(void **state)
{
  ImageError error = compare_files("a.exr", "b.exr");
  assert_run("@/a.exr @/b.exr --json --metrics all --fail-over rmse=1e9", 0, "");
  json_t *report = json_loads(output, 0, NULL);
  assert_non_null(report);
  json_t *metrics = json_object_get(report, "metrics");
  assert_int_equal(json_object_size(metrics), IMAGE_METRIC_COUNT);
  for (int m = 0; m < IMAGE_METRIC_COUNT; m++) {
    char key[32];
    snprintf(key, sizeof key, "%s", image_metrics[m].name);
    for (char *p = key; *p; p++)
      if (*p == '-') *p = '_';
    assert_true(json_real_value(json_object_get(metrics, key)) == image_metric_value(m, &error));
  }
  assert_int_equal(json_integer_value(json_object_get(report, "pixels")), (int)error.pixels);
  assert_int_equal(json_integer_value(json_object_get(report, "pixels_over")), (int)error.over);
  assert_true(json_is_true(json_object_get(report, "passed")));
  assert_int_equal(json_array_size(json_object_get(report, "limits")), 1);
  json_decref(report);
}

static void verdict_is_the_exit_code(void **state)
{
  assert_run("@/a.png @/b.png", 0, "");
  assert_non_null(strstr(output, "max-displayed"));
  assert_null(strstr(output, "hdr-flip"));
  assert_run("@/a.png @/b.png --fail-over over=0", 1, "b.png: over is ");
  assert_non_null(strstr(output, "FAILED"));
  assert_run("@/a.png @/b.png --fail-over over=1 --fail-over rmse=1 --fail-under ssim=0.1", 0, "");
  assert_run("@/a.png @/b.png --fail-over over=1 --fail-under ssim=0.9999 --json", 1, "b.png: ssim is ");
  assert_non_null(strstr(output, "\"passed\": false"));
  assert_run("@/a.png @/b.png --threshold 254/255 --fail-over over=0", 0, "");
}

// Infinite psnr keeps every limit; JSON has no number for it.
static void equal_pictures_keep_every_limit(void **state)
{
  assert_run("@/a.png @/a.png --json --fail-over max=0 --fail-over flip=0 --fail-under psnr=999 --fail-under ssim=1", 0,
             "");
  json_t *report = json_loads(output, 0, NULL);
  assert_true(json_is_null(json_object_get(json_object_get(report, "metrics"), "psnr")));
  json_decref(report);
}

static void what_cannot_be_compared_is_never_a_pass(void **state)
{
  assert_files_refused("none.png", "a.png", STATUS_NOT_FOUND, "none.png: ");
  assert_files_refused("a.png", "small_a.exr", STATUS_BAD_IMAGE, "small_a.exr: 7 x 5 pixels, and ");
  assert_files_refused("a.png", "alpha.png", STATUS_BAD_IMAGE, "alpha.png: RGBA, and ");
  assert_files_refused("a.png", "grey.png", STATUS_BAD_IMAGE, "grey.png: grey, and ");
  assert_files_refused("a.exr", "nan.exr", STATUS_BAD_IMAGE, "nan.exr: 1 pixels are not finite, the first at 34,8");
  assert_files_refused("nan.exr", "nan.exr", STATUS_BAD_IMAGE, "not finite");
  assert_run("@/a.png @/none.png", 4, "none.png: ");
  assert_run("@/a.exr @/nan.exr --fail-over max=1e9", 4, "nan.exr: 1 pixels");
  assert_run("@/small_a.exr @/small_b.exr --fail-under ssim=-1", 4, "no ssim of so few pixels");
  assert_run("@/small_a.exr @/small_b.exr --max-image-pixels 34", 4, "raise --max-image-pixels");
}

static void misuse_is_told_with_what_is_expected(void **state)
{
  assert_run("@/a.png", 2, "needs two pictures");
  assert_run("@/a.png @/b.png @/a.png", 2, "one too many");
  assert_run("@/a.png @/b.png --fail-over fpil=0.1", 2, "did you mean 'flip'");
  assert_run("@/a.png @/b.png --fail-over flip", 2, "expected METRIC=X");
  assert_run("@/a.png @/b.png --fail-over flip=", 2, "expected a number");
  assert_run("@/a.png @/b.png --fail-over flip=nan", 2, "expected a number");
  assert_run("@/a.png @/b.png --fail-over ssim=0.9", 2, "use --fail-under");
  assert_run("@/a.png @/b.png --fail-under flip=0.9", 2, "use --fail-over");
  assert_run("@/a.png @/b.png --metrics flip,", 2, "no such metric");
  assert_run("@/a.png @/b.png --threshold 0", 2, "between 0 and 1");
  assert_run("@/a.png @/b.png --threshold 2/0", 2, "between 0 and 1");
  assert_run("@/a.png @/b.png --diff @/d.bmp", 2, "d.bmp: unknown kind of picture");
  assert_run("@/a.png @/b.png --metrics hdr-flip", 2, "a.png: holds no radiance");
  assert_run("--help", 0, "");
  assert_memory_equal(output, "Examples:", 9);
}

static Status mask_select(uint8_t mask[SIDE * SIDE], const char *selection)
{
  char text[IMAGE_PATH_BYTES];
  snprintf(text, sizeof text, "%s/objects_a.exr:%s", image_folder, selection);
  return compare_mask_select(mask, SIDE, SIDE, image_helper, text, &image_log);
}

static void mask_selects_pixels_by_their_ids(void **state)
{
  static const struct {
    const char *selection;
    uint32_t left, top, right, bottom;
  } cases[] = {
      {"object=3", 0, 0, SIDE / 2, SIDE - 1}, {"object=5", SIDE / 2, 0, SIDE, SIDE - 1},
      {"object=3,5", 0, 0, SIDE, SIDE - 1},   {"object=77,3", 0, 0, SIDE / 2, SIDE - 1},
      {"object=-1", 0, SIDE - 1, SIDE, SIDE}, {"primitive.id=1", 0, SIDE / 2, SIDE, SIDE - 1},
  };
  uint8_t mask[SIDE * SIDE];
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    memset(mask, 1, sizeof mask);
    assert_ok(mask_select(mask, cases[i].selection));
    for (uint32_t y = 0; y < SIDE; y++)
      for (uint32_t x = 0; x < SIDE; x++)
        assert_int_equal(mask[y * SIDE + x],
                         x >= cases[i].left && x < cases[i].right && y >= cases[i].top && y < cases[i].bottom);
  }
  assert_fails(mask_select(mask, "object=4"), STATUS_BAD_IMAGE,
               "any of the ids asked for: those of object.id end at 5");
  assert_fails(mask_select(mask, "depth.Z=1"), STATUS_BAD_IMAGE, "objects_a.exr: depth.Z holds no ids");
  assert_fails(mask_select(mask, "material=1"), STATUS_BAD_IMAGE, "objects_a.exr: no channel material.id");
  static const char *const malformed[] = {"object", "object=", "object=3,", "object=3;5", "object=-2", "=3", ""};
  for (size_t i = 0; i < sizeof malformed / sizeof *malformed; i++)
    assert_fails(mask_select(mask, malformed[i]), STATUS_USAGE, "expected FILE:AOV=IDS");
  Status status = compare_mask_select(mask, 16, 64, image_helper, path_of("objects_a.exr:object=3"), &image_log);
  assert_fails(status, STATUS_BAD_IMAGE, "objects_a.exr: 32 x 32 pixels, and the pictures have 16 x 64");

  assert_run(
      "@/objects_a.exr @/objects_b.exr --metrics over --json --mask @/objects_a.exr:object=3 "
      "--mask @/objects_b.exr:primitive=1",
      0, "");
  json_t *report = json_loads(output, 0, NULL);
  assert_int_equal(json_integer_value(json_object_get(report, "pixels")), SIDE / 2 * 15);
  assert_int_equal(json_integer_value(json_object_get(report, "pixels_over")), SIDE / 2 * 15);
  json_decref(report);
}

// Straight alpha is weighed by it, as seen over black: what is wholly transparent has no colour.
static void transparent_pixels_have_no_colour(void **state)
{
  Image a = picture_make(12, 12), b = picture_make(12, 12);
  for (uint32_t i = 0; i < 12 * 12; i++) {
    b.pixels[4 * i] = 1;
    a.pixels[4 * i + 3] = b.pixels[4 * i + 3] = 0;
  }
  write_picture("clear_a.png", &a, 4);
  write_picture("clear_b.png", &b, 4);
  ImageError error = compare_files("clear_a.png", "clear_b.png");
  assert_true(error.max == 0 && error.over == 0 && error.flip == 0);
  assert_run("@/clear_a.png @/clear_b.png --fail-over max=0 --ignore-alpha", 1, "max is 1");
  image_free(&a);
  image_free(&b);
}

// A linear file and a display-encoded one of the same picture: 16 bits leave half a step of error.
static void display_encoding_is_undone(void **state)
{
  PicturePair pair = picture_pair_make(0);
  Image encoded = picture_make(pair.a.width, pair.a.height);
  for (size_t i = 0; i < 4 * (size_t)pair.a.width * pair.a.height; i++) {
    double v = pair.a.pixels[i];
    encoded.pixels[i] = (float)(v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055);
  }
  write_picture("linear.exr", &pair.a, 3);
  write_picture("encoded.png", &encoded, 3);
  ImageError error = compare_files("linear.exr", "encoded.png");
  assert_true(error.max_displayed > 0 && error.max_displayed < 0.6 / 65535 + 1e-6);
  image_free(&encoded);
  picture_pair_free(&pair);
}

static void difference_picture_shows_where_and_how_much(void **state)
{
  enum { EQUAL, UNDER, AT, OVER, MOST, OUTSIDE, CASE_COUNT };
  static const float displayed[CASE_COUNT] = {0, 10.0f / 255, 20.0f / 255, 21.0f / 255, 1, 1};
  static const uint8_t expected[CASE_COUNT][3] = {{0, 0, 0}, {13, 38, 128},   {26, 77, 255},
                                                  {0, 0, 0}, {255, 255, 255}, {64, 64, 64}};
  Image black = picture_make(CASE_COUNT, 1), image = picture_make(CASE_COUNT, 1);
  uint32_t ids[CASE_COUNT] = {1, 1, 1, 1, 1, 2};
  for (uint32_t x = 0; x < CASE_COUNT; x++) picture_set(&image, x, 0, 0, displayed[x], 0);
  write_picture("black.png", &black, 3);
  write_picture("steps.png", &image, 3);
  ImageChannels group = {{"object.id"}, 1, 1, ids, 1};
  ImageOutput mask = {CASE_COUNT, 1, &group, 1, 0, 0, NULL, NULL, 0};
  assert_ok(image_write(image_helper, path_of("mask.exr"), NULL, &mask, &image_log));
  assert_run("@/black.png @/steps.png --threshold 20/255 --mask @/mask.exr:object=1 --diff @/d.png --fail-over max=0",
             1, "d.png");
  Image difference = read_image(path_of("d.png"), IMAGE_TEXTURE);
  for (int x = 0; x < CASE_COUNT; x++) {
    const uint8_t *got = difference.texels + 4 * x;
    for (int c = 0; c < 3 && x != OVER; c++) assert_true(abs(got[c] - expected[x][c]) <= 1);
  }
  const uint8_t *over = difference.texels + 4 * OVER;
  assert_true(over[1] > 150 && over[2] < 80 && over[0] < 80);  // green, and no blue as just before
  image_free(&difference);
  image_free(&black);
  image_free(&image);
  assert_run("@/a.png @/b.png --diff @/none/d.png", 5, "none/d.png: ");
}

// Files over 4 MB have a helper each.
static void large_files_are_compared_too(void **state)
{
  Image image = picture_make(700, 600);
  for (int second = 0; second < 2; second++) {
    picture_set(&image, 123, 456, second, 0, 0);
    ImageChannels group = {{"R", "G", "B"}, 3, 4, image.pixels, 0};
    ImageOutput picture = {700, 600, &group, 1, 0, 0, "none", NULL, 0};
    assert_ok(image_write(image_helper, path_of(second ? "large_b.exr" : "large_a.exr"), NULL, &picture, &image_log));
  }
  assert_run("@/large_a.exr @/large_b.exr --metrics max --fail-over max=0.5", 1, "large_b.exr: max is 1");
  assert_non_null(strstr(output, "1 of 420000 pixels are over 0.00784314; the worst is at 123,456"));
  image_free(&image);
}

static int set_up(void **state)
{
  if (image_set_up(state) != 0) return -1;
  write_all();
  return 0;
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      IMAGE_TEST(json_holds_what_the_library_says),
      IMAGE_TEST(verdict_is_the_exit_code),
      IMAGE_TEST(equal_pictures_keep_every_limit),
      IMAGE_TEST(what_cannot_be_compared_is_never_a_pass),
      IMAGE_TEST(misuse_is_told_with_what_is_expected),
      IMAGE_TEST(mask_selects_pixels_by_their_ids),
      IMAGE_TEST(transparent_pixels_have_no_colour),
      IMAGE_TEST(display_encoding_is_undone),
      IMAGE_TEST(difference_picture_shows_where_and_how_much),
      IMAGE_TEST(large_files_are_compared_too),
  };
  return cmocka_run_group_tests(tests, set_up, image_tear_down);
}
