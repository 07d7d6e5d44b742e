// How many of the texels under a square kernel leave a receiver lit: PCF. On a CPU device by what is told of whole
// blocks of texels (raster/depth_planes.cl) where it says enough.
//
//   Cost  1.5 ns a point where most kernels hold no edge, 3 to 4 ns where all do, for kernels of 3 x 3.
//   From  Reeves, Salesin, Cook, "Rendering Antialiased Shadows with Depth Maps", SIGGRAPH 1987.

#include "lib/shadow_view.cl"
#include "shared/depth_map.h"

// The receiver's plane in a map: depth at the lookup's point and its growth by a texel along x and y; and how much it
// may be off.
typedef struct PlaneDepth {
  FloatL depth, by_x, by_y, slack;
} PlaneDepth;

// One of a light's maps.
typedef struct LightMap {
  global const float *texels, *planes, *wide;
  uint size;
} LightMap;

// `maps`: those of the light.
static inline LightMap light_map(global const ShadowInfo *info, global const float *maps, uint number)
{
  uint size = info->size_px, texels = size * size, count = info->view_count;
  global const float *planes = maps + count * texels, *wide = planes + count * depth_plane_floats(size);
  LightMap map = {maps + number * texels, planes + number * depth_plane_floats(size),
                  wide + number * depth_wide_floats(size), size};
  return map;
}

#ifdef HAS_PERMUTATION
#define HAS_WINDOWS

// Bit 4 y + x of a lane of `group`: texel (x, y) of the 4 x 4 from (x0, y0) on leaves the receiver's plane, whose depth
// at the first is `receiver`, lit. Lane by lane: the texels lie in 2 x 2 blocks, and two permutations pick them. All
// are in the map, none in its last row or column.
static inline UintL windows_lit(global const float *map, int size, IntL x0, IntL y0, FloatL receiver,
                                const PlaneDepth *plane, IntL group)
{
  const int16 column = LANE_INDEX & 3, row = LANE_INDEX >> 2, corner = column | row << 8;
  IntL first = ((y0 >> INTL(2)) * INTL(size / 4) + (x0 >> INTL(2))) * INTL(16);
  IntL shift = (x0 & INTL(3)) | (y0 & INTL(3)) << INTL(8);
  UintL lit = UINTL(0);
  for (uint bits = lane_bits(group); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    global const float *from = map + LANE_INT(first, lane);
    int16 at = corner + LANE_INT(shift, lane);
    int16 index = (at & 3) | (at >> 6 & 12) | (at & 4) << 2;
    float16 upper = __builtin_ia32_vpermi2varps512(vload16(0, from), index, vload16(1, from));
    float16 lower = __builtin_ia32_vpermi2varps512(vload16(size / 4, from), index, vload16(size / 4 + 1, from));
    float16 there = (at & 0x400) != 0 ? lower : upper;
    float by_x = LANE_FLOAT(plane->by_x, lane), by_y = LANE_FLOAT(plane->by_y, lane);
    float16 here = LANE_FLOAT(receiver, lane);  // step by step, as lit_by_square's loops go
#pragma unroll
    for (int i = 0; i < 3; i++) here = row > i ? here + by_y : here;
#pragma unroll
    for (int i = 0; i < 3; i++) here = column > i ? here + by_x : here;
    LANE_UINT(lit, lane) = lane_bits(min_lane(here, FLOATL(1)) <= there);  // 1: nothing is there
  }
  return lit;
}
#endif

// Share of the kernel's texels that leave the receiver's plane lit. Of each row and column of texels the kernel covers
// all but the ends, and of these 1 - f and f.
static inline FloatL lit_by_square(global const float *map, int size, int kernel_px, const MapPoint *at,
                                   const PlaneDepth *plane, IntL group)
{
  FloatL zero = FLOATL(0), one = FLOATL(1), half_texel = FLOATL(0.5f), half_side = FLOATL(0.5f * (float)kernel_px);
  FloatL left = at->x - half_side, top = at->y - half_side, x0 = floor_lane(left), y0 = floor_lane(top), sum = zero;
  FloatL share_x = left - x0, share_y = top - y0, receiver = plane->depth - plane->slack;
  receiver += plane->by_x * (x0 + half_texel - at->x) + plane->by_y * (y0 + half_texel - at->y);
  IntL first = INTL(0), last = INTL(size - 1), three = INTL(3), two = INTL(2);
#ifdef HAS_WINDOWS
  IntL x_first = LANE_CONVERT_INT(x0), y_first = LANE_CONVERT_INT(y0), end = INTL(size - 4);
  IntL within = (x_first >= first) & (y_first >= first) & (x_first < end) & (y_first < end);
  if (kernel_px <= 3 && !any_lane(group & !within)) {
    UintL lit = windows_lit(map, size, x_first, y_first, receiver, plane, group);
    for (int y = 0; y <= kernel_px; y++) {
      FloatL row = zero;
      for (int x = 0; x <= kernel_px; x++) {
        FloatL share = x == 0 ? one - share_x : x == kernel_px ? share_x : one;
        row += (lit & UINTL(1u << (4 * y + x))) != UINTL(0) ? share : zero;
      }
      sum += y == 0 ? row - row * share_y : y == kernel_px ? row * share_y : row;
    }
    FloatL part = sum / FLOATL((float)(kernel_px * kernel_px));
    return part > FLOATL(1 - 1e-6f) ? one : part;
  }
#endif
  for (int y = 0; y <= kernel_px; y++, receiver += plane->by_y) {
    IntL across = clamp(LANE_CONVERT_INT(y0) + INTL(y), first, last);
    IntL blocks = (across >> two) * INTL(size * 4) + (across & three) * INTL(4);
    FloatL row = zero, here = receiver;
    for (int x = 0; x <= kernel_px; x++, here += plane->by_x) {
      IntL along = clamp(LANE_CONVERT_INT(x0) + INTL(x), first, last);
      FloatL there = LANE_GATHER(FloatL, map, blocks + (along & INTL(~3)) * INTL(4) + (along & three));
      FloatL share = x == 0 ? one - share_x : x == kernel_px ? share_x : one;
      row += min_lane(here, one) <= there ? share : zero;  // 1: nothing is there
    }
    sum += y == 0 ? row - row * share_y : y == kernel_px ? row * share_y : row;
  }
  FloatL share = sum / FLOATL((float)(kernel_px * kernel_px));
#if LANES > 1
  share = share > FLOATL(1 - 1e-6f) ? one : share;  // as kernels_judge has it
#endif
  return share;
}

#if LANES > 1
#define CLEAR_COLUMNS 16
#define CLEAR_ROWS 16
#define CLEAR_LANES 3  // fewer are not worth a look

// Where points are in a map: least x and y, greatest x and y.
static inline float4 points_box(const MapPoint *at, IntL group)
{
  FloatL nowhere = FLOATL(-INFINITY), zero = FLOATL(0);
  return (float4)(-greatest_lane(group ? zero - at->x : nowhere), -greatest_lane(group ? zero - at->y : nowhere),
                  greatest_lane(group ? at->x : nowhere), greatest_lane(group ? at->y : nowhere));
}

// Returns 1 where all blocks of block_px x block_px texels under kernels of that side, whose middles are in `box`,
// leave a plane lit, 0 where all leave it in the dark, -1 where neither is sure. It is the plane of one lane. By the
// planes of the blocks, four at once.
static inline int kernels_judge(global const float *planes, uint size, uint block_px, float side, float4 box,
                                const MapPoint *at, const PlaneDepth *plane, uint lane)
{
  const int16 number = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15), field = number & 3;
  const int16 is_end = field <= DEPTH_PLANE_HIGH;
  const float16 block = convert_float16(number >> 2), turn = field == DEPTH_PLANE_HIGH ? (float16)(-1) : (float16)(1);
  const float px = (float)block_px;
  const float16 reach_px = (px - 1) * turn;
  int last = (int)(size / block_px) - 1;
  const float4 reach = (float4)(-0.5f, -0.5f, 0.5f, 0.5f) * side;
  const int4 blocks = convert_int4(clamp((box + reach) * (1 / px), 0.0f, (float)last));
  int x0 = blocks.x, y0 = blocks.y, x1 = blocks.z, y1 = blocks.w;
  if (x1 - x0 >= CLEAR_COLUMNS || y1 - y0 >= CLEAR_ROWS) return -1;
  float by_x = LANE_FLOAT(plane->by_x, lane), by_y = LANE_FLOAT(plane->by_y, lane);
  float slack = LANE_FLOAT(plane->slack, lane), depth = LANE_FLOAT(plane->depth, lane) - slack;
  float16 slopes = field == DEPTH_PLANE_BY_X ? (float16)(by_x) : (float16)(by_y), worst = INFINITY, zeros = 0;
  float16 down = is_end ? (float16)(px * by_y) : zeros, column = block + (float)x0;
  for (int x = x0; x <= x1; x += 4, column += 4) {
    int16 within = is_end & (column <= (float)x1);
    float16 here = depth + by_x * (px * column + 0.5f - LANE_FLOAT(at->x, lane)) +
                   by_y * (px * (float)y0 + 0.5f - LANE_FLOAT(at->y, lane));
    float16 lower = zeros;
    here = is_end ? here : slopes;
    for (int y = y0; y <= y1; y++, lower += down) {
      float16 apart = vload16(0, planes + 4 * (y * (last + 1) + x)) - (here + lower);
      float16 more_x = apart.s22226666aaaaeeee * reach_px, more_y = apart.s33337777bbbbffff * reach_px;
      apart = apart * turn + (more_x < 0 ? more_x : zeros) + (more_y < 0 ? more_y : zeros);
      worst = (within & (apart < worst)) ? apart : worst;
    }
  }
  if (!any_of_16((field == DEPTH_PLANE_LOW) & !(worst >= 0.25f * slack))) return 1;
  return any_of_16((field == DEPTH_PLANE_HIGH) & !(worst > 0.25f * slack)) ? -1 : 0;
}
#endif

static inline FloatL lit_by_kernel(const LightMap *map, uint kernel_px, const MapPoint *at, const PlaneDepth *plane,
                                   UintL id, IntL group)
{
#if LANES > 1
  // Most of a picture lies far from any shadow's edge, and most vectors of lanes on one triangle, whose plane is the
  // same for all of them but for rounding, which takes no quarter of the slack.
  uint bits = lane_bits(group), lane = lowest_bit(bits);
  if (popcount(bits) >= CLEAR_LANES && !any_lane(group & (id != UINTL(LANE_UINT(id, lane))))) {
    int all = kernels_judge(map->planes, map->size, 4, (float)kernel_px, points_box(at, group), at, plane, lane);
    if (all >= 0) return FLOATL((float)all);
  }
#endif
  if (kernel_px == 3) return lit_by_square(map->texels, (int)map->size, 3, at, plane, group);
  return lit_by_square(map->texels, (int)map->size, (int)kernel_px, at, plane, group);
}
