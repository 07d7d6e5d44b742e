// Image files: what is written comes back, and the shared assets hold the colours they promise.
#include <float.h>
#include <ftw.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/image_fixture.h"

static void png_8_bit_keeps_every_value_and_straight_alpha(void **state)
{
  float data[256 * 4];
  for (int i = 0; i < 256; i++) {
    data[4 * i] = (float)i / 255;
    data[4 * i + 1] = (float)(255 - i) / 255;
    data[4 * i + 2] = 1;
    data[4 * i + 3] = (float)(i / 2) / 255;  // the first two are wholly transparent: their colour must stay
  }
  write_floats(path_of("a.png"), 16, 16, 4, data, 8);
  Image image = read_image(path_of("a.png"), IMAGE_TEXTURE);
  assert_int_equal(image.width, 16);
  assert_int_equal(image.height, 16);
  assert_null(image.pixels);
  for (int i = 0; i < 256; i++) {
    uint8_t expected[4] = {(uint8_t)i, (uint8_t)(255 - i), 255, (uint8_t)(i / 2)};
    assert_memory_equal(image.texels + 4 * i, expected, 4);
  }
  image_free(&image);
}

static void png_quantises_with_rounding_and_clamps(void **state)
{
  float data[9] = {0.49f / 255, 0.51f / 255, 254.51f / 255, -1, 2, NAN, INFINITY, -INFINITY, 127.5f / 255};
  uint8_t expected[12] = {0, 1, 255, 255, 0, 255, 0, 255, 255, 0, 128, 255};
  write_floats(path_of("a.png"), 3, 1, 3, data, 8);
  Image image = read_image(path_of("a.png"), IMAGE_TEXTURE);
  assert_memory_equal(image.texels, expected, 12);
  image_free(&image);
}

static void png_16_bit_rounds_to_texels_and_linearises_as_radiance(void **state)
{
  enum { COUNT = 65536 };
  float *data = malloc(COUNT * sizeof *data);
  for (int i = 0; i < COUNT; i++) data[i] = (float)i / 65535;
  write_floats(path_of("a.png"), 256, 256, 1, data, 16);
  Image texture = read_image(path_of("a.png"), IMAGE_TEXTURE), radiance = read_image(path_of("a.png"), IMAGE_RADIANCE);
  for (int i = 0; i < COUNT; i++) {
    uint8_t rounded = (uint8_t)((i * 255 + 32767) / 65535);
    uint8_t grey[4] = {rounded, rounded, rounded, 255};
    assert_memory_equal(texture.texels + 4 * i, grey, 4);
    double v = i / 65535.0, linear = v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
    for (int c = 0; c < 3; c++) assert_true(fabs(radiance.pixels[4 * i + c] - linear) <= 1e-6);
    assert_true(radiance.pixels[4 * i + 3] == 1);
  }
  image_free(&texture);
  image_free(&radiance);
  free(data);
}

static void grey_with_alpha_expands(void **state)
{
  float data[4] = {1, 0, 51.0f / 255, 102.0f / 255};
  uint8_t expected[8] = {255, 255, 255, 0, 51, 51, 51, 102};
  write_floats(path_of("a.png"), 2, 1, 2, data, 8);
  Image image = read_image(path_of("a.png"), IMAGE_TEXTURE);
  assert_memory_equal(image.texels, expected, 8);
  image_free(&image);
}

static void palette_with_transparency_expands(void **state)
{
  // 4 x 1, 2 bits, palette red, green, blue, white; the first entry's alpha is 0x40.
  static const uint8_t png[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00,
      0x00, 0x04, 0x00, 0x00, 0x00, 0x01, 0x02, 0x03, 0x00, 0x00, 0x00, 0x84, 0x52, 0xe7, 0x5e, 0x00, 0x00, 0x00,
      0x0c, 0x50, 0x4c, 0x54, 0x45, 0xff, 0x00, 0x00, 0x00, 0xff, 0x00, 0x00, 0x00, 0xff, 0xff, 0xff, 0xff, 0xfb,
      0x00, 0x60, 0xf6, 0x00, 0x00, 0x00, 0x01, 0x74, 0x52, 0x4e, 0x53, 0x40, 0x36, 0x3a, 0x99, 0xf6, 0x00, 0x00,
      0x00, 0x0d, 0x49, 0x44, 0x41, 0x54, 0x78, 0x01, 0x01, 0x02, 0x00, 0xfd, 0xff, 0x00, 0x1b, 0x00, 0x1d, 0x00,
      0x1c, 0x1d, 0x49, 0x23, 0xd5, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  static const uint8_t expected[16] = {255, 0, 0, 0x40, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255};
  Image image;
  assert_ok(image_read(&image, image_helper, IMAGE_TEXTURE, "palette", png, sizeof png, &image_log));
  assert_memory_equal(image.texels, expected, sizeof expected);
  image_free(&image);
}

static void jpeg_is_close_and_drops_alpha(void **state)
{
  enum { SIDE = 64 };
  float data[SIDE * SIDE * 4];
  for (int i = 0; i < SIDE * SIDE; i++) {
    data[4 * i] = (float)(i % SIDE) / SIDE;
    data[4 * i + 1] = (float)(i / SIDE) / SIDE;
    data[4 * i + 2] = 0.25f;
    data[4 * i + 3] = 0;
  }
  write_floats(path_of("a.JPEG"), SIDE, SIDE, 4, data, 8);
  Image image = read_image(path_of("a.JPEG"), IMAGE_TEXTURE);
  for (int i = 0; i < SIDE * SIDE * 4; i++) {
    float expected = i % 4 == 3 ? 255 : data[i] * 255;
    assert_true(fabsf((float)image.texels[i] - expected) <= 4);
  }
  image_free(&image);
}

static void hdr_is_within_a_step_of_its_shared_exponent(void **state)
{
  enum { COUNT = 64 * 32 };
  float *data = noise(COUNT * 3);
  for (int i = 0; i < COUNT * 3; i++) data[i] = exp2f(40 * data[i] - 20);
  write_floats(path_of("a.hdr"), 64, 32, 3, data, 0);
  Image image = read_image(path_of("a.hdr"), IMAGE_RADIANCE);
  assert_null(image.texels);
  for (int i = 0; i < COUNT; i++) {
    float largest = fmaxf(fmaxf(data[3 * i], data[3 * i + 1]), data[3 * i + 2]);
    for (int c = 0; c < 3; c++) assert_true(fabsf(image.pixels[4 * i + c] - data[3 * i + c]) <= largest / 128);
    assert_true(image.pixels[4 * i + 3] == 1);
  }
  image_free(&image);
  free(data);

  float odd[9] = {NAN, -1, 1, INFINITY, 1, 0, FLT_MAX, 0, 0};
  write_floats(path_of("a.hdr"), 3, 1, 3, odd, 0);
  image = read_image(path_of("a.hdr"), IMAGE_RADIANCE);
  assert_true(image.pixels[0] == 0 && image.pixels[1] == 0 && image.pixels[2] == 1);
  assert_true(image.pixels[4] > 1e38f && image.pixels[8] > 1e38f);
  assert_string_equal(image_warnings, "");
  image_free(&image);
}

// One channel of an uncompressed scanline EXR: [height][width] 32-bit values, as they are in the file.
static void exr_channel(uint32_t *out, const uint8_t *file, const char *name, uint32_t type, uint32_t width,
                        uint32_t height)
{
  uint32_t row_at = UINT32_MAX, row_bytes = 0;
  const uint8_t *p = file + 8;
  while (*p) {  // attributes: name, type, size, value
    const char *attribute = (const char *)p;
    p += strlen(attribute) + 1;
    p += strlen((const char *)p) + 1;
    uint32_t size;
    memcpy(&size, p, 4);
    p += 4;
    for (const uint8_t *c = p; strcmp(attribute, "channels") == 0 && *c; c += 16, row_bytes += 4 * width) {
      uint32_t channel_type;
      const char *channel = (const char *)c;
      c += strlen(channel) + 1;
      memcpy(&channel_type, c, 4);
      if (strcmp(channel, name) != 0) continue;
      assert_int_equal(channel_type, type);
      row_at = row_bytes;
    }
    if (strcmp(attribute, "compression") == 0) assert_int_equal(*p, 0);
    p += size;
  }
  assert_int_not_equal(row_at, UINT32_MAX);
  for (uint32_t y = 0; y < height; y++) {
    uint64_t offset;
    memcpy(&offset, p + 1 + 8 * y, 8);
    memcpy(out + y * width, file + offset + 8 + row_at, 4 * width);
  }
}

static void exr_keeps_every_bit_of_every_channel(void **state)
{
  enum { WIDTH = 5, HEIGHT = 3, COUNT = WIDTH * HEIGHT, UINT = 0, FLOAT = 2 };
  float colour[COUNT * 4], depth[COUNT * 2];
  uint32_t ids[COUNT * 2], got[COUNT];
  for (int i = 0; i < COUNT * 4; i++) colour[i] = ldexpf((float)(i + 1) / 7, 4 * i - 120);
  for (int i = 0; i < COUNT * 2; i++) depth[i] = i == 4 ? INFINITY : i == 6 ? NAN : i == 8 ? -0.0f : -1.0f / (float)i;
  for (uint32_t i = 0; i < COUNT * 2; i++) ids[i] = i == 2 ? UINT32_MAX : i * 0x9e3779b9u;
  ImageChannels groups[] = {{{"R", "G", "B", "A"}, 4, 4, colour, 0},
                            {{"depth.Z"}, 1, 2, depth, 0},
                            {{"object.id", "primitive.id"}, 2, 2, ids, 1}};
  ImageOutput output = {WIDTH, HEIGHT, groups, 3, 0, 0, "none", NULL, 0};
  assert_ok(image_write(image_helper, path_of("a.exr"), NULL, &output, &image_log));

  static const struct {
    const char *name;
    int type, offset, stride, group;
  } rows[] = {{"R", FLOAT, 0, 4, 0},          {"G", FLOAT, 1, 4, 0},       {"B", FLOAT, 2, 4, 0},
              {"A", FLOAT, 3, 4, 0},          {"depth.Z", FLOAT, 0, 2, 1}, {"object.id", UINT, 0, 2, 2},
              {"primitive.id", UINT, 1, 2, 2}};
  uint8_t *file;
  file_load(path_of("a.exr"), &file);
  for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
    exr_channel(got, file, rows[r].name, (uint32_t)rows[r].type, WIDTH, HEIGHT);
    for (int i = 0; i < COUNT; i++)
      assert_memory_equal(&got[i], (const uint32_t *)groups[rows[r].group].data + i * rows[r].stride + rows[r].offset,
                          4);
  }
  free(file);

  static const char *const lossless[] = {NULL, "zips", "rle", "piz", "none"};
  for (int i = 0; i < 5; i++) {
    output.compression = lossless[i];
    assert_ok(image_write(image_helper, path_of("a.exr"), NULL, &output, &image_log));
    Image image = read_image(path_of("a.exr"), IMAGE_RADIANCE);
    assert_memory_equal(image.pixels, colour, sizeof colour);
    image_free(&image);
  }
}

static void values_that_are_no_radiance_are_told_and_black(void **state)
{
  float data[6 * 4] = {1, 1, NAN, 1, 2, 2, 2, INFINITY, INFINITY, 0, 0, 1, 1, -1, 1, 1, 5, 6, 7, 0.5f, 0, 0, 0, 0};
  float expected[6 * 4] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 5, 6, 7, 0.5f, 0, 0, 0, 0};
  write_floats(path_of("a.exr"), 6, 1, 4, data, 0);
  Image image = read_image(path_of("a.exr"), IMAGE_RADIANCE);
  assert_memory_equal(image.pixels, expected, sizeof expected);
  assert_non_null(strstr(image_warnings, "a.exr: 3 pixels are not finite: they are read as black"));
  assert_non_null(strstr(image_warnings, "a.exr: 1 pixels have negative values"));
  image_free(&image);
}

static void same_picture_same_bytes_and_attributes(void **state)
{
  float *data = noise(32 * 32 * 4);
  ImageChannels group = {{"R", "G", "B", "A"}, 4, 4, data, 0};
  ImageAttribute attributes[] = {{"Software", "Frugal"}, {"frugal:plan", "rays everywhere"}};
  ImageOutput output = {32, 32, &group, 1, 8, 90, NULL, attributes, 2};
  static const char *const names[] = {"a.png", "a.jpg", "a.hdr", "a.exr"};
  uint8_t *bytes[2][4];
  size_t sizes[2][4];
  for (int run = 0; run < 2; run++) {
    for (int i = 0; i < 4; i++) {
      assert_ok(image_write(image_helper, path_of(names[i]), NULL, &output, &image_log));
      sizes[run][i] = file_load(path_of(names[i]), &bytes[run][i]);
    }
    if (run == 0) usleep(1100000);  // a time stamp would differ by now
  }
  for (int i = 0; i < 4; i++) {
    assert_int_equal(sizes[0][i], sizes[1][i]);
    assert_memory_equal(bytes[0][i], bytes[1][i], sizes[0][i]);
    bool is_png_or_exr = i == 0 || i == 3;
    if (is_png_or_exr) {
      assert_non_null(memmem(bytes[0][i], sizes[0][i], "Software", 8));
      assert_non_null(memmem(bytes[0][i], sizes[0][i], "frugal:plan", 11));
      assert_non_null(memmem(bytes[0][i], sizes[0][i], "rays everywhere", 15));
    }
    assert_null(memmem(bytes[0][i], sizes[0][i], "capDate", 7));
    free(bytes[0][i]);
    free(bytes[1][i]);
  }
  free(data);
}

static int textures_read;

static int texture_visit(const char *path, const struct stat *file, int type, struct FTW *position)
{
  const char *format = type == FTW_F ? image_format_of(path) : NULL;
  if (!format || (strcmp(format, "png") != 0 && strcmp(format, "jpg") != 0)) return 0;
  Image image = read_image(path, IMAGE_TEXTURE);
  image_free(&image);
  textures_read++;
  return 0;
}

// Within the 1/128 of the brightest channel that the file's shared exponent leaves.
static void assert_pixel(const Image *image, double u, double v, float red, float green, float blue)
{
  float step = fmaxf(fmaxf(red, green), blue) / 128;
  const float *p = image->pixels + 4 * ((size_t)(v * image->height) * image->width + (size_t)(u * image->width));
  if (fabsf(p[0] - red) > step || fabsf(p[1] - green) > step || fabsf(p[2] - blue) > step)
    fail_msg("(%g, %g): %g %g %g, not %g %g %g", u, v, p[0], p[1], p[2], red, green, blue);
}

static void assets_have_the_colours_they_promise(void **state)
{
  const float dim = 0.05f;  // the channels that a side's colour lacks
  const char *assets = getenv("FRUGAL_ASSETS");
  char path[IMAGE_PATH_BYTES];
  if (!assets) assets = "../shared/assets";
  if (access(assets, R_OK) != 0) {
    fprintf(stderr, "SKIPPED: textures and environments: no assets\n");
    return;
  }
  nftw(assets, texture_visit, 16, FTW_PHYS);
  assert_true(textures_read > 10);

  snprintf(path, sizeof path, "%s/Environments/furnace_64x32.hdr", assets);
  Image image = read_image(path, IMAGE_RADIANCE);
  assert_int_equal(image.width, 64);
  for (uint32_t i = 0; i < 64 * 32 * 4; i++) assert_true(image.pixels[i] == (i % 4 == 3 ? 1 : 0.5f));
  image_free(&image);

  snprintf(path, sizeof path, "%s/Environments/sides_256x128.hdr", assets);
  image = read_image(path, IMAGE_RADIANCE);
  assert_pixel(&image, 0.5, 0.01, 2, 2, 2);
  assert_pixel(&image, 0.5, 0.99, 0.125f, 0.125f, 0.125f);
  assert_pixel(&image, 0.5, 0.5, 1, dim, dim);
  assert_pixel(&image, 0.75, 0.5, dim, 1, dim);
  assert_pixel(&image, 0.25, 0.5, dim, dim, 1);
  assert_pixel(&image, 0.0, 0.5, 1, 1, dim);
  image_free(&image);

  snprintf(path, sizeof path, "%s/Environments/kloppenheim_05_1k.hdr", assets);
  image = read_image(path, IMAGE_RADIANCE);
  float brightest = 0;
  for (uint32_t i = 0; i < image.width * image.height * 4; i++) brightest = fmaxf(brightest, image.pixels[i]);
  assert_true(brightest > 65504 && brightest < 90000);
  image_free(&image);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      IMAGE_TEST(png_8_bit_keeps_every_value_and_straight_alpha),
      IMAGE_TEST(png_quantises_with_rounding_and_clamps),
      IMAGE_TEST(png_16_bit_rounds_to_texels_and_linearises_as_radiance),
      IMAGE_TEST(grey_with_alpha_expands),
      IMAGE_TEST(palette_with_transparency_expands),
      IMAGE_TEST(jpeg_is_close_and_drops_alpha),
      IMAGE_TEST(hdr_is_within_a_step_of_its_shared_exponent),
      IMAGE_TEST(exr_keeps_every_bit_of_every_channel),
      IMAGE_TEST(values_that_are_no_radiance_are_told_and_black),
      IMAGE_TEST(same_picture_same_bytes_and_attributes),
      IMAGE_TEST(assets_have_the_colours_they_promise),
  };
  return cmocka_run_group_tests(tests, image_set_up, image_tear_down);
}
