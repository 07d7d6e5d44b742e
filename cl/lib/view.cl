// Rows of a view (shared/view.h) applied to positions, and boxes against the planes that rows stand for.

#include "lib/lanes.cl"
#include "shared/raster.h"
#include "shared/view.h"

static inline FloatL row_dot(Float4 row, Vec3L a)
{
  return FLOATL(row.x) * a.x + FLOATL(row.y) * a.y + FLOATL(row.z) * a.z + FLOATL(row.w);
}

// The same for one position, and with the same bits.
static inline float row_dot_one(Float4 row, const float a[3])
{
  return row.x * a[0] + row.y * a[1] + row.z * a[2] + row.w;
}

// p + scale q
static inline Float4 row_sum(Float4 p, float scale, Float4 q)
{
  Float4 sum = {p.x + scale * q.x, p.y + scale * q.y, p.z + scale * q.z, p.w + scale * q.w};
  return sum;
}

static inline Float4 row_scaled(Float4 p, float scale)
{
  Float4 scaled = {scale * p.x, scale * p.y, scale * p.z, scale * p.w};
  return scaled;
}

#define SIGHT_PLANES 6

// Could a point of the box have row >= 0 for every row of `planes`, rounding included? All are asked: what an early no
// would save a GPU loses by waiting for each plane's numbers.
static inline bool bounds_meet(global const RasterBounds *bounds, constant RasterView *view,
                               const Float4 planes[SIGHT_PLANES])
{
  bool meets = true;
  float center[3], half_size[3], far_off = 0;
  const float origin[3] = {view->origin.x, view->origin.y, view->origin.z};
  for (uint axis = 0; axis < 3; axis++) {
    center[axis] = 0.5f * (bounds->low[axis] + bounds->high[axis]) - origin[axis];
    half_size[axis] = 0.5f * (bounds->high[axis] - bounds->low[axis]);
    far_off += fabs(center[axis]) + half_size[axis];
  }
#pragma unroll
  for (uint i = 0; i < SIGHT_PLANES; i++) {
    Float4 p = planes[i];
    float reach = fabs(p.x) * half_size[0] + fabs(p.y) * half_size[1] + fabs(p.z) * half_size[2];
    float size = fabs(p.x) + fabs(p.y) + fabs(p.z);
    float slack = 4 * RASTER_ROUNDING * (size * far_off + fabs(p.w)) + size * view->error_m;
    meets = meets & !(row_dot_one(p, center) + reach < -slack);
  }
  return meets;
}

// Could anything within the bounds be in the picture's rows [low_row, high_row)?
static inline bool bounds_visible(global const RasterBounds *bounds, constant RasterView *view, float low_row,
                                  float high_row)
{
  Float4 near = view->depth, far = row_scaled(view->depth, -1);
  near.w -= view->near;
  far.w += view->far;
  Float4 planes[SIGHT_PLANES] = {view->x,
                                 row_sum(row_scaled(view->x, -1), (float)view->width, view->w),
                                 row_sum(view->y, -low_row, view->w),
                                 row_sum(row_scaled(view->y, -1), high_row, view->w),
                                 near,
                                 far};
  return bounds_meet(bounds, view, planes);
}

// Could anything within the bounds be on the map?
static inline bool bounds_on_map(global const RasterBounds *bounds, constant RasterView *view)
{
  Float4 before = view->w;  // in parallel projection it is 1
  before.w -= view->parallel ? 0 : view->least_w;
  Float4 planes[SIGHT_PLANES] = {view->x,
                                 row_sum(row_scaled(view->x, -1), (float)view->width, view->w),
                                 view->y,
                                 row_sum(row_scaled(view->y, -1), (float)view->height, view->w),
                                 row_sum(row_scaled(view->depth, -1), 1, view->w),
                                 before};
  return bounds_meet(bounds, view, planes);
}

// Asks for a block that will be set up soon: this many after the one at hand.
#define PREFETCH_BLOCKS 3

static inline void block_prefetch(global const RasterBlock *block)
{
  for (uint i = 0; i < sizeof(RasterBlock); i += 64) PREFETCH((global const char *)block + i);
}

// Vertices of LANES triangles of a chunk, from number `first` on.
static inline void corners_load(Vec3L out[3], global const RasterBlock *blocks, uint first)
{
  global const RasterBlock *block = &blocks[first / RASTER_STEP];
  uint slot = first % RASTER_STEP;
  for (uint i = 0; i < 3; i++)
    out[i] = vec3l(LANE_LOAD(block->vertex[i][0], slot), LANE_LOAD(block->vertex[i][1], slot),
                   LANE_LOAD(block->vertex[i][2], slot));
}

// The same, relative to the view's origin.
static inline void corners_relative(Vec3L out[3], const Vec3L corners[3], constant RasterView *view)
{
  Vec3L origin = vec3l(FLOATL(view->origin.x), FLOATL(view->origin.y), FLOATL(view->origin.z));
  for (uint i = 0; i < 3; i++) out[i] = sub3(corners[i], origin);
}

static inline void triangles_load(Vec3L corners[3], Vec3L relative[3], global const RasterBlock *blocks, uint first,
                                  constant RasterView *view)
{
  corners_load(corners, blocks, first);
  corners_relative(relative, corners, view);
}

static inline FloatL min3_lane(FloatL a, FloatL b, FloatL c) { return min_lane(min_lane(a, b), c); }
static inline FloatL max3_lane(FloatL a, FloatL b, FloatL c) { return max_lane(max_lane(a, b), c); }
