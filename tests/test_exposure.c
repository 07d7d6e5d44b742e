// Exposure by itself, and pictures in which nothing can be made out.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "render/exposure.h"

enum { PIXELS = 1000 };

static float sums[PIXELS][4], picture[PIXELS][4];

// All pixels the same: sums of `samples` samples of a grey of that luminance.
static void sums_fill(float luminance, float coverage, uint32_t samples)
{
  for (int i = 0; i < PIXELS; i++) {
    for (int c = 0; c < 3; c++) sums[i][c] = luminance * (float)samples;
    sums[i][3] = coverage * (float)samples;
  }
}

static void picture_fill(int from, int to, float value)
{
  for (int i = from; i < to; i++)
    for (int c = 0; c < 3; c++) picture[i][c] = value;
}

static float auto_ev(uint32_t samples)
{
  LightMeter meter = light_meter_read(sums[0], PIXELS, samples);
  return light_meter_exposure_ev(&meter);
}

// 0.18 at exposure 0 stays; each factor of two is one EV, whatever the samples.
static void a_grey_surface_is_brought_to_middle_grey(void **state)
{
  sums_fill(0.18f, 1, 1);
  assert_true(auto_ev(1) == 0);
  sums_fill(0.18f / 8, 1, 16);
  assert_true(auto_ev(16) == 3);
  sums_fill(0.18f * 1024, 1, 4);
  assert_true(auto_ev(4) == -10);
  sums_fill(0.1f, 1, 1);  // log2(1.8) = 0.848
  assert_true(auto_ev(1) == 0.85f);
}

// Half at 0.09, half at 0.36: the mean of the logarithms is that of 0.18; the arithmetic mean is 0.225.
static void the_mean_is_one_of_logarithms(void **state)
{
  sums_fill(0.09f, 1, 1);
  for (int i = 0; i < PIXELS; i += 2)
    for (int c = 0; c < 3; c++) sums[i][c] = 0.36f;
  assert_true(auto_ev(1) == 0);
}

// Green counts 0.7152 of white (Rec. 709): a green of 0.18 / 0.7152 is a middle grey.
static void colours_count_by_their_luminance(void **state)
{
  sums_fill(0, 1, 1);
  for (int i = 0; i < PIXELS; i++) sums[i][1] = 0.18f / 0.7152f;
  assert_true(auto_ev(1) == 0);
}

static void background_and_black_do_not_count(void **state)
{
  sums_fill(1000, 0.25f, 4);  // a bright sky behind edges of a quarter of a pixel
  for (int i = 0; i < 200; i++)
    for (int c = 0; c < 4; c++) sums[i][c] = c < 3 ? 0.18f * 4 : 4;
  for (int i = 200; i < 300; i++)
    for (int c = 0; c < 4; c++) sums[i][c] = c < 3 ? 0 : 4;
  sums[300][0] = sums[300][1] = sums[300][2] = NAN, sums[300][3] = 4;
  LightMeter meter = light_meter_read(sums[0], PIXELS, 4);
  assert_int_equal(meter.surface_pixels, 301);
  assert_int_equal(meter.lit_pixels, 200);
  assert_true(light_meter_exposure_ev(&meter) == 0);
}

static void without_light_the_exposure_is_0(void **state)
{
  sums_fill(0, 1, 1);
  assert_true(auto_ev(1) == 0);
  sums_fill(1, 0, 1);
  assert_true(auto_ev(1) == 0);
  sums_fill(1e-30f, 1, 1);  // 97 stops under middle grey
  assert_true(auto_ev(1) == 64);
}

// The bounds of picture_judge, from either side.
static void black_and_blown_out_pictures_are_told(void **state)
{
  sums_fill(1, 1, 1);
  picture_fill(0, PIXELS, 8.4f / 255);
  assert_int_equal(picture_judge(picture[0], sums[0], PIXELS, 1), PICTURE_BLACK);
  picture_fill(0, 9, 0.5f);
  assert_int_equal(picture_judge(picture[0], sums[0], PIXELS, 1), PICTURE_BLACK);
  picture_fill(0, 10, 0.5f);
  assert_int_equal(picture_judge(picture[0], sums[0], PIXELS, 1), PICTURE_FINE);

  picture_fill(0, PIXELS, 0.5f);
  picture_fill(0, 500, 1);
  assert_int_equal(picture_judge(picture[0], sums[0], PIXELS, 1), PICTURE_FINE);
  picture_fill(500, 501, 1);
  assert_int_equal(picture_judge(picture[0], sums[0], PIXELS, 1), PICTURE_BLOWN);
  for (int i = 0; i < PIXELS; i++) picture[i][2] = 0.99f;  // a bright yellow is no white
  assert_int_equal(picture_judge(picture[0], sums[0], PIXELS, 1), PICTURE_FINE);
}

static void a_picture_without_surfaces_is_empty(void **state)
{
  sums_fill(1, 0.24f, 4);
  picture_fill(0, PIXELS, 0.5f);
  assert_int_equal(picture_judge(picture[0], sums[0], PIXELS, 4), PICTURE_EMPTY);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_grey_surface_is_brought_to_middle_grey),
      cmocka_unit_test(the_mean_is_one_of_logarithms),
      cmocka_unit_test(colours_count_by_their_luminance),
      cmocka_unit_test(background_and_black_do_not_count),
      cmocka_unit_test(without_light_the_exposure_is_0),
      cmocka_unit_test(black_and_blown_out_pictures_are_told),
      cmocka_unit_test(a_picture_without_surfaces_is_empty),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
