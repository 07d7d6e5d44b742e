// Raster of depth maps, one work-item a bin of a view: the least depth at each texel's centre.
//
//   in    records, spans, starts, lists   triangles by bin (depth_setup.cl)
//         blocks, and the scene's materials for MASK
//   out   maps      [view][size * size] (shared/depth_map.h)
//
//   Cost  about 10 ns a triangle and bin, 3 ns a triangle and block of 4 x 4 texels; 4 bytes a texel.
//   Coverage and depth are those of lib/map_triangle.cl. With `begin` the map starts at 1, without it what is there is
//   improved on: a scene of several passes.

#include "lib/bins.cl"
#include "lib/map_triangle.cl"

#define BLOCK_PARTS (16 / LANES)

// Where a bin's triangles are drawn, and what MASK is decided from.
typedef struct Target {
  global FloatL *map;  // of the bin; [row * row_parts + column * BLOCK_PARTS]: a block's first part
  uint row_parts;
  int4 window;  // the bin's first texel, and its size on the map
  constant RasterView *view;
  global const RasterBlock *blocks;
  const AttributeSources *attributes;
} Target;

static inline __attribute__((always_inline)) void bin_draw(const WindowTriangle *t, uint number, uint flags,
                                                           const Target *to)
{
  for (uint part = 0; part < BLOCK_PARTS; part++) {
    IntL lane = INTL((int)(part * LANES)) + LANE_INDEX, x = lane & INTL(3), y = lane >> INTL(2);
    IntL edge0 = INTL(t->edge_x[0]) * x + INTL(t->edge_y[0]) * y + INTL(t->edge[0]);
    IntL edge1 = INTL(t->edge_x[1]) * x + INTL(t->edge_y[1]) * y + INTL(t->edge[1]);
    IntL edge2 = INTL(t->edge_x[2]) * x + INTL(t->edge_y[2]) * y + INTL(t->edge[2]);
    for (int row = t->first_y / 4; row <= t->last_y / 4; row++) {
      global FloatL *blocks = to->map + (uint)row * to->row_parts + part;
      int row0 = 4 * row * t->edge_y[0], row1 = 4 * row * t->edge_y[1], row2 = 4 * row * t->edge_y[2];
      for (int column = t->first_x / 4; column <= t->last_x / 4; column++) {
        IntL all = (edge0 + INTL(row0 + 4 * column * t->edge_x[0])) | (edge1 + INTL(row1 + 4 * column * t->edge_x[1])) |
                   (edge2 + INTL(row2 + 4 * column * t->edge_x[2]));
        FloatL there = texel_depth(t, block_depth(t, 4 * column, 4 * row), x, y);
        FloatL before = blocks[column * BLOCK_PARTS];
        IntL nearer = (all >= INTL(0)) & (there < before);
#ifdef HAS_MASK
        if (flags & TRIANGLE_MASKED && any_lane(nearer)) {
          FloatL px = LANE_CONVERT_FLOAT(INTL(to->window.x + 4 * column) + x) + FLOATL(0.5f);
          FloatL py = LANE_CONVERT_FLOAT(INTL(to->window.y + 4 * row) + y) + FLOATL(0.5f);
          nearer = nearer & texels_pass(to->attributes, &to->blocks[number / RASTER_STEP], number % RASTER_STEP,
                                        to->view, nearer, px, py);
        }
#endif
        blocks[column * BLOCK_PARTS] = nearer ? there : before;
      }
    }
  }
}

static inline __attribute__((always_inline)) void record_draw(global const uint *record, const Target *to)
{
  global const int *vertex = (global const int *)record + DEPTH_VERTEX;
  global const float *plane = (global const float *)record + DEPTH_PLANE,
                     *limits = (global const float *)record + DEPTH_LIMITS;
  const int x[3] = {vertex[0], vertex[2], vertex[4]}, y[3] = {vertex[1], vertex[3], vertex[5]};
  WindowTriangle t;
  if (window_triangle(&t, x, y, plane[0], plane[1], plane[2], limits[0], limits[1], to->window))
    bin_draw(&t, record[DEPTH_NUMBER], record[DEPTH_FLAGS], to);
}

static __attribute__((noinline)) void record_draw_clipped(global const uint *record, const Target *to)
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
                       uint chunk_count, global const uint *records, global const uint *spans,
                       global const uint *starts, global const ushort *lists, uint begin, global float *maps,
                       global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors,
                       uint vertex_count, global const MaterialInfo *materials, global const TextureInfo *textures,
                       global const uchar4 *texels, constant float *linear_from_byte)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  uint item = get_global_id(0), list = item % (columns * columns), number = item / (columns * columns);
  if (number >= view_count) return;
  constant RasterView *view = &views[number];
  uint2 bin = (uint2)(list % columns, list / columns), px = bin * (uint)RASTER_BIN_PX;
  uint size = view->width, row_parts = size / 4 * BLOCK_PARTS;
  int4 window =
      (int4)((int)px.x, (int)px.y, min((int)(size - px.x), RASTER_BIN_PX), min((int)(size - px.y), RASTER_BIN_PX));
  Target to = {(global FloatL *)(maps + number * size * size) + px.y / 4 * row_parts + px.x / 4 * BLOCK_PARTS,
               row_parts,
               window,
               view,
               blocks,
               &attributes};
  if (begin) {
    for (uint row = 0; row < (uint)window.w / 4; row++)
      for (uint part = 0; part < (uint)window.z / 4 * BLOCK_PARTS; part++) to.map[row * row_parts + part] = FLOATL(1);
  }
  ulong keys[SORT_CHUNKS];
  uint all = view_count * chunk_count, last = (number + 1) * chunk_count;
  for (uint first = number * chunk_count; first < last; first += SORT_CHUNKS) {
    uint count = bin_chunks(keys, spans, all, first, min(first + SORT_CHUNKS, last), bin.x, bin.y);
    for (uint i = 0; i < count; i++) {
      uint chunk = (uint)keys[i];
      global const uint *from = records + chunk * (RASTER_CHUNK + 1) * DEPTH_WORDS;
      global const uint *start = starts + chunk * (columns * columns + 2);
      global const ushort *numbers = lists + chunk * (RASTER_CHUNK * RASTER_LARGE_BINS);
      BinLists in = bin_lists(spans, all, chunk, start, bin.x, bin.y);
      for (uint large = 0; large < 2; large++) {
        for (uint k = in.begin[large]; k < in.end[large]; k++) {
          global const uint *record = from + numbers[k] * DEPTH_WORDS;
          if (record[DEPTH_FLAGS] & DEPTH_CLIPPED)
            record_draw_clipped(record, &to);
          else
            record_draw(record, &to);
        }
      }
    }
  }
}
