// FLIP gives what its authors' own evaluator gives, of displayed pictures and of radiance.
//
// `test_compare_flip --write FOLDER` writes the pictures for tests/compare_flip_reference, which made the table below.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/parallel.h"
#include "report/flip.h"
#include "support/compare_pictures.h"
#include "support/image_fixture.h"

// Where the map is looked at: a corner, the middle and a place between, as parts of the size.
enum { PLACE_COUNT = 3 };
static const double places[PLACE_COUNT][2] = {{0, 0}, {0.5, 0.5}, {0.7, 0.2}};

typedef struct FlipRow {
  const char *pair;
  double pixels_per_degree;  // 0: the default
  double mean, at[PLACE_COUNT];
} FlipRow;

// flip-evaluator 1.7, by tests/compare_flip_reference.
static const FlipRow rows[] = {
    {"noise", 0, 0.0639217, {0.1392218, 0.0475748, 0.0794224}},
    {"noise", 20, 0.1706880, {0.2049603, 0.2263830, 0.2702639}},
    {"shift", 0, 0.1588249, {0.1503046, 0.1458234, 0.1290042}},
    {"checkers", 0, 0.1128891, {0.8558931, 0.1071376, 0.1034170}},
    {"hue", 0, 0.3014598, {0.3191862, 0.3019139, 0.2831782}},
    {"fireflies", 0, 0.0352431, {0.0000401, 0.0003492, 0.0000610}},
    {"edge", 0, 0.0336532, {0.0000000, 0.0014238, 0.0000000}},
    {"edge", 150, 0.0418327, {0.0000000, 0.0585252, 0.0000000}},
    {"radiance", 0, 0.0566907, {0.2212076, 0.0420622, 0.0984247}},
    {"radiance", 20, 0.1565804, {0.2863010, 0.2614414, 0.2205770}},
    {"sun", 0, 0.6019580, {0.0682212, 0.9704917, 0.9705012}},
    {"small", 0, 0.0579547, {0.1898417, 0.0486841, 0.0162823}},
    {"small", 150, 0.0678328, {0.1438244, 0.0629083, 0.0402442}},
};

// Both work in single precision, and the root in the feature difference turns the 1e-8 that rounding leaves in a flat
// filtered area into 1e-4.
static const double MEAN_TOLERANCE = 5e-5, PIXEL_TOLERANCE = 2e-4;

static PicturePair pair_named(const char *name)
{
  for (int i = 0; i < PICTURE_PAIR_COUNT; i++) {
    PicturePair pair = picture_pair_make(i);
    if (!strcmp(pair.name, name)) return pair;
    picture_pair_free(&pair);
  }
  fail_msg("no pair %s", name);
  return (PicturePair){0};
}

static double flip_mean(const Image *a, const Image *b, const FlipOptions *options)
{
  double mean = NAN;
  assert_int_equal(flip_compare(&mean, a, b, options, NULL), STATUS_OK);
  return mean;
}

static float *map_make(const Image *image) { return malloc((size_t)image->width * image->height * sizeof(float)); }

static size_t place_index(const Image *image, int place)
{
  size_t x = (size_t)(places[place][0] * image->width), y = (size_t)(places[place][1] * image->height);
  return y * image->width + x;
}

static void the_authors_evaluator_agrees(void **state)
{
  bool seen[2] = {false};
  for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
    PicturePair pair = pair_named(rows[r].pair);
    float *map = map_make(&pair.a);
    FlipOptions options = {.hdr = pair.hdr, .pixels_per_degree = rows[r].pixels_per_degree, .map = map};
    double mean = flip_mean(&pair.a, &pair.b, &options);
    if (!(fabs(mean - rows[r].mean) <= MEAN_TOLERANCE))
      fail_msg("%s at %g: mean %.7f, not %.7f", pair.name, rows[r].pixels_per_degree, mean, rows[r].mean);
    for (int p = 0; p < PLACE_COUNT; p++) {
      float got = map[place_index(&pair.a, p)];
      if (!(fabs(got - rows[r].at[p]) <= PIXEL_TOLERANCE))
        fail_msg("%s at %g: pixel %d %.7f, not %.7f", pair.name, rows[r].pixels_per_degree, p, got, rows[r].at[p]);
    }
    seen[pair.hdr] = true;
    free(map);
    picture_pair_free(&pair);
  }
  assert_true(seen[0] && seen[1]);
}

static void equal_pictures_do_not_flip(void **state)
{
  for (int i = 0; i < PICTURE_PAIR_COUNT; i++) {
    PicturePair pair = picture_pair_make(i);
    assert_true(flip_mean(&pair.a, &pair.a, &(FlipOptions){.hdr = false}) == 0);
    assert_true(flip_mean(&pair.a, &pair.a, &(FlipOptions){.hdr = true}) == 0);
    picture_pair_free(&pair);
  }
}

// The paper scales the color difference so that green against blue, its largest, is 1. Flat pictures have no features.
static void green_against_blue_is_1(void **state)
{
  Image green = picture_make(140, 70), blue = picture_make(140, 70);
  for (uint32_t y = 0; y < green.height; y++)
    for (uint32_t x = 0; x < green.width; x++) {
      picture_set(&green, x, y, 0, 1, 0);
      picture_set(&blue, x, y, 0, 0, 1);
    }
  assert_true(fabs(flip_mean(&green, &blue, &(FlipOptions){.hdr = false}) - 1) < 1e-6);
  image_free(&green);
  image_free(&blue);
}

static void values_a_display_cannot_show_are_clamped(void **state)
{
  Image a = picture_make(40, 30), b = picture_make(40, 30);
  for (uint32_t x = 0; x < 40; x++) {
    picture_set(&a, x, 7, 3, 1e30, -5);
    picture_set(&b, x, 7, 1, 1, 0);
  }
  assert_true(flip_mean(&a, &b, &(FlipOptions){.hdr = false}) == 0);
  double hdr = flip_mean(&a, &b, &(FlipOptions){.hdr = true});
  assert_true(hdr > 0 && hdr <= 1);
  image_free(&a);
  image_free(&b);
}

static void masked_mean_is_the_mean_of_the_map_in_the_mask(void **state)
{
  PicturePair pair = pair_named("noise");
  size_t count = (size_t)pair.a.width * pair.a.height, masked = 0;
  uint8_t *mask = calloc(count, 1);
  float *map = map_make(&pair.a);
  double sum = 0;
  flip_mean(&pair.a, &pair.b, &(FlipOptions){.map = map});
  for (size_t i = 0; i < count; i += 7) {
    mask[i] = 1;
    masked++;
    sum += map[i];
  }
  double mean = flip_mean(&pair.a, &pair.b, &(FlipOptions){.mask = mask});
  assert_true(fabs(mean - sum / (double)masked) < 1e-12);
  free(mask);
  free(map);
  picture_pair_free(&pair);
}

static void threads_do_not_change_a_bit(void **state)
{
  PicturePair pair = pair_named("radiance");
  const FlipOptions options = {.hdr = true};
  parallel_set_threads(1);
  double one = flip_mean(&pair.a, &pair.b, &options);
  parallel_set_threads(3);
  double three = flip_mean(&pair.a, &pair.b, &options);
  parallel_set_threads(0);
  assert_memory_equal(&one, &three, sizeof one);
  picture_pair_free(&pair);
}

static void a_black_reference_takes_the_exposures_of_the_other(void **state)
{
  Image black = picture_make(30, 20), grey = picture_make(30, 20);
  for (uint32_t x = 0; x < 30; x++) picture_set(&grey, x, 3, 1e-3, 1e-3, 1e-3);
  const FlipOptions options = {.hdr = true};
  assert_true(flip_mean(&black, &black, &options) == 0);
  double mean = flip_mean(&black, &grey, &options);
  assert_true(mean > 0.01 && mean <= 1);
  image_free(&black);
  image_free(&grey);
}

static Status picture_write(ImageHelper *helper, const char *folder, const char *name, const char *suffix,
                            const Image *image, bool display, Log *log)
{
  char path[4096];
  size_t values = 4 * (size_t)image->width * image->height;
  float *pixels = malloc(values * sizeof *pixels);
  for (size_t i = 0; i < values; i++) {
    double v = fmin(fmax(image->pixels[i], 0), 1);
    pixels[i] = display ? (float)(v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055) : image->pixels[i];
  }
  ImageChannels group = {{"R", "G", "B"}, 3, 4, pixels, 0};
  ImageOutput output = {.width = image->width,
                        .height = image->height,
                        .groups = &group,
                        .group_count = 1,
                        .bit_depth = 8,
                        .quality = 95};
  snprintf(path, sizeof path, "%s/%s_%s", folder, name, suffix);
  Status status = image_write(helper, path, NULL, &output, log);
  free(pixels);
  return status;
}

static Status pairs_write(const char *folder, Log *log)
{
  Status status = STATUS_OK;
  ImageHelper *helper = NULL;
  PicturePair pair = {0};
  TRY(image_helper_start(&helper, IMAGE_MAX_PIXELS, log));
  for (int i = 0; i < PICTURE_PAIR_COUNT; i++) {
    pair = picture_pair_make(i);
    TRY(picture_write(helper, folder, pair.name, "a.exr", &pair.a, false, log));
    TRY(picture_write(helper, folder, pair.name, "b.exr", &pair.b, false, log));
    if (!pair.hdr) TRY(picture_write(helper, folder, pair.name, "a.png", &pair.a, true, log));
    if (!pair.hdr) TRY(picture_write(helper, folder, pair.name, "b.png", &pair.b, true, log));
    printf("%s %s\n", pair.name, pair.hdr ? "hdr" : "ldr");
    picture_pair_free(&pair);
  }

done:
  picture_pair_free(&pair);
  image_helper_stop(helper);
  return status;
}

int main(int argc, char **argv)
{
  Log log = {0};
  if (argc == 3 && !strcmp(argv[1], "--write")) {
    if (pairs_write(argv[2], &log) == STATUS_OK) return 0;
    fprintf(stderr, "%s\n", log.error);
    return 1;
  }
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_authors_evaluator_agrees),
      cmocka_unit_test(equal_pictures_do_not_flip),
      cmocka_unit_test(green_against_blue_is_1),
      cmocka_unit_test(values_a_display_cannot_show_are_clamped),
      cmocka_unit_test(masked_mean_is_the_mean_of_the_map_in_the_mask),
      cmocka_unit_test(threads_do_not_change_a_bit),
      cmocka_unit_test(a_black_reference_takes_the_exposures_of_the_other),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
