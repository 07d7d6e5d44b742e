// Conservative raster of a light's maps, one work-item a bin of a view: what each texel knows of the triangles that may
// stand in the way of a ray from a point that is seen through it.
//
//   in    records, spans, starts, lists   triangles by bin (shadow_setup.cl)
//   out   texels  ShadowBlock [view][size / 4 * size / 4] (shared/shadow.h)
//
//   For each texel: how close to the light any triangle comes in it; how close one is everywhere in it that covers all
//   of it; and the numbers of the triangles between, SHADOW_NUMBERS of them at most.
//   Cost  9 to 17 ns a texel on a core; 44 bytes a texel.
//   With `begin` the map starts empty, without it what is there is added to: a scene of several passes.
//
//   From  Akenine-Moller, Aila, "Conservative and Tiled Rasterization Using a Modified Triangle Setup", 2005; Lloyd,
//         Wendt, Govindaraju, Manocha, "CC Shadow Volumes", 2004 (what is lit or dark for sure).

#include "lib/bins.cl"
#include "shared/shadow.h"

#define BLOCK_PARTS (16 / LANES)

typedef struct ListRecord {
  float edge_x[3], edge_y[3], edge_0[3];
  float near_0, near_x, near_y, near_most, near_least, slack;
  int first_x, first_y, last_x, last_y;
  uint number, hides;
} ListRecord;

static inline ListRecord list_record(global const uint *record)
{
  ListRecord r;
  global const float *edge = (global const float *)record + SURE_EDGE, *near = (global const float *)record + SURE_NEAR;
  for (uint i = 0; i < 3; i++) {
    r.edge_x[i] = edge[3 * i];
    r.edge_y[i] = edge[3 * i + 1];
    r.edge_0[i] = edge[3 * i + 2];
  }
  r.near_0 = near[0];
  r.near_x = near[1];
  r.near_y = near[2];
  r.near_most = near[3];
  r.near_least = near[4];
  r.slack = near[5];
  r.first_x = (int)(record[SURE_TEXELS] & 0xffffu);
  r.last_x = (int)(record[SURE_TEXELS] >> 16);
  r.first_y = (int)(record[SURE_TEXELS + 1] & 0xffffu);
  r.last_y = (int)(record[SURE_TEXELS + 1] >> 16);
  r.number = record[SURE_NUMBER];
  r.hides = record[SURE_HIDES];
  return r;
}

// Adds a triangle to the blocks of the bin at `px`, `row_blocks` to a row of the map.
static inline __attribute__((always_inline)) void list_draw(const ListRecord *t, global ShadowBlock *blocks,
                                                            uint row_blocks, int2 px, int2 end)
{
  FloatL zero = FLOATL(0);
  int x0 = max(t->first_x, px.x) / 4, x1 = min(t->last_x, end.x - 1) / 4;
  int y0 = max(t->first_y, px.y) / 4, y1 = min(t->last_y, end.y - 1) / 4;
  float within[3], across = (fabs(t->near_x) + fabs(t->near_y)) * (1 + 2 * SURE_PADDING);
  for (uint i = 0; i < 3; i++)
    within[i] = (fabs(t->edge_x[i]) + fabs(t->edge_y[i])) * (1 + 2 * SURE_PADDING) + 2 * t->slack;
  for (uint part = 0; part < BLOCK_PARTS; part++) {
    IntL lane = INTL((int)(part * LANES)) + LANE_INDEX;
    FloatL lane_x = LANE_CONVERT_FLOAT(lane & INTL(3)), lane_y = LANE_CONVERT_FLOAT(lane >> INTL(2));
    FloatL edge[3], near = lane_x * FLOATL(t->near_x) + lane_y * FLOATL(t->near_y) + FLOATL(t->near_0);
    for (uint i = 0; i < 3; i++)
      edge[i] = lane_x * FLOATL(t->edge_x[i]) + lane_y * FLOATL(t->edge_y[i]) + FLOATL(t->edge_0[i]);
    for (int y = y0; y <= y1; y++) {
      for (int x = x0; x <= x1; x++) {
        float block_x = (float)(4 * x), block_y = (float)(4 * y);
        FloatL e0 = edge[0] + FLOATL(t->edge_x[0] * block_x + t->edge_y[0] * block_y);
        FloatL e1 = edge[1] + FLOATL(t->edge_x[1] * block_x + t->edge_y[1] * block_y);
        FloatL e2 = edge[2] + FLOATL(t->edge_x[2] * block_x + t->edge_y[2] * block_y);
        IntL touched = (e0 >= zero) & (e1 >= zero) & (e2 >= zero);
        if (!any_lane(touched)) continue;
        global ShadowBlock *block = &blocks[(uint)y * row_blocks + (uint)x];
        FloatL plane = near + FLOATL(t->near_x * block_x + t->near_y * block_y);
        FloatL most = min_lane(plane, FLOATL(t->near_most)), covered = LANE_LOAD(block->covered, part * LANES);
        touched = touched & (most >= covered);
        if (!any_lane(touched)) continue;
        FloatL nearest = LANE_LOAD(block->nearest, part * LANES);
        LANE_STORE(touched ? max_lane(most, nearest) : nearest, block->nearest, part * LANES);
        if (t->hides) {
          FloatL least = max_lane(plane - FLOATL(across), FLOATL(t->near_least));
          IntL covers = touched & (e0 >= FLOATL(within[0])) & (e1 >= FLOATL(within[1])) & (e2 >= FLOATL(within[2]));
          LANE_STORE(covers & (least > covered) ? least : covered, block->covered, part * LANES);
        }
        UintL count = LANE_LOAD(block->count, part * LANES), number = UINTL(t->number);
        for (uint k = 0; k < SHADOW_NUMBERS; k++) {
          UintL before = LANE_LOAD(block->number[k], part * LANES);
          LANE_STORE(touched & (count == UINTL(k)) ? number : before, block->number[k], part * LANES);
        }
        LANE_STORE(touched ? count + UINTL(1) : count, block->count, part * LANES);
      }
    }
  }
}

kernel void shadow_bins(uint size, uint view_count, uint columns, uint chunk_count, global const uint *records,
                        global const uint *spans, global const uint *starts, global const ushort *lists, uint begin,
                        global ShadowBlock *texels)
{
  uint item = get_global_id(0), list = item % (columns * columns), view = item / (columns * columns);
  if (view >= view_count) return;
  uint2 bin = (uint2)(list % columns, list / columns);
  int2 px = convert_int2(bin) * RASTER_BIN_PX, end = min(px + RASTER_BIN_PX, (int2)((int)size));
  uint row_blocks = size / 4;
  texels += view * row_blocks * row_blocks;
  if (begin) {
    for (int y = px.y / 4; y < end.y / 4; y++)
      for (int x = px.x / 4; x < end.x / 4; x++) {
        global ShadowBlock *block = &texels[(uint)y * row_blocks + (uint)x];
        for (uint part = 0; part < 16; part += LANES) {
          LANE_STORE(FLOATL(-INFINITY), block->nearest, part);
          LANE_STORE(FLOATL(-INFINITY), block->covered, part);
          LANE_STORE(UINTL(0), block->count, part);
        }
      }
  }
  ulong keys[SORT_CHUNKS];
  uint all = view_count * chunk_count, last = (view + 1) * chunk_count;
  for (uint first = view * chunk_count; first < last; first += SORT_CHUNKS) {
    uint count = bin_chunks(keys, spans, all, first, min(first + SORT_CHUNKS, last), bin.x, bin.y);
    for (uint i = 0; i < count; i++) {
      uint chunk = (uint)keys[i];
      global const uint *from = records + chunk * (RASTER_CHUNK + 1) * SURE_WORDS;
      global const ushort *numbers = lists + chunk * (RASTER_CHUNK * RASTER_LARGE_BINS);
      BinLists in = bin_lists(spans, all, chunk, starts + chunk * (columns * columns + 2), bin.x, bin.y);
      for (uint large = 0; large < 2; large++) {
        for (uint k = in.begin[large]; k < in.end[large]; k++) {
          ListRecord record = list_record(from + numbers[k] * SURE_WORDS);
          list_draw(&record, texels, row_blocks, px, end);
        }
      }
    }
  }
}
