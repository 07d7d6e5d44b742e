// Separable filters over tiles of planes, a row of FILTER_WIDTH pixels at a time.
#pragma once

#include <stddef.h>

#include "report/loop_math.h"

enum { FILTER_WIDTH = 128, FILTER_MAX_RADIUS = 60 };

// One side of a symmetric or antisymmetric filter; a zero follows the weights.
typedef struct Filter {
  int radius;
  float weights[FILTER_MAX_RADIUS + 2];
} Filter;

// Index of the pixel that stands for `i`, which may lie outside: the border goes on.
static inline size_t filter_clamp(int64_t i, uint32_t count)
{
  return i < 0 ? 0 : (size_t)(i < count ? i : (int64_t)count - 1);
}

// out[x] = sum over k of weights[|k|] in[x + k step], for FILTER_WIDTH pixels; with sign -1 the weights of negative k
// are negated. `in` has values up to radius + 1 steps to either side. To be called from a function with LOOP_CLONES.
LOOP_INLINE void filter_row(float *restrict out, const float *restrict in, ptrdiff_t step, const Filter *filter,
                            float sign)
{
  for (int x = 0; x < FILTER_WIDTH; x++) out[x] = filter->weights[0] * in[x];
  for (int k = 1; k <= filter->radius; k += 2) {
    const float *before = in - k * step, *after = in + k * step;
    float near = filter->weights[k], far = filter->weights[k + 1];
    for (int x = 0; x < FILTER_WIDTH; x++)
      out[x] += near * (after[x] + sign * before[x]) + far * (after[x + step] + sign * before[x - step]);
  }
}

// Two filters of one row at once, which reads it half as often.
LOOP_INLINE void filter_row_pair(float *restrict out_0, float *restrict out_1, const float *restrict in, ptrdiff_t step,
                                 const Filter *filter_0, const Filter *filter_1, float sign_0, float sign_1)
{
  const float *w0 = filter_0->weights, *w1 = filter_1->weights;
  int radius = filter_0->radius > filter_1->radius ? filter_0->radius : filter_1->radius;
  for (int x = 0; x < FILTER_WIDTH; x++) {
    out_0[x] = w0[0] * in[x];
    out_1[x] = w1[0] * in[x];
  }
  for (int k = 1; k <= radius; k += 2) {
    const float *before = in - k * step, *after = in + k * step;
    float near_0 = w0[k], far_0 = w0[k + 1], near_1 = w1[k], far_1 = w1[k + 1];
    for (int x = 0; x < FILTER_WIDTH; x++) {
      float a = before[x], b = after[x], c = before[x - step], d = after[x + step];
      out_0[x] += near_0 * (b + sign_0 * a) + far_0 * (d + sign_0 * c);
      out_1[x] += near_1 * (b + sign_1 * a) + far_1 * (d + sign_1 * c);
    }
  }
}
