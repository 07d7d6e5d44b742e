// Directions of the environment image chosen by its luminance, from the table that host/device_scene makes
// (shared/scene.h): a row of cells, a cell of the row, and a place in the cell by the bilinear interpolation itself, so
// that luminance over density is the same everywhere but for the sine within a row.
//
//   Cost  a block of the table for each factor of 16 in height and in width, and four texels a lane.
//   From  Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th edition, 2023, sections 2.4.2, A.4 and A.5.

#include "lib/environment.cl"

typedef struct EnvironmentSample {
  Vec3L direction;  // unit, world space
  Vec3L radiance;
  FloatL density;  // 1 / sr; 0 where there is no light
} EnvironmentSample;

static inline FloatL luminance3(Vec3L color)
{
  return FLOATL(LUMINANCE_R) * color.x + FLOATL(LUMINANCE_G) * color.y + FLOATL(LUMINANCE_B) * color.z;
}

static inline FloatL table_load(global const float *table, UintL index)
{
#if LANES == 1
  return table[index];
#else
  FloatL values;
  for (uint lane = 0; lane < LANES; lane++) LANE_FLOAT(values, lane) = table[LANE_UINT(index, lane)];
  return values;
#endif
}

// How many of the TABLE_BLOCK rising numbers are not above x.
static inline uint block_count(global const float *block, float x)
{
#if LANES == 1
  uint at = 0;
  for (uint step = TABLE_BLOCK / 2; step; step /= 2) at += block[at + step] <= x ? step : 0;
  return at + 1;
#elif LANES == 8
  return popcount(lane_bits(vload8(0, block) <= FLOATL(x))) + popcount(lane_bits(vload8(1, block) <= FLOATL(x)));
#else
  return popcount(lane_bits(vload16(0, block) <= FLOATL(x)));
#endif
}

// Last of `count` numbers of the search tree at table[base] (shared/scene.h) that is not above x, for the lanes of
// `bits`; the first number is 0. `within` receives how far x is from there to the next, 0..1. Level by level for all
// lanes, whose loads then wait for each other less.
static inline UintL tree_find(global const float *table, UintL base, uint count, FloatL x, uint lanes, FloatL *within)
{
  UintL at = UINTL(0);
  FloatL low = FLOATL(0), high = FLOATL(1);
  uint sizes[8], level = 0;
  do {
    count = TABLE_BLOCKS(count);
    sizes[level++] = count * TABLE_BLOCK;
  } while (count > 1);
  while (level-- > 0) {
    for (uint bits = lanes; bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits), block = LANE_UINT(at, lane) * TABLE_BLOCK;
      LANE_UINT(at, lane) = block + block_count(table + LANE_UINT(base, lane) + block, LANE_FLOAT(x, lane)) - 1;
    }
    if (level) base += UINTL(sizes[level]);
  }
  for (uint bits = lanes; bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits), found = LANE_UINT(at, lane);
    global const float *numbers = table + LANE_UINT(base, lane);
    LANE_FLOAT(low, lane) = numbers[found];
    LANE_FLOAT(high, lane) = found + 1 < sizes[0] ? min(numbers[found + 1], 1.0f) : 1.0f;
  }
  FloatL width = high - low;
  *within = min_lane(width > FLOATL(0) ? (x - low) / width : FLOATL(0), FLOATL(0.99999994f));
  return at;
}

// x in [0, 1) with density proportional to a (1 - x) + b x, a and b not negative.
static inline FloatL linear_sample(FloatL x, FloatL a, FloatL b)
{
  FloatL sum = a + b;
  IntL flat = !(sum > FLOATL(0));
  FloatL share = flat ? FLOATL(0.5f) : a / sum;
  FloatL root = sqrt(share * share + x * (FLOATL(1) - FLOATL(2) * share));
  return flat ? x : min_lane(x / max_lane(share + root, FLOATL(1e-20f)), FLOATL(0.99999994f));
}

static inline EnvironmentSample environment_sample(constant EnvironmentInfo *info, global const Float4 *pixels,
                                                   global const float *table, FloatL x, FloatL y, IntL mask)
{
  EnvironmentSample s;
  FloatL across, down;
  uint width = info->width, rows = ENVIRONMENT_TABLE_ROWS(info->height);
  uint row_tree = search_tree_size(rows), column_tree = search_tree_size(width);
  uint lanes = lane_bits(mask);
  UintL row = tree_find(table, UINTL(0), rows, y, lanes, &down);
  UintL column = tree_find(table, UINTL(row_tree + rows) + row * UINTL(column_tree), width, x, lanes, &across);
  IntL above = LANE_AS_INT(row) - INTL(1);
  ImageCorners corners = environment_corners(info, pixels, LANE_AS_INT(column), above, mask);
  FloatL l00 = luminance3(corners.at[0][0]), l01 = luminance3(corners.at[0][1]);
  FloatL l10 = luminance3(corners.at[1][0]), l11 = luminance3(corners.at[1][1]);
  down = linear_sample(down, l00 + l01, l10 + l11);
  across = linear_sample(across, l00 + (l10 - l00) * down, l01 + (l11 - l01) * down);
  s.radiance = corners_blend(&corners, across, down);

  // The first and the last row of cells are half rows: the upper one has no upper half.
  IntL first = row == UINTL(0), last = row == UINTL(rows - 1);
  FloatL height_share = (first | last) ? FLOATL(0.5f) : FLOATL(1), skipped = first ? FLOATL(0.5f) : FLOATL(0);
  FloatL v = (LANE_CONVERT_FLOAT(above) + FLOATL(0.5f) + skipped + down * height_share) / FLOATL((float)info->height);
  FloatL u = (LANE_CONVERT_FLOAT(column) + FLOATL(0.5f) + across) / FLOATL((float)width);
  FloatL phi = FLOATL(6.2831853f) * (u - FLOATL(0.5f)), theta = FLOATL(3.1415927f) * v;
  FloatL sine = max_lane(sin(theta), FLOATL(1e-7f));
  FloatL x_image = sine * cos(phi), z_image = sine * sin(phi);
  FloatL turn_cos = FLOATL(info->cos_rotation), turn_sin = FLOATL(info->sin_rotation);
  s.direction = vec3l(turn_cos * x_image + turn_sin * z_image, cos(theta), turn_cos * z_image - turn_sin * x_image);
  s.density = max_lane(luminance3(s.radiance), FLOATL(0)) * table_load(table, UINTL(row_tree) + row) / sine;
  s.radiance = scale3(s.radiance, FLOATL(info->intensity));
  return s;
}

// Density with which environment_sample chooses a direction, whose radiance and place are known.
static inline FloatL environment_density(constant EnvironmentInfo *info, global const float *table, Vec3L direction,
                                         Vec3L radiance, const ImagePlace *place)
{
  uint rows = ENVIRONMENT_TABLE_ROWS(info->height);
  FloatL sine = max_lane(sqrt(direction.x * direction.x + direction.z * direction.z), FLOATL(1e-7f));
  FloatL scale = table_load(table, UINTL(search_tree_size(rows)) + LANE_AS_UINT(place->row + INTL(1)));
  return max_lane(luminance3(radiance), FLOATL(0)) * scale / (sine * FLOATL(info->intensity));
}
