// The samples of a bin by blocks of 4 x 4: their rays, and what these have met so far. They are a work-item's own,
// which draws a bin with them (raster/visibility_bins.cl); at the end the hits go to the stream.

#include "lib/camera_ray.cl"
#include "lib/hit.cl"
#include "shared/raster.h"

#define BIN_SIDE (RASTER_BIN_PX / 4)  // blocks along the side of a bin
#define BIN_BLOCKS (BIN_SIDE * BIN_SIDE)
#define BLOCK_PARTS (16 / LANES)

#define AXIS_MIXED 3

// A block of 4 x 4 samples: its rays and what they have met. In perspective a, b, c are the shear of a block whose rays
// share their dominant axis, and the direction where they do not; in parallel projection they are the origin.
typedef struct Block {
  FloatL a[BLOCK_PARTS], b[BLOCK_PARTS], c[BLOCK_PARTS];
  FloatL t[BLOCK_PARTS], u[BLOCK_PARTS], v[BLOCK_PARTS];
  UintL ids[BLOCK_PARTS];
} Block;

// The samples of a bin, blocks row by row.
typedef struct BinSamples {
  Block blocks[BIN_BLOCKS];
  FloatL farthest[BIN_SIDE][BLOCK_PARTS];  // t of each block, [row][column]; -1 outside the wave
  uint target[BIN_BLOCKS];                 // where the first part of each block goes
  uchar axis[BIN_BLOCKS];
  uint inside[BIN_SIDE];   // blocks of a row that belong to the wave, a bit each
  uint changed[BIN_SIDE];  // those that were drawn into since they were measured
  uint shared_axis;        // of all blocks, else AXIS_MIXED
  Vec3L parallel;          // the direction of all rays in parallel projection
  bool is_parallel;
  constant CameraInfo *camera;
  Float2 offset;
  uint2 px;  // the bin's first pixel, in its view
} BinSamples;

// Hits by LANES slots: streams are aligned to whole vectors.
typedef struct Target {
  global FloatL *t, *u, *v;
  global UintL *ids;
  float t_min, origin[3];  // of the triangles' vertices as rays take them
  global const RasterBlock *triangles;
  const AttributeSources *attributes;
  uint tests, covered;
} Target;

static inline Vec3L no_origin(void) { return vec3l(FLOATL(0), FLOATL(0), FLOATL(0)); }

static inline void block_make(BinSamples *bin, uint block, constant CameraInfo *camera, Float2 offset, uint2 px,
                              bool begin, const Target *from)
{
  Block *out = &bin->blocks[block];
  for (uint part = 0; part < BLOCK_PARTS; part++) {
    IntL lane = INTL((int)(part * LANES)) + LANE_INDEX;
    UintL x = UINTL(px.x) + LANE_AS_UINT(lane & INTL(3)), y = UINTL(px.y) + LANE_AS_UINT(lane >> INTL(2));
    CameraRay ray = camera_ray(camera, x, y, offset);
    Vec3L kept = bin->is_parallel ? ray.origin : ray.direction;
    UintL axis = dominant_axis(ray.direction);
    uint kz = LANE_UINT(axis, 0), at = bin->target[block] + part;
    bool shared = !any_lane(axis != UINTL(kz)) && (part == 0 || kz == bin->axis[block]);
    bin->axis[block] = shared ? kz : AXIS_MIXED;
    out->a[part] = kept.x;
    out->b[part] = kept.y;
    out->c[part] = kept.z;
    UintL id = UINTL(HIT_NONE);
    FloatL t = camera_ray_end(camera, x, y), zero = FLOATL(0), u = zero, v = zero;
    if (!begin) {
      id = from->ids[at];
      IntL hit = id != UINTL(HIT_NONE);
      t = hit ? from->t[at] : t;
      u = hit ? from->u[at] : u;
      v = hit ? from->v[at] : v;
    }
    out->t[part] = t;
    out->u[part] = u;
    out->v[part] = v;
    out->ids[part] = id;
  }
  for (uint part = 0; part < BLOCK_PARTS && !bin->is_parallel && bin->axis[block] != AXIS_MIXED; part++) {
    ShearedRay ray = shear_ray(no_origin(), vec3l(out->a[part], out->b[part], out->c[part]), bin->axis[block]);
    out->a[part] = ray.shear_x;
    out->b[part] = ray.shear_y;
    out->c[part] = ray.shear_z;
  }
}

// Takes down how far the farthest sample of a block is: when the bin begins and for those that a chunk has changed.
static inline void block_measure(BinSamples *bin, uint block)
{
  FloatL t = bin->blocks[block].t[0];
  for (uint part = 1; part < BLOCK_PARTS; part++) t = max_lane(t, bin->blocks[block].t[part]);
  ((float *)bin->farthest)[block] = greatest_lane(t);
}

static inline float bin_farthest(BinSamples *bin)
{
  for (uint row = 0; row < BIN_SIDE; row++) {
    for (; bin->changed[row]; bin->changed[row] &= bin->changed[row] - 1)
      block_measure(bin, row * BIN_SIDE + lowest_bit(bin->changed[row]));
  }

  const FloatL *rows = &bin->farthest[0][0];
  FloatL t = rows[0];
  for (uint i = 1; i < BIN_SIDE * BLOCK_PARTS; i++) t = max_lane(t, rows[i]);
  return greatest_lane(t);
}

// `grid`: the picture's tiles, of which the view has those from row `first_row` on. `empty`: nothing will be drawn, and
// what slots hold then is written at once.
static inline void bin_make(BinSamples *bin, constant CameraInfo *camera, Float2 offset, uint2 bin_px, uint2 grid,
                            uint first_row, uint first_tile, uint tile_count, uint sample, bool begin, bool empty,
                            const Target *from)
{
  bool any = false;
  uint2 view_grid = camera_tiles(camera);
  bin->camera = camera;
  bin->offset = offset;
  bin->px = bin_px;
  bin->is_parallel = camera->orthographic;
  bin->parallel = BROADCAST3(camera->forward);
  bin->shared_axis = AXIS_MIXED;
  for (uint row = 0; row < BIN_SIDE; row++) {
    bin->inside[row] = bin->changed[row] = 0;
    for (uint part = 0; part < BLOCK_PARTS; part++) bin->farthest[row][part] = FLOATL(-1);
    for (uint column = 0; column < BIN_SIDE; column++) {
      uint block = row * BIN_SIDE + column;
      uint2 px = bin_px + (uint2)(column, row) * 4u, at = px / (uint)TILE_SIZE;
      if (at.x >= view_grid.x || at.y >= view_grid.y) continue;
      uint tile = tile_number(at + (uint2)(0, first_row), grid), within = (row & 1) * 32 + (column & 1) * 16;
      if (tile < first_tile || tile >= first_tile + tile_count) continue;
      bin->inside[row] |= 1u << column;
      bin->target[block] = ((tile - first_tile + sample * tile_count) * TILE_PIXELS + within) / LANES;
      if (empty) {
        for (uint part = 0; part < BLOCK_PARTS; part++) from->ids[bin->target[block] + part] = UINTL(HIT_NONE);
        continue;
      }
      block_make(bin, block, camera, offset, px, begin, from);
      block_measure(bin, block);
      bin->shared_axis = !any || bin->axis[block] == bin->shared_axis ? bin->axis[block] : AXIS_MIXED;
      any = true;
    }
  }
}

// What is undefined is not written: half of the blocks of a wide view see nothing.
static inline void bin_store(const BinSamples *bin, const Target *to)
{
  for (uint block = 0; block < BIN_BLOCKS; block++) {
    if (!(bin->inside[block / BIN_SIDE] >> block % BIN_SIDE & 1)) continue;
    const Block *from = &bin->blocks[block];
    for (uint part = 0; part < BLOCK_PARTS; part++) {
      uint at = bin->target[block] + part;
      to->ids[at] = from->ids[part];
      if (!any_lane(from->ids[part] != UINTL(HIT_NONE))) continue;
      to->t[at] = from->t[part];
      to->u[at] = from->u[part];
      to->v[at] = from->v[part];
    }
  }
}
