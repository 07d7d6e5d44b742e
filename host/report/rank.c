#include "report/rank.h"

#include <string.h>

// Floats that are not negative sort as their bits do, so a histogram of the upper half of the bits finds the value's
// upper half, and one of the lower half among those finds the rest.
float value_of_rank(const float *values, size_t count, uint64_t rank)
{
  uint32_t bins[1 << 16], prefix = 0;
  for (int shift = 16; shift >= 0; shift -= 16) {
    memset(bins, 0, sizeof bins);
    for (size_t i = 0; i < count; i++) {
      uint32_t bits;
      memcpy(&bits, &values[i], sizeof bits);
      if (bits >> 31 == 0 && (shift == 16 || bits >> 16 == prefix)) bins[bits >> shift & 0xffff]++;
    }
    uint32_t bin = 0;
    while (bin < 0xffff && rank >= bins[bin]) rank -= bins[bin++];
    prefix = shift == 16 ? bin : prefix << 16 | bin;
  }
  float value;
  memcpy(&value, &prefix, sizeof value);
  return value;
}
