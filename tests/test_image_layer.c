// Channels come out of image files as they are in them: ids to the last bit, values that are no radiance, grey as grey.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/image_fixture.h"

static ImageLayer read_layer(const char *path, const char *channel)
{
  ImageLayer layer;
  assert_ok(image_read_layer(&layer, image_helper, path, channel, &image_log));
  return layer;
}

static void write_groups(const char *path, uint32_t width, uint32_t height, const ImageChannels *groups, uint32_t count)
{
  ImageOutput output = {width, height, groups, count, 8, 95, NULL, NULL, 0};
  assert_ok(image_write(image_helper, path, NULL, &output, &image_log));
}

static void a_named_channel_keeps_every_bit(void **state)
{
  enum { WIDTH = 7, HEIGHT = 5, COUNT = WIDTH * HEIGHT };
  float colour[COUNT * 4], depth[COUNT];
  uint32_t ids[COUNT * 2];
  for (int i = 0; i < COUNT * 4; i++) colour[i] = (float)i / 7 - 2;
  for (int i = 0; i < COUNT; i++) depth[i] = i == 3 ? INFINITY : i == 4 ? NAN : (float)-i;
  for (uint32_t i = 0; i < COUNT * 2; i++) ids[i] = i % 5 ? i * 0x9e3779b9u : UINT32_MAX;
  ImageChannels groups[] = {{{"R", "G", "B", "A"}, 4, 4, colour, 0},
                            {{"depth.Z"}, 1, 1, depth, 0},
                            {{"object.id", "primitive.id"}, 2, 2, ids, 1}};
  write_groups(path_of("a.exr"), WIDTH, HEIGHT, groups, 3);

  ImageLayer layer = read_layer(path_of("a.exr"), "primitive.id");
  assert_int_equal(layer.width, WIDTH);
  assert_int_equal(layer.height, HEIGHT);
  assert_int_equal(layer.channels, 1);
  assert_int_equal(layer.element, IMAGE_UINT32);
  for (int i = 0; i < COUNT; i++) assert_int_equal(((uint32_t *)layer.values)[i], ids[2 * i + 1]);
  image_layer_free(&layer);

  layer = read_layer(path_of("a.exr"), "depth.Z");
  assert_int_equal(layer.element, IMAGE_FLOAT);
  assert_memory_equal(layer.values, depth, sizeof depth);
  image_layer_free(&layer);

  layer = read_layer(path_of("a.exr"), NULL);
  assert_int_equal(layer.channels, 4);
  assert_false(layer.is_display);
  assert_memory_equal(layer.values, colour, sizeof colour);  // negative ones too
  image_layer_free(&layer);
  assert_string_equal(image_warnings, "");
}

static void a_picture_keeps_its_channels_and_its_bits(void **state)
{
  static const struct {
    const char *name;
    uint32_t channels, bit_depth, expected_channels;
    ImageElement element;
    bool is_display;
  } cases[] = {
      {"grey.png", 1, 8, 1, IMAGE_UINT8, true},  {"grey_alpha.png", 2, 8, 2, IMAGE_UINT8, true},
      {"rgb.png", 3, 16, 3, IMAGE_UINT16, true}, {"rgba.png", 4, 16, 4, IMAGE_UINT16, true},
      {"grey.jpg", 1, 8, 1, IMAGE_UINT8, true},  {"rgb.jpg", 3, 8, 3, IMAGE_UINT8, true},
      {"rgb.hdr", 3, 0, 3, IMAGE_FLOAT, false},  {"rgb.exr", 3, 0, 3, IMAGE_FLOAT, false},
      {"rgba.exr", 4, 0, 4, IMAGE_FLOAT, false},
  };
  float *data = noise(16 * 8 * 4);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    uint32_t channels = cases[i].channels;
    write_floats(path_of(cases[i].name), 16, 8, channels, data, cases[i].bit_depth);
    ImageLayer layer = read_layer(path_of(cases[i].name), NULL);
    assert_int_equal(layer.channels, cases[i].expected_channels);
    assert_int_equal(layer.element, cases[i].element);
    assert_int_equal(layer.is_display, cases[i].is_display);
    for (uint32_t v = 0; v < 16 * 8 * channels; v++) {
      if (layer.element == IMAGE_UINT16)
        assert_int_equal(((uint16_t *)layer.values)[v], (uint16_t)(data[v] * 65535.0 + 0.5));
      if (layer.element == IMAGE_UINT8 && !strstr(cases[i].name, ".jpg"))
        assert_int_equal(((uint8_t *)layer.values)[v], (uint8_t)(data[v] * 255.0 + 0.5));
    }
    image_layer_free(&layer);
  }
  free(data);
}

static void a_missing_channel_is_told_with_those_that_there_are(void **state)
{
  float depth[4] = {1, 2, 3, 4};
  ImageChannels group = {{"depth.Z"}, 1, 1, depth, 0};
  ImageLayer layer = {0};
  write_groups(path_of("a.exr"), 2, 2, &group, 1);
  assert_fails(image_read_layer(&layer, image_helper, path_of("a.exr"), "object.id", &image_log), STATUS_BAD_IMAGE,
               "a.exr: no channel object.id: it has depth.Z");
  assert_fails(image_read_layer(&layer, image_helper, path_of("a.exr"), NULL, &image_log), STATUS_BAD_IMAGE,
               "no picture among its channels");
  char name[400];
  memset(name, 'x', sizeof name - 1);
  name[sizeof name - 1] = 0;
  assert_fails(image_read_layer(&layer, image_helper, path_of("a.exr"), name, &image_log), STATUS_BAD_IMAGE,
               "no channel");
  assert_fails(image_read_layer(&layer, image_helper, path_of("none.exr"), NULL, &image_log), STATUS_NOT_FOUND,
               "none.exr");
  file_save(path_of("text.png"), "text", 4);
  assert_fails(image_read_layer(&layer, image_helper, path_of("text.png"), NULL, &image_log), STATUS_BAD_IMAGE,
               "not a PNG");
  assert_null(layer.values);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      IMAGE_TEST(a_named_channel_keeps_every_bit),
      IMAGE_TEST(a_picture_keeps_its_channels_and_its_bits),
      IMAGE_TEST(a_missing_channel_is_told_with_those_that_there_are),
  };
  return cmocka_run_group_tests(tests, image_set_up, image_tear_down);
}
