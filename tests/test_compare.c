// The numbers of a comparison are what their definitions say, and what cannot be compared is an error.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/parallel.h"
#include "report/image_compare.h"
#include "report/image_metric.h"
#include "support/compare_pictures.h"

static ImageError compare(const Image *a, const Image *b, const ImageCompareOptions *options)
{
  Log log = {0};
  ImageError error;
  if (image_compare(&error, a, b, options, &log)) fail_msg("%s", log.error);
  return error;
}

static void assert_refused(const Image *a, const Image *b, const ImageCompareOptions *options, const char *message)
{
  Log log = {0};
  ImageError error;
  assert_int_equal(image_compare(&error, a, b, options, &log), STATUS_BAD_IMAGE);
  if (!strstr(log.error, message)) fail_msg("'%s' without '%s'", log.error, message);
}

static double srgb_encode(double v)
{
  v = fmin(fmax(v, 0), 1);
  return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
}

static double srgb_decode(double v) { return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4); }

static void assert_close(const char *what, double got, double expected, double tolerance)
{
  if (!(fabs(got - expected) <= tolerance)) fail_msg("%s: %.9g, not %.9g", what, got, expected);
}

static int ascending(const void *a, const void *b)
{
  return (*(double *)a > *(double *)b) - (*(double *)a < *(double *)b);
}

// The definitions once more, in double and pixel after pixel.
static ImageError reference_error(const Image *a, const Image *b, double threshold)
{
  size_t count = (size_t)a->width * a->height;
  double *linear = calloc(count, sizeof(double)), *displayed = calloc(count, sizeof(double));
  double square = 0, relative = 0, square_displayed = 0;
  ImageError error = {.pixels = count};
  for (size_t i = 0; i < count; i++) {
    for (size_t c = 0; c < 4; c++) {
      double x = a->pixels[4 * i + c], y = b->pixels[4 * i + c];
      double shown = c < 3 ? srgb_encode(y) - srgb_encode(x) : fmin(fmax(y, 0), 1) - fmin(fmax(x, 0), 1);
      linear[i] = fmax(linear[i], fabs(y - x));
      displayed[i] = fmax(displayed[i], fabs(shown));
      if (c == 3) continue;
      square += (y - x) * (y - x);
      relative += (y - x) * (y - x) / (x * x + 0.01);
      square_displayed += shown * shown;
    }
    error.over += displayed[i] > threshold;
  }
  qsort(linear, count, sizeof(double), ascending);
  qsort(displayed, count, sizeof(double), ascending);
  size_t rank = (size_t)ceil(0.99 * (double)count) - 1;
  error.max = linear[count - 1];
  error.p99 = linear[rank];
  error.max_displayed = displayed[count - 1];
  error.p99_displayed = displayed[rank];
  error.rmse = sqrt(square / (3.0 * (double)count));
  error.relative_mse = relative / (3.0 * (double)count);
  error.psnr = -10 * log10(square_displayed / (3.0 * (double)count));
  free(linear);
  free(displayed);
  return error;
}

// The displayed values are computed in single precision, to a few 1e-7.
static void numbers_follow_their_definitions(void **state)
{
  const double tolerance = 1e-6;
  for (int i = 0; i < PICTURE_PAIR_COUNT; i++) {
    PicturePair pair = picture_pair_make(i);
    for (size_t p = 0; p < (size_t)pair.a.width * pair.a.height; p += 3) pair.b.pixels[4 * p + 3] = 0.96f;
    ImageError expected = reference_error(&pair.a, &pair.b, 0.05), got;
    got = compare(&pair.a, &pair.b, &(ImageCompareOptions){.threshold = 0.05});
    assert_int_equal(got.pixels, expected.pixels);
    assert_true(got.over <= expected.over &&
                got.over >= reference_error(&pair.a, &pair.b, 0.05 + 2 * IMAGE_ROUNDING).over);
    assert_close("over", got.over_share, (double)got.over / (double)got.pixels, 1e-12);
    assert_close("rmse", got.rmse, expected.rmse, tolerance * expected.rmse);
    assert_close("relative mse", got.relative_mse, expected.relative_mse, tolerance * expected.relative_mse);
    assert_close("max", got.max, expected.max, tolerance * expected.max);
    assert_close("p99", got.p99, expected.p99, tolerance * expected.p99);
    assert_close("max displayed", got.max_displayed, expected.max_displayed, tolerance);
    assert_close("p99 displayed", got.p99_displayed, expected.p99_displayed, tolerance);
    assert_close("psnr", got.psnr, expected.psnr, 1e-4);
    assert_true(isnan(got.flip) && isnan(got.hdr_flip) && isnan(got.ssim));
    picture_pair_free(&pair);
  }
}

static void equal_pictures_have_no_error(void **state)
{
  PicturePair pair = picture_pair_make(0);
  ImageError error = compare(&pair.a, &pair.a, &(ImageCompareOptions){.ssim = true, .flip = true, .hdr_flip = true});
  assert_true(error.over == 0 && error.rmse == 0 && error.relative_mse == 0 && error.max == 0 && error.p99 == 0);
  assert_true(error.psnr == INFINITY && error.ssim == 1 && error.flip == 0 && error.hdr_flip == 0);
  picture_pair_free(&pair);
}

// Every step of 8 bits: a difference of 2/255 is not over 2/255, one of 3/255 is.
static void two_steps_of_8_bits_are_not_over_and_three_are(void **state)
{
  for (uint32_t step = 2; step <= 3; step++) {
    Image a = picture_make(256, 1), b = picture_make(256, 1);
    for (uint32_t x = 0; x + step < 256; x++) {
      picture_set(&a, x, 0, 0, srgb_decode(x / 255.0), 0);
      picture_set(&b, x, 0, 0, srgb_decode((x + step) / 255.0), 0);
    }
    ImageError error = compare(&a, &b, NULL);
    assert_int_equal(error.over, step == 2 ? 0 : 253);
    image_free(&a);
    image_free(&b);
  }
}

static void one_wrong_pixel_in_a_large_picture_is_found(void **state)
{
  Image a = picture_make(777, 333), b = picture_make(777, 333);
  picture_set(&b, 701, 222, 0, 0, 0.5);
  ImageError error = compare(&a, &b, &(ImageCompareOptions){.flip = true, .ssim = true});
  assert_int_equal(error.over, 1);
  assert_int_equal(error.worst_x, 701);
  assert_int_equal(error.worst_y, 222);
  assert_true(error.max == 0.5 && error.p99 == 0 && error.flip > 0 && error.ssim < 1);
  image_free(&a);
  image_free(&b);
}

static void alpha_counts_as_a_channel(void **state)
{
  Image a = picture_make(20, 20), b = picture_make(20, 20);
  a.pixels[4 * 5 + 3] = 0.5f;
  ImageError error = compare(&a, &b, NULL);
  assert_true(error.max == 0.5 && error.max_displayed == 0.5 && error.over == 1 && error.worst_x == 5);
  image_free(&a);
  image_free(&b);
}

static void mask_leaves_out_what_it_leaves_out(void **state)
{
  PicturePair pair = picture_pair_make(0);
  uint32_t width = pair.a.width, height = pair.a.height;
  uint8_t *mask = calloc((size_t)width * height, 1);
  // The mask is a rectangle, and so the numbers are those of the rectangle as a picture.
  Image a = picture_make(40, 30), b = picture_make(40, 30);
  for (uint32_t y = 0; y < 30; y++) {
    size_t from = (size_t)(y + 20) * width + 50;
    memset(mask + from, 1, 40);
    memcpy(a.pixels + 4 * 40 * y, pair.a.pixels + 4 * from, 40 * 4 * sizeof(float));
    memcpy(b.pixels + 4 * 40 * y, pair.b.pixels + 4 * from, 40 * 4 * sizeof(float));
  }
  ImageError masked = compare(&pair.a, &pair.b, &(ImageCompareOptions){.mask = mask}), cut = compare(&a, &b, NULL);
  assert_int_equal(masked.pixels, 40 * 30);
  assert_int_equal(masked.over, cut.over);
  assert_close("rmse", masked.rmse, cut.rmse, 1e-12);
  assert_close("relative mse", masked.relative_mse, cut.relative_mse, 1e-12);
  assert_close("psnr", masked.psnr, cut.psnr, 1e-9);
  assert_true(masked.max == cut.max && masked.p99 == cut.p99 && masked.p99_displayed == cut.p99_displayed);
  assert_int_equal(masked.worst_x, cut.worst_x + 50);
  assert_int_equal(masked.worst_y, cut.worst_y + 20);
  memset(mask, 0, (size_t)width * height);
  assert_refused(&pair.a, &pair.b, &(ImageCompareOptions){.mask = mask}, "the mask leaves no pixel");
  free(mask);
  image_free(&a);
  image_free(&b);
  picture_pair_free(&pair);
}

// Also under a mask, and where both pictures have it at the same place: nothing is known of such a pixel.
static void values_that_are_not_finite_are_never_a_pass(void **state)
{
  const float values[] = {NAN, INFINITY, -INFINITY};
  uint8_t mask[200] = {1};
  for (int v = 0; v < 3; v++)
    for (int channel = 0; channel < 4; channel++) {
      Image a = picture_make(20, 10), b = picture_make(20, 10);
      b.pixels[4 * (20 * 3 + 7) + channel] = values[v];
      assert_refused(&a, &b, NULL, "second picture: 1 pixels are not finite, the first at 7,3");
      assert_refused(&b, &a, NULL, "first picture: 1 pixels are not finite, the first at 7,3");
      assert_refused(&b, &b, NULL, "not finite");
      assert_refused(&a, &b, &(ImageCompareOptions){.mask = mask, .names = {"x.exr", "y.exr"}}, "y.exr: 1 pixels");
      image_free(&a);
      image_free(&b);
    }
}

static void other_sizes_are_an_error(void **state)
{
  Image a = picture_make(20, 10), b = picture_make(10, 20), c = picture_make(20, 11);
  assert_refused(&a, &b, NULL, "second picture: 10 x 20 pixels, and first picture has 20 x 10");
  assert_refused(&a, &c, NULL, "20 x 11");
  image_free(&a);
  image_free(&b);
  image_free(&c);
}

static void huge_and_negative_radiance_has_finite_numbers(void **state)
{
  Image a = picture_make(64, 64), b = picture_make(64, 64);
  picture_set(&a, 3, 3, 1e30, -1e30, 1e-30);
  picture_set(&b, 3, 3, -1e30, 1e30, 1e-40);
  ImageError error = compare(&a, &b, &(ImageCompareOptions){.flip = true, .hdr_flip = true, .ssim = true});
  assert_true(isfinite(error.rmse) && error.rmse > 1e28 && isfinite(error.relative_mse));
  assert_true(error.flip > 0 && error.flip <= 1 && error.hdr_flip > 0 && error.hdr_flip <= 1);
  image_free(&a);
  image_free(&b);
}

static double luma(const float *pixel)
{
  return 0.299 * srgb_encode(pixel[0]) + 0.587 * srgb_encode(pixel[1]) + 0.114 * srgb_encode(pixel[2]);
}

// Wang et al. 2004, window by window.
static double reference_ssim(const Image *a, const Image *b)
{
  double sum = 0;
  uint64_t windows = 0;
  for (uint32_t y = 0; y + 11 <= a->height; y++)
    for (uint32_t x = 0; x + 11 <= a->width; x++) {
      double weights = 0, ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
      for (uint32_t j = 0; j < 11; j++)
        for (uint32_t i = 0; i < 11; i++) {
          double dx = i - 5.0, dy = j - 5.0, w = exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5));
          size_t at = 4 * ((size_t)(y + j) * a->width + x + i);
          double va = luma(a->pixels + at), vb = luma(b->pixels + at);
          weights += w, ma += w * va, mb += w * vb, aa += w * va * va, bb += w * vb * vb, ab += w * va * vb;
        }
      ma /= weights, mb /= weights;
      double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
      double above = (2 * ma * mb + c1) * (2 * (ab / weights - ma * mb) + c2);
      sum += above / ((ma * ma + mb * mb + c1) * (aa / weights - ma * ma + bb / weights - mb * mb + c2));
      windows++;
    }
  return windows ? sum / (double)windows : NAN;
}

// Single precision against 0.03^2, the smaller constant of the formula: about 1e-4 of a flat window in the worst case,
// which errors of either sign average out.
static void ssim_follows_its_definition(void **state)
{
  const ImageCompareOptions options = {.ssim = true};
  for (int i = 0; i < PICTURE_PAIR_COUNT; i++) {
    PicturePair pair = picture_pair_make(i);
    ImageError error = compare(&pair.a, &pair.b, &options);
    if (pair.a.width < 11 || pair.a.height < 11)
      assert_true(isnan(error.ssim));
    else
      assert_close(pair.name, error.ssim, reference_ssim(&pair.a, &pair.b), 1e-5);
    picture_pair_free(&pair);
  }
}

// From scikit-image 0.26: structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False,
// data_range=1) of the same lumas.
static void another_implementation_of_ssim_agrees(void **state)
{
  static const double expected[] = {0.8122592, 0.9922389, 0.0034082, 0.9969523,
                                    0.6682667, 0.9392556, 0.9308233, 0.9176488};
  for (int i = 0; i < 8; i++) {
    PicturePair pair = picture_pair_make(i);
    assert_close(pair.name, compare(&pair.a, &pair.b, &(ImageCompareOptions){.ssim = true}).ssim, expected[i], 1e-5);
    picture_pair_free(&pair);
  }
}

static void threads_do_not_change_a_bit(void **state)
{
  PicturePair pair = picture_pair_make(6);
  const ImageCompareOptions options = {.ssim = true, .flip = true, .hdr_flip = true};
  ImageError errors[2];
  for (int i = 0; i < 2; i++) {
    parallel_set_threads(i ? 5 : 1);
    memset(&errors[i], 0, sizeof errors[i]);
    errors[i] = compare(&pair.a, &pair.b, &options);
  }
  parallel_set_threads(0);
  for (int m = 0; m < IMAGE_METRIC_COUNT; m++)
    assert_true(image_metric_value(m, &errors[0]) == image_metric_value(m, &errors[1]));
  picture_pair_free(&pair);
}

static void a_number_that_is_none_keeps_no_limit(void **state)
{
  ImageError error = {.rmse = 0.5, .psnr = INFINITY, .ssim = NAN, .flip = NAN};
  assert_true(image_metric_within(image_metric_find("rmse", 4), &error, 0.5));
  assert_false(image_metric_within(image_metric_find("rmse", 4), &error, 0.49));
  assert_true(image_metric_within(image_metric_find("psnr", 4), &error, 90));
  assert_false(image_metric_within(image_metric_find("ssim", 4), &error, 0));
  assert_false(image_metric_within(image_metric_find("flip", 4), &error, 1));
  assert_int_equal(image_metric_find("rms", 3), -1);
  assert_int_equal(image_metric_find("rmse=1", 4), image_metric_find("rmse", 4));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(numbers_follow_their_definitions),
      cmocka_unit_test(equal_pictures_have_no_error),
      cmocka_unit_test(two_steps_of_8_bits_are_not_over_and_three_are),
      cmocka_unit_test(one_wrong_pixel_in_a_large_picture_is_found),
      cmocka_unit_test(alpha_counts_as_a_channel),
      cmocka_unit_test(mask_leaves_out_what_it_leaves_out),
      cmocka_unit_test(values_that_are_not_finite_are_never_a_pass),
      cmocka_unit_test(other_sizes_are_an_error),
      cmocka_unit_test(huge_and_negative_radiance_has_finite_numbers),
      cmocka_unit_test(ssim_follows_its_definition),
      cmocka_unit_test(another_implementation_of_ssim_agrees),
      cmocka_unit_test(threads_do_not_change_a_bit),
      cmocka_unit_test(a_number_that_is_none_keeps_no_limit),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
