#include "device_scene/ggx_sample.h"

#include <math.h>

GgxSample ggx_sample(int i, int count, double alpha)
{
  double x = (i + 0.5) / count, reversed = 0, digit = 0.5;
  for (int bits = i; bits; bits >>= 1, digit /= 2) reversed += (bits & 1) * digit;
  double phi = 2 * M_PI * reversed;
  double cosine2 = (1 - x) / (1 + (alpha * alpha - 1) * x), cosine = sqrt(cosine2), sine = sqrt(fmax(0, 1 - cosine2));
  double denominator = cosine2 * (alpha * alpha - 1) + 1;
  return (GgxSample){.up = 2 * cosine2 - 1,
                     .along = 2 * cosine * sine * cos(phi),
                     .across = 2 * cosine * sine * sin(phi),
                     .density = alpha * alpha / (4 * M_PI * denominator * denominator)};
}
