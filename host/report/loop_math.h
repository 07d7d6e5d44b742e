// Elementary functions of single precision without branches, calls or errno, so that a loop over an array becomes
// vector code. Relative errors are of the order of 1e-7; arguments that are not finite are not for them.
#pragma once

#include <stdint.h>
#include <string.h>

#include "base/loop_clones.h"

#define LOOP_INLINE static inline __attribute__((always_inline))

// A float's bits, and back.
LOOP_INLINE uint32_t loop_bits(float x)
{
  uint32_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}

LOOP_INLINE float loop_from_bits(uint32_t bits)
{
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

// yes ? a : b, with both computed: a compiler may turn the operator into a jump.
LOOP_INLINE float loop_select(int yes, float a, float b)
{
  uint32_t mask = 0u - (uint32_t)yes;
  return loop_from_bits((loop_bits(a) & mask) | (loop_bits(b) & ~mask));
}

// The second where either is NaN.
LOOP_INLINE float loop_min(float a, float b) { return loop_select(a < b, a, b); }
LOOP_INLINE float loop_max(float a, float b) { return loop_select(a > b, a, b); }
LOOP_INLINE float loop_abs(float x) { return loop_from_bits(loop_bits(x) & 0x7fffffffu); }

// x >= 0. Three of Newton's steps for 1 / sqrt(x), from an estimate by the exponent. (A loop would not become vector
// code.)
LOOP_INLINE float loop_sqrt(float x)
{
  float y = loop_from_bits(0x5f375a86u - (loop_bits(x) >> 1));
  y *= 1.5f - 0.5f * x * y * y;
  y *= 1.5f - 0.5f * x * y * y;
  y *= 1.5f - 0.5f * x * y * y;
  return x * y;
}

// x >= 0. The same for the inverse cube root.
LOOP_INLINE float loop_cbrt(float x)
{
  float y = loop_from_bits(0x54a21d2au - loop_bits(x) / 3);
  y *= (4 - x * y * y * y) * (1.0f / 3);
  y *= (4 - x * y * y * y) * (1.0f / 3);
  y *= (4 - x * y * y * y) * (1.0f / 3);
  return x * y * y;
}

// x > 0, not denormal. The mantissa m is taken from [sqrt(1/2), sqrt(2)), and log m = 2 artanh((m - 1) / (m + 1)).
LOOP_INLINE float loop_log2(float x)
{
  int32_t exponent = (int32_t)(loop_bits(x) - 0x3f3504f3u) >> 23;
  float m = loop_from_bits(loop_bits(x) - ((uint32_t)exponent << 23));
  float s = (m - 1) / (m + 1), s2 = s * s;
  float series = 1 + s2 * (1.0f / 3 + s2 * (1.0f / 5 + s2 * (1.0f / 7 + s2 * (1.0f / 9))));
  return (float)exponent + 2.885390082f * s * series;
}

// -126 <= x <= 126.
LOOP_INLINE float loop_exp2(float x)
{
  int32_t whole = (int32_t)(x + 128.5f) - 128;
  float f = (x - (float)whole) * 0.6931471806f;
  float series = 1 + f * (1 + f * (1.0f / 2 + f * (1.0f / 6 + f * (1.0f / 24 + f * (1.0f / 120 + f * (1.0f / 720))))));
  return series * loop_from_bits((uint32_t)(whole + 127) << 23);
}

// x^y for x >= 0 and 0 <= y <= 1; 0 where x is 0, or nearly.
LOOP_INLINE float loop_pow(float x, float y)
{
  float power = loop_exp2(y * loop_log2(loop_max(x, 0x1p-120f)));
  return loop_select(x > 0x1p-120f, power, 0);
}

// Linear value to displayed one, clamped to [0, 1]. Source: IEC 61966-2-1.
LOOP_INLINE float loop_srgb_encode(float linear)
{
  float x = loop_min(loop_max(linear, 0), 1);
  float power = 1.055f * loop_pow(x, 1 / 2.4f) - 0.055f, line = 12.92f * x;
  return loop_select(x > 0.0031308f, power, line);
}
