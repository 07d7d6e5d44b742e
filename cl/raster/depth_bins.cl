// Raster of depth maps, one work-item a bin of a view: the least depth at each texel's centre.
//
//   in    records, spans, starts, lists   triangles by bin (depth_setup.cl)
//         blocks, and the scene's materials for MASK
//   out   maps      [size * size] of each view (shared/depth_map.h), from its first_texel on
//
//   Cost  about 20 ns a triangle and bin, 1 to 3 ns a triangle and block of 4 x 4 texels; 4 bytes a texel.
//   Coverage and depth are those of lib/map_triangle.cl. A bin is drawn in memory of its own and stored once. With
//   `begin` it starts at 1, without it what is there is improved on: a scene of several passes. Chunks come nearest
//   first, up to what is behind all of the bin.

#include "lib/bins.cl"
#include "lib/map_triangle.cl"

#define BIN_SIDE (RASTER_BIN_PX / 4)  // blocks along the side of a bin
#define BLOCK_PARTS (16 / LANES)
#define ROW_PARTS (BIN_SIDE * BLOCK_PARTS)

// Where a bin's triangles are drawn, and what MASK is decided from.
typedef struct Target {
  FloatL texels[BIN_SIDE * ROW_PARTS];  // blocks row by row
  int4 window;                          // the bin's first texel, and its size on the map
  constant RasterView *view;
  global const RasterBlock *blocks;
  const AttributeSources *attributes;
} Target;

// Part of a block: texels (x, y) of it, of which `all` are negative where the triangle is not.
static inline __attribute__((always_inline)) void part_draw(const WindowTriangle *t, int column, int row, uint part,
                                                            IntL all, IntL x, IntL y, uint number, uint flags,
                                                            Target *to)
{
  FloatL there = texel_depth(t, block_depth(t, 4 * column, 4 * row), x, y);
  FloatL *texels = &to->texels[row * ROW_PARTS + column * BLOCK_PARTS + part], before = *texels;
  IntL nearer = (all >= INTL(0)) & (there < before);
#ifdef HAS_MASK
  if (flags & TRIANGLE_MASKED && any_lane(nearer)) {
    FloatL px = LANE_CONVERT_FLOAT(INTL(to->window.x + 4 * column) + x) + FLOATL(0.5f);
    FloatL py = LANE_CONVERT_FLOAT(INTL(to->window.y + 4 * row) + y) + FLOATL(0.5f);
    nearer = nearer & texels_pass(to->attributes, &to->blocks[number / RASTER_STEP], number % RASTER_STEP, to->view,
                                  nearer, px, py);
  }
#endif
  *texels = nearer ? there : before;
}

// Least and greatest growth of an edge function from the first texel of a block to any other.
static inline int block_least(int x, int y) { return 3 * (min(x, 0) + min(y, 0)); }
static inline int block_greatest(int x, int y) { return 3 * (max(x, 0) + max(y, 0)); }

#if LANES == 16
// A row of blocks at a time: which of them the triangle may meet, and which it fills.
static __attribute__((noinline)) void bin_draw_wide(const WindowTriangle *t, uint number, uint flags, Target *to)
{
  int16 x = LANE_INDEX & INTL(3), y = LANE_INDEX >> INTL(2);
  int16 texel[3], along[3];
  int least[3], greatest[3];
#pragma unroll
  for (int i = 0; i < 3; i++) {
    texel[i] = INTL(t->edge_x[i]) * x + INTL(t->edge_y[i]) * y;
    along[i] = INTL(4 * t->edge_x[i]) * LANE_INDEX + INTL(t->edge[i]);
    least[i] = block_least(t->edge_x[i], t->edge_y[i]);
    greatest[i] = block_greatest(t->edge_x[i], t->edge_y[i]);
  }
  float16 slope = FLOATL(t->depth_x * RASTER_SNAP) * LANE_CONVERT_FLOAT(x) +
                  FLOATL(t->depth_y * RASTER_SNAP) * LANE_CONVERT_FLOAT(y);
  uint columns = (2u << t->last_x / 4) - (1u << t->first_x / 4);
  for (int row = t->first_y / 4; row <= t->last_y / 4; row++) {
    int16 edge0 = along[0] + INTL(4 * row * t->edge_y[0]), edge1 = along[1] + INTL(4 * row * t->edge_y[1]),
          edge2 = along[2] + INTL(4 * row * t->edge_y[2]);
    uint meets = lane_bits(((edge0 + INTL(greatest[0])) | (edge1 + INTL(greatest[1])) | (edge2 + INTL(greatest[2]))) >=
                           INTL(0)) &
                 columns;
    uint fills = 0;
    if (!(flags & TRIANGLE_MASKED))
      fills = lane_bits(((edge0 + INTL(least[0])) | (edge1 + INTL(least[1])) | (edge2 + INTL(least[2]))) >= INTL(0)) &
              meets;
    float16 *texels = &to->texels[row * ROW_PARTS];
    for (uint bits = fills; bits; bits &= bits - 1) {
      int column = (int)lowest_bit(bits);
      float16 depth = slope + FLOATL(block_depth(t, 4 * column, 4 * row));
      depth = max_lane(min_lane(depth, FLOATL(t->greatest)), FLOATL(t->least));
      texels[column] = min_lane(depth, texels[column]);
    }
    for (uint bits = meets & ~fills; bits; bits &= bits - 1) {
      int column = (int)lowest_bit(bits);
      int16 all = (texel[0] + INTL(t->edge[0] + 4 * column * t->edge_x[0] + 4 * row * t->edge_y[0])) |
                  (texel[1] + INTL(t->edge[1] + 4 * column * t->edge_x[1] + 4 * row * t->edge_y[1])) |
                  (texel[2] + INTL(t->edge[2] + 4 * column * t->edge_x[2] + 4 * row * t->edge_y[2]));
      part_draw(t, column, row, 0, all, x, y, number, flags, to);
    }
  }
}
#endif

static inline __attribute__((always_inline)) void bin_draw(const WindowTriangle *t, uint number, uint flags, Target *to)
{
#if LANES == 16
  if (t->last_x / 4 - t->first_x / 4 > 2) {
    bin_draw_wide(t, number, flags, to);
    return;
  }
#endif
  for (uint part = 0; part < BLOCK_PARTS; part++) {
    IntL lane = INTL((int)(part * LANES)) + LANE_INDEX, x = lane & INTL(3), y = lane >> INTL(2);
    IntL edge0 = INTL(t->edge_x[0]) * x + INTL(t->edge_y[0]) * y + INTL(t->edge[0]);
    IntL edge1 = INTL(t->edge_x[1]) * x + INTL(t->edge_y[1]) * y + INTL(t->edge[1]);
    IntL edge2 = INTL(t->edge_x[2]) * x + INTL(t->edge_y[2]) * y + INTL(t->edge[2]);
    for (int row = t->first_y / 4; row <= t->last_y / 4; row++) {
      int row0 = 4 * row * t->edge_y[0], row1 = 4 * row * t->edge_y[1], row2 = 4 * row * t->edge_y[2];
      for (int column = t->first_x / 4; column <= t->last_x / 4; column++) {
        IntL all = (edge0 + INTL(row0 + 4 * column * t->edge_x[0])) | (edge1 + INTL(row1 + 4 * column * t->edge_x[1])) |
                   (edge2 + INTL(row2 + 4 * column * t->edge_x[2]));
        part_draw(t, column, row, part, all, x, y, number, flags, to);
      }
    }
  }
}

static inline float target_farthest(const Target *target, uint rows, uint parts)
{
  FloatL depth = FLOATL(0);
  for (uint row = 0; row < rows; row++)
    for (uint part = 0; part < parts; part++) depth = max_lane(depth, target->texels[row * ROW_PARTS + part]);
  return greatest_lane(depth);
}

static inline __attribute__((always_inline)) void record_draw(global const uint *record, Target *to)
{
  global const int *vertex = (global const int *)record + DEPTH_VERTEX;
  global const float *plane = (global const float *)record + DEPTH_PLANE,
                     *limits = (global const float *)record + DEPTH_LIMITS;
  const int x[3] = {vertex[0], vertex[2], vertex[4]}, y[3] = {vertex[1], vertex[3], vertex[5]};
  WindowTriangle t;
  if (window_triangle(&t, x, y, plane[0], plane[1], plane[2], limits[0], limits[1], to->window))
    bin_draw(&t, record[DEPTH_NUMBER], record[DEPTH_FLAGS], to);
}

static __attribute__((noinline)) void record_draw_clipped(global const uint *record, Target *to)
{
  global const float *n = (global const float *)record;
  ClipPolygon polygon = depth_clip(to->view, (float4)(n[0], n[1], n[6], n[7]), (float4)(n[2], n[3], n[8], n[9]),
                                   (float4)(n[4], n[5], n[10], n[11]));
  WindowTriangle t;
  for (uint i = 2; i < polygon.count; i++)
    if (window_fan_triangle(&t, &polygon, i, to->view, to->window))
      bin_draw(&t, record[DEPTH_NUMBER], record[DEPTH_FLAGS], to);
}

kernel void depth_bins(global const RasterBlock *blocks, constant RasterView *views, uint view_count, uint columns,
                       global const uint *item_starts, uint first_item, uint item_count, global const uint *records,
                       global const uint *spans, global const uint *starts, global const ushort *lists, uint begin,
                       global float *maps, global const TriangleCorners *corners, global const Float2 *uvs,
                       global const Float4 *colors, uint vertex_count, global const MaterialInfo *materials,
                       global const TextureInfo *textures, global const uchar4 *texels,
                       constant float *linear_from_byte)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  uint item = get_global_id(0), list = item % (columns * columns), number = item / (columns * columns);
  if (number >= view_count) return;
  constant RasterView *view = &views[number];
  uint2 bin = (uint2)(list % columns, list / columns), px = bin * (uint)RASTER_BIN_PX;
  uint size = view->width, row_parts = size / 4 * BLOCK_PARTS;
  global FloatL *map = (global FloatL *)(maps + view->first_texel) + px.y / 4 * row_parts + px.x / 4 * BLOCK_PARTS;
  Target to;
  to.window =
      (int4)((int)px.x, (int)px.y, min((int)(size - px.x), RASTER_BIN_PX), min((int)(size - px.y), RASTER_BIN_PX));
  to.view = view;
  to.blocks = blocks;
  to.attributes = &attributes;
  uint rows = (uint)to.window.w / 4, parts = (uint)to.window.z / 4 * BLOCK_PARTS;
  for (uint row = 0; row < rows; row++)
    for (uint part = 0; part < parts; part++)
      to.texels[row * ROW_PARTS + part] = begin ? FLOATL(1) : map[row * row_parts + part];
  ulong keys[SORT_CHUNKS];
  uint2 items = view_items(item_starts, number, first_item, item_count);
  for (uint first = items.x; first < items.y; first += SORT_CHUNKS) {
    uint count = bin_chunks(keys, spans, item_count, first, min(first + SORT_CHUNKS, items.y), bin.x, bin.y);
    for (uint i = 0; i < count; i++) {
      uint chunk = (uint)keys[i];
      if (as_float(spans[SPAN_NEAR * item_count + chunk]) > target_farthest(&to, rows, parts)) break;
      global const uint *from = records + chunk * (RASTER_CHUNK + 1) * DEPTH_WORDS;
      global const uint *start = starts + chunk * (columns * columns + 2);
      global const ushort *numbers = lists + chunk * (RASTER_CHUNK * RASTER_LARGE_BINS);
      BinLists in = bin_lists(spans, item_count, chunk, start, bin.x, bin.y);
      for (uint large = 0; large < 2; large++) {
        for (uint k = in.begin[large]; k < in.end[large]; k++) {
          global const uint *record = from + numbers[k] * DEPTH_WORDS;
          PREFETCH(from + numbers[k + PREFETCH_RECORDS] * DEPTH_WORDS);
          if (record[DEPTH_FLAGS] & DEPTH_CLIPPED)
            record_draw_clipped(record, &to);
          else
            record_draw(record, &to);
        }
      }
    }
  }
  for (uint row = 0; row < rows; row++)
    for (uint part = 0; part < parts; part++) map[row * row_parts + part] = to.texels[row * ROW_PARTS + part];
}
