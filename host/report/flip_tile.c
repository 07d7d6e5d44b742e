#include "report/flip_tile.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "report/loop_math.h"

enum { WIDTH = FLIP_TILE_WIDTH, HEIGHT = FLIP_TILE_HEIGHT, LANES = 16, ALIGNMENT = 64 };

// Planes that the opponent planes are filtered to along x.
enum Across { ACROSS_Y, ACROSS_CX, ACROSS_CZ_0, ACROSS_CZ_1, ACROSS_EDGE, ACROSS_POINT, ACROSS_GAUSS, ACROSS_COUNT };

// What a viewer sees of a picture: CIELAB with chroma scaled by lightness (Hunt's effect), strength of features.
enum Seen { SEEN_LIGHTNESS, SEEN_A, SEEN_B, SEEN_EDGE, SEEN_POINT, SEEN_COUNT };

// Planes of rows = HEIGHT + 2 halo rows, but for what is seen and the errors.
struct FlipTile {
  const FlipFilters *filters;
  int rows, stride;
  float *linear[2][3];          // [rows][stride], of either picture
  float *opponent[3];           // [rows][stride]: Y, X - Y, Y - Z, each over the white's
  float *across[ACROSS_COUNT];  // [rows][WIDTH]
  float *seen[2][SEEN_COUNT];   // [HEIGHT][WIDTH], of either picture
  float *errors;                // [HEIGHT][WIDTH]
};

// The next plane of `memory`; every plane begins with a cache line.
static float *plane_take(float **memory, size_t size)
{
  float *plane = *memory;
  *memory += size;
  return plane;
}

FlipTile *flip_tile_make(const FlipFilters *filters)
{
  int rows = HEIGHT + 2 * filters->halo, stride = (WIDTH + 2 * filters->halo + LANES - 1) / LANES * LANES;
  size_t wide = (size_t)rows * (size_t)stride, narrow = (size_t)rows * WIDTH, inner = HEIGHT * WIDTH;
  size_t header = (sizeof(FlipTile) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
  size_t floats = 9 * wide + ACROSS_COUNT * narrow + (2 * SEEN_COUNT + 1) * inner;
  FlipTile *tile = aligned_alloc(ALIGNMENT, header + floats * sizeof(float));
  if (!tile) return NULL;
  *tile = (FlipTile){.filters = filters, .rows = rows, .stride = stride};
  float *memory = (float *)((char *)tile + header);
  for (int c = 0; c < 6; c++) tile->linear[c / 3][c % 3] = plane_take(&memory, wide);
  for (int c = 0; c < 3; c++) tile->opponent[c] = plane_take(&memory, wide);
  for (int c = 0; c < ACROSS_COUNT; c++) tile->across[c] = plane_take(&memory, narrow);
  for (int c = 0; c < 2 * SEEN_COUNT; c++) tile->seen[c / SEEN_COUNT][c % SEEN_COUNT] = plane_take(&memory, inner);
  tile->errors = plane_take(&memory, inner);
  return tile;
}

void flip_tile_free(FlipTile *tile) { free(tile); }

static void picture_load(FlipTile *tile, int picture, const Image *image, uint32_t left, uint32_t top)
{
  int halo = tile->filters->halo;
  for (int row = 0; row < tile->rows; row++) {
    const float *line = image->pixels + 4 * filter_clamp((int64_t)top + row - halo, image->height) * image->width;
    for (int x = 0; x < tile->stride; x++) {
      const float *pixel = line + 4 * filter_clamp((int64_t)left + x - halo, image->width);
      for (int c = 0; c < 3; c++) tile->linear[picture][c][row * tile->stride + x] = loop_max(pixel[c], 0);
    }
  }
}

// Linear sRGB to X, Y, Z, each over the white's, and back. Source: the authors' evaluator, for its digits.
#define TO_X(r, g, b) (0.43389539f * (r) + 0.37624237f * (g) + 0.18986224f * (b))
#define TO_Y(r, g, b) (0.21263682f * (r) + 0.71518298f * (g) + 0.07218020f * (b))
#define TO_Z(r, g, b) (0.01775242f * (r) + 0.10946563f * (g) + 0.87278195f * (b))

LOOP_INLINE float tone_map(float x)
{
  x = loop_min(x, 1e6f);  // the curve is above 1 there, and its squares are finite
  float above = x * (x * (float)flip_aces[0] + (float)flip_aces[1]);
  return above / (x * (x * (float)flip_aces[2] + (float)flip_aces[3]) + (float)flip_aces[4]);
}

// Linear values in [0, 1] to opponent values: those of CIELAB without the cube root and the factors.
LOOP_INLINE void opponent_block(float *restrict y_out, float *restrict cx_out, float *restrict cz_out,
                                float (*restrict linear)[LANES])
{
  for (int i = 0; i < LANES; i++) {
    float r = linear[0][i], g = linear[1][i], b = linear[2][i], y = TO_Y(r, g, b);
    y_out[i] = y;
    cx_out[i] = TO_X(r, g, b) - y;
    cz_out[i] = y - TO_Z(r, g, b);
  }
}

// scale: of the exposure, or 0 for the picture as it is.
LOOP_INLINE void opponent_planes(FlipTile *tile, int picture, float scale)
{
  for (int at = 0; at < tile->rows * tile->stride; at += LANES) {
    float linear[3][LANES];
    for (int c = 0; c < 3; c++) {
      const float *restrict in = tile->linear[picture][c] + at;
      if (scale > 0)
        for (int i = 0; i < LANES; i++) linear[c][i] = loop_min(tone_map(scale * in[i]), 1);
      else
        for (int i = 0; i < LANES; i++) linear[c][i] = loop_min(in[i], 1);
    }
    opponent_block(tile->opponent[0] + at, tile->opponent[1] + at, tile->opponent[2] + at, linear);
  }
}

LOOP_INLINE void across_planes(FlipTile *tile)
{
  const FlipFilters *filters = tile->filters;
  for (int row = 0; row < tile->rows; row++) {
    ptrdiff_t from = row * tile->stride + filters->halo, to = row * WIDTH;
    const float *y = tile->opponent[0] + from, *cx = tile->opponent[1] + from, *cz = tile->opponent[2] + from;
    filter_row_pair(tile->across[ACROSS_Y] + to, tile->across[ACROSS_GAUSS] + to, y, 1, &filters->achromatic,
                    &filters->gauss, 1, 1);
    filter_row_pair(tile->across[ACROSS_EDGE] + to, tile->across[ACROSS_POINT] + to, y, 1, &filters->edge,
                    &filters->point, -1, 1);
    filter_row(tile->across[ACROSS_CX] + to, cx, 1, &filters->red_green, 1);
    filter_row_pair(tile->across[ACROSS_CZ_0] + to, tile->across[ACROSS_CZ_1] + to, cz, 1, &filters->blue_yellow[0],
                    &filters->blue_yellow[1], 1, 1);
  }
}

// CIELAB's cube root, with its line near black.
LOOP_INLINE float lab_curve(float t)
{
  const float delta = 6.0f / 29;
  float root = loop_cbrt(t), line = t / (3 * delta * delta) + 4.0f / 29;
  return loop_select(t > delta * delta * delta, root, line);
}

// Filtered opponent values to what is seen; sets *lightness, *a and *b.
LOOP_INLINE void lab_hunt(float *lightness, float *a, float *b, float y, float cx, float cz)
{
  const float white_x = 0.950428545f, white_z = 1.088900371f;
  float x = (y + cx) * white_x, z = (y - cz) * white_z;
  float red = loop_min(loop_max(3.241003275f * x - 1.537398934f * y - 0.498615861f * z, 0), 1);
  float green = loop_min(loop_max(-0.969224334f * x + 1.875930071f * y + 0.041554224f * z, 0), 1);
  float blue = loop_min(loop_max(0.055639423f * x - 0.204011202f * y + 1.057148933f * z, 0), 1);
  float fx = lab_curve(TO_X(red, green, blue));
  float fy = lab_curve(TO_Y(red, green, blue));
  float fz = lab_curve(TO_Z(red, green, blue));
  float l = 116 * fy - 16;
  *lightness = l;
  *a = 0.01f * l * 500 * (fx - fy);
  *b = 0.01f * l * 200 * (fy - fz);
}

// Filters row `row` of the tile along y.
LOOP_INLINE void seen_row(FlipTile *tile, int picture, int row)
{
  const FlipFilters *filters = tile->filters;
  float y[WIDTH], cx[WIDTH], cz[2][WIDTH], edges[2][WIDTH], points[2][WIDTH];
  ptrdiff_t at = (ptrdiff_t)(row + filters->halo) * WIDTH, to = (ptrdiff_t)row * WIDTH;
  filter_row(y, tile->across[ACROSS_Y] + at, WIDTH, &filters->achromatic, 1);
  filter_row(cx, tile->across[ACROSS_CX] + at, WIDTH, &filters->red_green, 1);
  filter_row(cz[0], tile->across[ACROSS_CZ_0] + at, WIDTH, &filters->blue_yellow[0], 1);
  filter_row(cz[1], tile->across[ACROSS_CZ_1] + at, WIDTH, &filters->blue_yellow[1], 1);
  filter_row(edges[0], tile->across[ACROSS_EDGE] + at, WIDTH, &filters->gauss, 1);
  filter_row(points[0], tile->across[ACROSS_POINT] + at, WIDTH, &filters->gauss, 1);
  filter_row_pair(edges[1], points[1], tile->across[ACROSS_GAUSS] + at, WIDTH, &filters->edge, &filters->point, -1, 1);

  float seen[SEEN_COUNT][WIDTH];
  for (int x = 0; x < WIDTH; x++) {
    lab_hunt(&seen[SEEN_LIGHTNESS][x], &seen[SEEN_A][x], &seen[SEEN_B][x], y[x], cx[x], cz[0][x] + cz[1][x]);
    seen[SEEN_EDGE][x] = loop_sqrt(edges[0][x] * edges[0][x] + edges[1][x] * edges[1][x]);
    seen[SEEN_POINT][x] = loop_sqrt(points[0][x] * points[0][x] + points[1][x] * points[1][x]);
  }
  for (int plane = 0; plane < SEEN_COUNT; plane++) memcpy(tile->seen[picture][plane] + to, seen[plane], sizeof seen[0]);
}

// HyAB distance of two colours, to the power of 0.7.
LOOP_INLINE float color_distance(float lightness, float a, float b)
{
  return loop_pow(loop_abs(lightness) + loop_sqrt(a * a + b * b), 0.7f);
}

// The largest distance there is: green to blue.
static float color_distance_max(void)
{
  float green[3], blue[3];
  lab_hunt(&green[0], &green[1], &green[2], TO_Y(0, 1, 0), TO_X(0, 1, 0) - TO_Y(0, 1, 0),
           TO_Y(0, 1, 0) - TO_Z(0, 1, 0));
  lab_hunt(&blue[0], &blue[1], &blue[2], TO_Y(0, 0, 1), TO_X(0, 0, 1) - TO_Y(0, 0, 1), TO_Y(0, 0, 1) - TO_Z(0, 0, 1));
  return color_distance(green[0] - blue[0], green[1] - blue[1], green[2] - blue[2]);
}

// Raises `errors` to what both pictures differ by in LANES pixels. Distances up to 0.4 of the largest are given 0.95
// of the range; features raise the result by the exponent.
LOOP_INLINE void error_block(float *restrict errors, float (*restrict difference)[LANES], float largest)
{
  const float knee = 0.4f * largest, knee_error = 0.95f;
  for (int i = 0; i < LANES; i++) {
    float distance = color_distance(difference[SEEN_LIGHTNESS][i], difference[SEEN_A][i], difference[SEEN_B][i]);
    float below = distance * (knee_error / knee);
    float above = knee_error + (distance - knee) * ((1 - knee_error) / (largest - knee));
    float color = loop_select(distance < knee, below, above);
    float edge = loop_abs(difference[SEEN_EDGE][i]), point = loop_abs(difference[SEEN_POINT][i]);
    float feature = loop_sqrt(0.70710678f * loop_max(edge, point));
    errors[i] = loop_max(errors[i], loop_pow(color, 1 - feature));
  }
}

LOOP_CLONES static void tile_compare_at(FlipTile *tile, float scale, float largest)
{
  for (int picture = 0; picture < 2; picture++) {
    opponent_planes(tile, picture, scale);
    across_planes(tile);
    for (int row = 0; row < HEIGHT; row++) seen_row(tile, picture, row);
  }
  for (int at = 0; at < HEIGHT * WIDTH; at += LANES) {
    float difference[SEEN_COUNT][LANES];
    for (int plane = 0; plane < SEEN_COUNT; plane++) {
      const float *restrict a = tile->seen[0][plane] + at, *restrict b = tile->seen[1][plane] + at;
      for (int i = 0; i < LANES; i++) difference[plane][i] = a[i] - b[i];
    }
    error_block(tile->errors + at, difference, largest);
  }
}

const float *flip_tile_compare(FlipTile *tile, const Image *const images[2], uint32_t left, uint32_t top,
                               const FlipExposures *exposures)
{
  size_t plane_bytes = (size_t)tile->rows * (size_t)tile->stride * sizeof(float);
  bool equal = true;
  memset(tile->errors, 0, HEIGHT * WIDTH * sizeof *tile->errors);
  for (int i = 0; i < 2; i++) picture_load(tile, i, images[i], left, top);
  for (int c = 0; c < 3; c++) equal = equal && !memcmp(tile->linear[0][c], tile->linear[1][c], plane_bytes);
  if (equal) return tile->errors;

  float largest = color_distance_max();
  if (!exposures->count) tile_compare_at(tile, 0, largest);
  for (int i = 0; i < exposures->count; i++)
    tile_compare_at(tile, (float)exp2(exposures->start + i * exposures->step), largest);
  return tile->errors;
}
