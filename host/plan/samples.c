#include "plan/samples.h"

// In sixteenths of a pixel from its centre, as in the Direct3D 11.3 functional specification, section 19.2.4.
static const signed char pattern_2[][2] = {{4, 4}, {-4, -4}};
static const signed char pattern_4[][2] = {{-2, -6}, {6, -2}, {-6, 2}, {2, 6}};
static const signed char pattern_8[][2] = {{1, -3}, {-1, 3}, {5, 1}, {-3, -5}, {-5, 5}, {-7, -1}, {3, 7}, {7, -7}};
static const signed char pattern_16[][2] = {{1, 1},  {-1, -3}, {-3, 2},  {4, -1}, {-5, -2}, {2, 5},  {5, 3}, {3, -5},
                                            {-2, 6}, {0, -7},  {-4, -6}, {-6, 4}, {-8, 0},  {7, -4}, {6, 7}, {-7, -8}};

static double radical_inverse(uint32_t index, uint32_t base)
{
  double value = 0, digit = 1.0 / base;
  for (; index; index /= base, digit /= base) value += digit * (index % base);
  return value;
}

void sample_pattern(float (*out)[2], uint32_t count)
{
  const signed char(*standard)[2] = count == 2    ? pattern_2
                                    : count == 4  ? pattern_4
                                    : count == 8  ? pattern_8
                                    : count == 16 ? pattern_16
                                                  : 0;
  for (uint32_t i = 0; i < count; i++) {
    if (count == 1) {
      out[i][0] = out[i][1] = 0.5f;
    } else if (standard) {
      out[i][0] = 0.5f + (float)standard[i][0] / 16;
      out[i][1] = 0.5f + (float)standard[i][1] / 16;
    } else {
      out[i][0] = (float)radical_inverse(i + 1, 2);
      out[i][1] = (float)radical_inverse(i + 1, 3);
    }
  }
}
