// The program as people and scripts use it.
#include <fcntl.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "image/image.h"
#include "support/cli.h"

#define SIZE "64x48"
enum { WIDTH = 64, HEIGHT = 48 };

static bool holds(const char *bytes, size_t size, const char *text)
{
  return memmem(bytes, size, text, strlen(text)) != NULL;
}

static void assert_holds(const char *path, const char *text)
{
  size_t size = 0;
  char *bytes = cli_load(path, &size);
  if (!bytes || !holds(bytes, size, text)) fail_msg("%s does not hold '%s'", path, text);
  free(bytes);
}

static void assert_same_bytes(const char *a, const char *b)
{
  size_t a_size = 0, b_size = 0;
  char *a_bytes = cli_load(a, &a_size), *b_bytes = cli_load(b, &b_size);
  assert_non_null(a_bytes);
  assert_non_null(b_bytes);
  if (a_size != b_size || memcmp(a_bytes, b_bytes, a_size) != 0) fail_msg("%s and %s differ", a, b);
  free(a_bytes);
  free(b_bytes);
}

// Each format begins as it should, says by what and how it was made, and in which colour space.
static void each_format_records_how_it_was_made(void **state)
{
  static const struct {
    const char *name, *magic, *color_space;
  } formats[] = {
      {"a.png", "\x89PNG", "sRGB"},
      {"a.jpg", "\xff\xd8\xff", "Exif"},
      {"a.exr", "\x76\x2f\x31\x01", "chromaticities"},
      {"a.hdr", "#?RADIANCE\n", "PRIMARIES=0.64 0.33 0.30 0.60 0.15 0.06 0.3127 0.3290\n"},
  };
  for (size_t i = 0; i < sizeof formats / sizeof *formats; i++) {
    const char *path = cli_path("%s", formats[i].name);
    CLI_EXPECT(0, "", "render", cli_scene(), "-o", path, "-s", SIZE, "--camera", "front", "--seed", "3");
    size_t size = 0;
    char *bytes = cli_load(path, &size);
    assert_non_null(bytes);
    assert_memory_equal(bytes, formats[i].magic, strlen(formats[i].magic));
    free(bytes);
    assert_holds(path, formats[i].color_space);
    assert_holds(path, "Frugal 0.");
    assert_holds(path,
                 "frugal render scene.glb --size 64x48 --samples 1 --camera front --background environment "
                 "--exposure 0 --tone-map none --lighting pbr --primary auto --shadows rays --reflections rays "
                 "--environment-light none --max-depth 8 --max-roughness 0 --seed 3; on ");
  }
}

static void standard_output_gets_the_same_bytes_as_a_file(void **state)
{
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", cli_path("file.png"), "-s", SIZE);
  CliRun run = cli_run("render", cli_scene(), "-o", "-", "--format", "png", "-s", SIZE, "--threads", "1", NULL);
  cli_expect(&run, 0, "", __FILE__, __LINE__);
  cli_save(cli_path("piped.png"), run.out, run.out_size);
  cli_free(&run);
  assert_same_bytes(cli_path("file.png"), cli_path("piped.png"));
}

// Reads pictures back; stopped before the next run, which takes other processes for left-overs.
static ImageHelper *reader;

static void reader_start(void)
{
  Log log = {0};
  assert_int_equal(image_helper_start(&reader, 1 << 20, &log), STATUS_OK);
}

static void reader_stop(void)
{
  image_helper_stop(reader);
  reader = NULL;
}

// The picture's RGBA of an .exr, or its channel of that name.
static ImageLayer read_exr(const char *path, const char *channel)
{
  ImageLayer layer = {0};
  Log log = {0};
  if (image_read_layer(&layer, reader, path, channel, &log) != STATUS_OK) fail_msg("%s", log.error);
  assert_int_equal(layer.channels, channel ? 1 : 4);
  return layer;
}

static const float *pixel_of(const ImageLayer *layer, uint32_t x, uint32_t y)
{
  return (const float *)layer->values + (size_t)(y * layer->width + x) * layer->channels;
}

static void a_crop_has_the_pixels_of_the_whole_picture(void **state)
{
  const char *whole_path = cli_path("whole.exr"), *crop_path = cli_path("crop.exr");
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", whole_path, "-s", SIZE, "-n", "4", "--aov", "depth", "--environment",
             "sky", "--methods", "exact");
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", crop_path, "-s", SIZE, "-n", "4", "--aov", "depth", "--environment",
             "sky", "--methods", "exact", "--crop", "13,9,30,21");
  static const char *const channels[] = {NULL, "depth.Z"};
  reader_start();
  for (size_t c = 0; c < 2; c++) {
    ImageLayer whole = read_exr(cli_path("whole.exr"), channels[c]), crop = read_exr(cli_path("crop.exr"), channels[c]);
    assert_int_equal(crop.width, 30);
    assert_int_equal(crop.height, 21);
    for (uint32_t y = 0; y < crop.height; y++)
      assert_memory_equal(pixel_of(&crop, 0, y), pixel_of(&whole, 13, y + 9), 30 * crop.channels * sizeof(float));
    image_layer_free(&whole);
    image_layer_free(&crop);
  }
  reader_stop();
}

// The corner shows the background alone, the middle the square; a colour is as given whatever the exposure.
static void the_background_is_as_asked(void **state)
{
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", cli_path("clear.exr"), "-s", SIZE, "-n", "4", "--background",
             "transparent", "--environment", "#ffffff", "--exposure", "1");
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", cli_path("color.exr"), "-s", SIZE, "-n", "4", "--background",
             "#ff8000", "--environment", "#ffffff", "--exposure", "1");
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", cli_path("white.exr"), "-s", SIZE, "-n", "4", "--environment",
             "#ffffff", "--exposure", "1");
  reader_start();
  ImageLayer clear = read_exr(cli_path("clear.exr"), NULL), color = read_exr(cli_path("color.exr"), NULL),
             white = read_exr(cli_path("white.exr"), NULL);
  reader_stop();
  const float *corner = pixel_of(&clear, 0, 0), *middle = pixel_of(&clear, WIDTH / 2, HEIGHT / 2);
  assert_true(corner[0] == 0 && corner[3] == 0 && middle[3] == 1);
  assert_true(middle[0] == pixel_of(&white, WIDTH / 2, HEIGHT / 2)[0]);
  corner = pixel_of(&color, 0, 0);
  assert_true(corner[0] == 1 && corner[2] == 0 && corner[3] == 1);
  assert_true(fabs((double)corner[1] - 0.215861) < 1e-6);  // 128 in sRGB
  corner = pixel_of(&white, 0, 0);
  assert_true(corner[0] == 2 && corner[3] == 1);
  uint32_t edges = 0;
  for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
    double red = (double)pixel_of(&clear, i, 0)[0], alpha = (double)pixel_of(&clear, i, 0)[3];
    edges += alpha > 0 && alpha < 1;
    assert_true(fabs((double)pixel_of(&color, i, 0)[0] - (red + 1 - alpha)) < 1e-6);
    assert_true(fabs((double)pixel_of(&white, i, 0)[0] - (red + 2 * (1 - alpha))) < 1e-5);
  }
  assert_true(edges > 20);  // the square has an outline of some hundred pixels
  image_layer_free(&clear);
  image_layer_free(&color);
  image_layer_free(&white);
}

static double linear_of(double srgb) { return srgb <= 0.04045 ? srgb / 12.92 : pow((srgb + 0.055) / 1.055, 2.4); }

static double srgb_of(double linear)
{
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static Image read_png(const char *path)
{
  Image image = {0};
  Log log = {0};
  assert_int_equal(image_read(&image, reader, IMAGE_TEXTURE, path, NULL, 0, &log), STATUS_OK);
  return image;
}

// What is laid over a background by hand, straight alpha in linear light, is what --background gives within the
// rounding of three 8-bit numbers; with a tone curve and an exposure, which the background does not feel.
static void display_pictures_are_laid_over_their_background(void **state)
{
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", cli_path("clear.png"), "-s", SIZE, "-n", "4", "--exposure", "1",
             "--tone-map", "filmic", "--background", "transparent");
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", cli_path("color.png"), "-s", SIZE, "-n", "4", "--exposure", "1",
             "--tone-map", "filmic", "--background", "#ff8000");
  static const double background[3] = {255, 128, 0};
  reader_start();
  Image clear = read_png(cli_path("clear.png")), color = read_png(cli_path("color.png"));
  reader_stop();
  uint32_t edges = 0;
  int darkest[2] = {255, 255};  // red at the square's edge and within it: straight alpha keeps it at the edge
  for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
    double alpha = clear.texels[4 * i + 3] / 255.0;
    int *least = &darkest[alpha == 1];
    edges += alpha > 0 && alpha < 1;
    if (alpha > 0 && clear.texels[4 * i] < *least) *least = clear.texels[4 * i];
    for (int c = 0; c < 3; c++) {
      double over = linear_of(clear.texels[4 * i + c] / 255.0) * alpha + linear_of(background[c] / 255) * (1 - alpha);
      assert_true(fabs(255 * srgb_of(over) - color.texels[4 * i + c]) < 2);
    }
  }
  assert_true(edges > 20);
  assert_true(abs(darkest[0] - darkest[1]) < 8);
  image_free(&clear);
  image_free(&color);
}

// The square's log-average luminance, from the picture's own linear values.
static double exposure_of(const char *path)
{
  reader_start();
  ImageLayer layer = read_exr(path, NULL);
  reader_stop();
  double sum = 0;
  uint32_t count = 0;
  for (uint32_t i = 0; i < layer.width * layer.height; i++) {
    const float *rgb = pixel_of(&layer, i, 0);
    double luminance = 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
    if (luminance == 0) continue;  // the black environment
    sum += log2(luminance);
    count++;
  }
  image_layer_free(&layer);
  assert_true(count > 100);
  return log2(0.18) - sum / count;
}

static void auto_exposure_is_one_that_can_be_given(void **state)
{
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", cli_path("linear.exr"), "-s", SIZE);
  char words[64];
  snprintf(words, sizeof words, "%.2f", exposure_of(cli_path("linear.exr")));
  CLI_EXPECT(0, cli_path("auto.png: --exposure %s, by auto", words) + strlen(cli_folder) + 1, "render", cli_scene(),
             "-o", cli_path("auto.png"), "-s", SIZE, "--exposure", "auto");
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", cli_path("given.png"), "-s", SIZE, "--exposure", words);
  assert_same_bytes(cli_path("auto.png"), cli_path("given.png"));
}

// ... and the exposure to try is that of auto, which needs no such line.
static void black_blown_out_and_empty_pictures_get_a_line(void **state)
{
  char black[96], blown[96];
  snprintf(black, sizeof black, "b.png: comes out black: try --exposure %.2f\n", exposure_of(cli_path("linear.exr")));
  snprintf(blown, sizeof blown, "b.png: comes out blown out: try --exposure %.2f\n",
           exposure_of(cli_path("linear.exr")));
  CLI_EXPECT(0, black, "render", cli_scene(), "-o", cli_path("b.png"), "-s", SIZE, "--exposure", "-12", "-q");
  CLI_EXPECT(0, blown, "render", cli_scene(), "-o", cli_path("b.png"), "-s", SIZE, "--exposure", "9", "-q");
  CLI_EXPECT(0, "b.png: shows no surface: try --camera fit\n", "render", cli_scene(), "-o", cli_path("b.png"), "-s",
             SIZE, "--crop", "0,0,4,4");
  CliRun run = cli_run("render", cli_scene(), "-o", cli_path("b.png"), "-s", SIZE, "--exposure", "auto", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_string_equal(run.err, "");
  cli_free(&run);
}

static void no_clobber_leaves_what_is_there(void **state)
{
  const char *path = cli_path("there.png");
  cli_save(path, "old", 3);
  CLI_EXPECT(5, "there.png: is there already: name another, or leave out --no-clobber", "render", cli_scene(), "-o",
             path, "--no-clobber");
  assert_holds(path, "old");
  assert_int_equal(symlink("nowhere", cli_path("link.png")), 0);
  CLI_EXPECT(5, "link.png: is there already", "render", cli_scene(), "-o", cli_path("link.png"), "--no-clobber");
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", path, "--no-clobber", "--overwrite", "-s", "8x8");
  assert_holds(path, "PNG");
  CLI_EXPECT(2, "scene.glb: is the scene itself: name another output", "render", cli_scene(), "-o", cli_scene(),
             "--format", "png");
}

static void progress_verbose_and_quiet_say_what_they_should(void **state)
{
  CliRun run =
      cli_run("render", cli_scene(), "-o", cli_path("p.png"), "-s", SIZE, NULL);  // compiles kernels, and says so
  cli_free(&run);
  run = cli_run("render", cli_scene(), "-o", cli_path("p.png"), "-s", SIZE, "--progress", NULL);
  assert_int_equal(run.exit_code, 0);
  const char *said = strstr(run.err, "compiling kernels") ? strchr(run.err, '\n') + 1 : run.err;  // by sanitizers, slow
  assert_string_equal(said, "frugal: 100 %\n");
  cli_free(&run);
  run = cli_run("render", cli_scene(), "-o", cli_path("p.png"), "-s", SIZE, "-q", "--environment", "none", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_string_equal(run.err, "");
  cli_free(&run);
  CLI_EXPECT(0, "scene.glb: 2 triangles, 1 objects, 1 lights; shadows by rays, reflections not needed", "render",
             cli_scene(), "-o", cli_path("p.png"), "-s", SIZE, "-v");
}

static void help_and_version_are_results(void **state)
{
  static const char *const words[] = {"--help", "-h", "help", "--version", "-V"};
  for (int i = 0; i < 5; i++) {
    CliRun run = cli_run(words[i], NULL);
    assert_int_equal(run.exit_code, 0);
    assert_string_equal(run.err, "");
    assert_non_null(strstr(run.out, i < 3 ? "Examples:\n  frugal render" : "frugal 0."));
    cli_free(&run);
  }
  static const char *const commands[] = {"render", "info", "devices"};
  for (int i = 0; i < 3; i++) {
    CliRun run = cli_run(commands[i], "--help", NULL);
    assert_int_equal(run.exit_code, 0);
    assert_int_equal(strncmp(run.out, "Examples:\n  frugal ", 19), 0);
    assert_non_null(strstr(run.out, "Exit codes: 0 "));
    cli_free(&run);
  }
  CLI_EXPECT(2, "rendre: no such command: did you mean 'render'?", "rendre");
  int full = open("/dev/full", O_WRONLY);
  cli_setting.stdout_fd = full;
  CLI_EXPECT(5, "standard output: No space left on device", "--help");
  close(full);
}

static void cameras_are_listed_by_index_and_name(void **state)
{
  CliRun run = cli_run("render", cli_scene(), "--list-cameras", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_string_equal(run.out,
                      "0\tfront\tperspective, 57.3 degrees high\n1\tflat\torthographic, 3 high\n"
                      "fit\t\ta view of the whole scene\n");
  cli_free(&run);
  CLI_EXPECT(2, "scene.glb: no camera 'fromt': did you mean 'front'?", "render", cli_scene(), "-o", cli_path("c.png"),
             "--camera", "fromt");
  CLI_EXPECT(2, "scene.glb: no camera 2: the scene has 2, numbered from 0", "render", cli_scene(), "-o",
             cli_path("c.png"), "--camera", "2");
}

static void outputs_take_no_more_than_they_should(void **state)
{
  struct stat file;
  mode_t before = umask(027);
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", cli_path("mode.png"), "-s", "8x8");
  umask(before);
  assert_int_equal(stat(cli_path("mode.png"), &file), 0);
  assert_int_equal(file.st_mode & 07777, 0640);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(help_and_version_are_results),
      cmocka_unit_test(cameras_are_listed_by_index_and_name),
      cmocka_unit_test(each_format_records_how_it_was_made),
      cmocka_unit_test(standard_output_gets_the_same_bytes_as_a_file),
      cmocka_unit_test(a_crop_has_the_pixels_of_the_whole_picture),
      cmocka_unit_test(the_background_is_as_asked),
      cmocka_unit_test(display_pictures_are_laid_over_their_background),
      cmocka_unit_test(auto_exposure_is_one_that_can_be_given),
      cmocka_unit_test(black_blown_out_and_empty_pictures_get_a_line),
      cmocka_unit_test(no_clobber_leaves_what_is_there),
      cmocka_unit_test(progress_verbose_and_quiet_say_what_they_should),
      cmocka_unit_test(outputs_take_no_more_than_they_should),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
