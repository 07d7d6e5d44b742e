#include "support/compare_pictures.h"

#include <math.h>
#include <stdlib.h>

Image picture_make(uint32_t width, uint32_t height)
{
  size_t count = (size_t)width * height;
  Image image = {.width = width, .height = height, .pixels = calloc(4 * count, sizeof(float))};
  for (size_t i = 0; i < count; i++) image.pixels[4 * i + 3] = 1;
  return image;
}

void picture_set(Image *image, uint32_t x, uint32_t y, double r, double g, double b)
{
  float *pixel = image->pixels + 4 * ((size_t)y * image->width + x);
  pixel[0] = (float)r;
  pixel[1] = (float)g;
  pixel[2] = (float)b;
}

typedef struct Rgb {
  double r, g, b;
} Rgb;

// A number in [-1, 1) that depends on pixel and channel alone.
static double hash_noise(uint32_t x, uint32_t y, uint32_t channel)
{
  uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ channel * 0xc2b2ae3du;
  h = (h ^ h >> 15) * 0x2c1b3c6du;
  h = (h ^ h >> 12) * 0x297a2d39u;
  h ^= h >> 15;
  return (double)h / 0x1p31 - 1;
}

static Rgb waves(uint32_t x, uint32_t y)
{
  return (Rgb){0.5 + 0.45 * sin(x / 7.0 + y / 13.0), 0.5 + 0.45 * sin(x / 23.0), 0.5 + 0.45 * cos(y / 5.0 - x / 11.0)};
}

static Rgb scaled(Rgb c, double s) { return (Rgb){c.r * s, c.g * s, c.b * s}; }

// Each gives the colour of one pixel of the first or the second picture.
typedef Rgb (*PairFormula)(int second, uint32_t x, uint32_t y);

static Rgb pair_noise(int second, uint32_t x, uint32_t y)
{
  Rgb c = waves(x, y);
  double s = second ? 0.05 : 0;
  return (Rgb){c.r + s * hash_noise(x, y, 0), c.g + s * hash_noise(x, y, 1), c.b + s * hash_noise(x, y, 2)};
}

static Rgb pair_shift(int second, uint32_t x, uint32_t y) { return waves(x + (uint32_t)second, y); }

// A fine checkerboard and its mean: what a viewer does not see from far, nor a filter find in the colours.
static Rgb pair_checkers(int second, uint32_t x, uint32_t y)
{
  double v = second ? 0.5 : (x / 2 + y / 2) % 2;
  return (Rgb){v, v, 0.8 * v};
}

// Patches that differ in hue and little in luminance.
static Rgb pair_hue(int second, uint32_t x, uint32_t y)
{
  double v = 0.1 + 0.1 * (x / 20 % 5), w = 0.1 + 0.1 * (y / 20 % 5);
  return second ? (Rgb){v + 0.15, w, 0.3} : (Rgb){v, w + 0.045, 0.3};
}

// A dark picture with single bright pixels in one place or another: the failure of a few rays.
static Rgb pair_fireflies(int second, uint32_t x, uint32_t y)
{
  bool lit = x % 17 == 8 && y % 13 == (second ? 7 : 6);
  return lit ? (Rgb){3, 2, 1} : (Rgb){0.02, 0.02, 0.03};
}

// The edge of a hard shadow, a pixel and a half apart.
static Rgb pair_edge(int second, uint32_t x, uint32_t y)
{
  double distance = x * 0.8 - y * 0.6 - 40 - 1.5 * second;
  double lit = fmin(fmax(distance + 0.5, 0), 1);
  return scaled((Rgb){0.7, 0.6, 0.5}, 0.05 + 0.95 * lit);
}

// Eight powers of two of radiance, with relative noise.
static Rgb pair_radiance(int second, uint32_t x, uint32_t y)
{
  Rgb c = scaled(waves(x, y), exp2(8 * waves(y, x).g - 3));
  return second ? scaled(c, 1 + 0.2 * hash_noise(x, y, 0)) : c;
}

// More than half of it black, and a sun: the exposures go from the sun's down to what single precision can tell from 0.
static Rgb pair_sun(int second, uint32_t x, uint32_t y)
{
  double dx = x - 30.0, dy = y - 25.0 - second, r2 = dx * dx + dy * dy;
  if (r2 < 30) return (Rgb){900, 850, 700};
  if (x > 65) return second ? (Rgb){0.001, 0, 0} : (Rgb){0, 0, 0};
  return scaled((Rgb){0.4, 0.5, 0.8}, 20 / (10 + r2));
}

static const struct {
  const char *name;
  bool hdr;
  uint32_t width, height;
  PairFormula formula;
} pairs[PICTURE_PAIR_COUNT] = {
    {"noise", false, 150, 100, pair_noise},       {"shift", false, 150, 100, pair_shift},
    {"checkers", false, 131, 67, pair_checkers},  {"hue", false, 100, 100, pair_hue},
    {"fireflies", false, 97, 70, pair_fireflies}, {"edge", false, 150, 100, pair_edge},
    {"radiance", true, 150, 100, pair_radiance},  {"sun", true, 150, 60, pair_sun},
    {"small", true, 7, 5, pair_radiance},
};

PicturePair picture_pair_make(int index)
{
  PicturePair pair = {.name = pairs[index].name, .hdr = pairs[index].hdr};
  for (int second = 0; second < 2; second++) {
    Image image = picture_make(pairs[index].width, pairs[index].height);
    for (uint32_t y = 0; y < image.height; y++)
      for (uint32_t x = 0; x < image.width; x++) {
        Rgb c = pairs[index].formula(second, x, y);
        picture_set(&image, x, y, c.r, c.g, c.b);
      }
    *(second ? &pair.b : &pair.a) = image;
  }
  return pair;
}

void picture_pair_free(PicturePair *pair)
{
  image_free(&pair->a);
  image_free(&pair->b);
}
