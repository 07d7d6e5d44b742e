// Triangles against single samples of a picture, for raster that keeps the least key of each slot of a wave: bits of t,
// then the triangle's id. Where a triangle may be met is told by widened edges (lib/visible.cl), whether it is by the
// function that rays use. LANES is 1.

#include "lib/hit.cl"
#include "lib/key_hit.cl"
#include "lib/visible.cl"

typedef struct Wave {
  uint first_tile, tile_count, first_sample, sample_count;
} Wave;

// What a sample's test takes besides the triangle.
typedef struct Scope {
  constant CameraInfo *camera;
  uint2 grid;      // the picture's tiles
  uint first_row;  // of them: the view's
  constant Float2 *offsets;
  Wave wave;
  float t_min;
  const AttributeSources *attributes;
} Scope;

static inline Triangle triangle_load(global const RasterBlock *blocks, uint number)
{
  global const RasterBlock *block = &blocks[number / RASTER_STEP];
  uint slot = number % RASTER_STEP;
  Triangle t;
  for (uint i = 0; i < 3; i++)
    t.corner[i] = (float3)(block->vertex[i][0][slot], block->vertex[i][1][slot], block->vertex[i][2][slot]);
  t.id = block->id[slot];
  t.flags = block->flags[slot];
  return t;
}

static inline void triangle_relative(Vec3L out[3], const Triangle *t, constant RasterView *view)
{
  for (uint i = 0; i < 3; i++) {
    float3 relative = t->corner[i] - vload3(0, &view->origin.x);
    out[i] = vec3l(relative.x, relative.y, relative.z);
  }
}

static inline void sample_hold(TriangleHit *hit, const CameraRay *ray, const Triangle *t, float t_min)
{
  const SlabAxis slab[3] = {slab_axis(ray->origin.x, ray->direction.x), slab_axis(ray->origin.y, ray->direction.y),
                            slab_axis(ray->origin.z, ray->direction.z)};
  float vertex[3][3];
  for (uint i = 0; i < 3; i++) {
    vertex[i][0] = t->corner[i].x;
    vertex[i][1] = t->corner[i].y;
    vertex[i][2] = t->corner[i].z;
  }
  hit_hold(hit, t_min, slab, vertex[0], vertex[1], vertex[2]);
}

// The key of a triangle at a sample; all ones where it is not seen.
static inline ulong sample_key(const Triangle *t, TurnedTriangle *turned, const Scope *scope, const CameraRay *ray)
{
  ShearedRay sheared;
  TriangleEdges edges = sample_edge_functions(&sheared, ray, scope->camera, t, turned);
  TriangleHit hit = triangle_distance(&edges, &sheared);
  IntL positive_kz = component3(ray->direction, turned->kz) > 0;
  float far_m = scope->camera->far_m;
  if (!hit_is_closest(&hit, 1, scope->t_min, far_m, HIT_NONE, t->id, t->flags, positive_kz)) return ULONG_MAX;
  hit.doubtful = triangle_doubtful(&edges);
  // Where t is not in doubt it is above its error.
  if (hit.doubtful || t->flags & TRIANGLE_MASKED) {
    triangle_complete(&hit, &edges, &sheared);
    if (hit.doubtful) sample_hold(&hit, ray, t, scope->t_min);
    if (!hit_is_closest(&hit, 1, scope->t_min, far_m, HIT_NONE, t->id, t->flags, positive_kz)) return ULONG_MAX;
    if (!hit_counts(&hit, 1, t->id, t->flags, scope->attributes)) return ULONG_MAX;
  }
  return (ulong)as_uint(hit.t) << 32 | t->id;
}

// Slot of a pixel and sample of the wave; HIT_NONE where the wave does not hold it.
static inline uint wave_slot(const Scope *scope, uint x, uint y, uint sample)
{
  uint2 at = (uint2)(x, y) / (uint)TILE_SIZE + (uint2)(0, scope->first_row);
  uint tile = tile_number(at, scope->grid), first = scope->wave.first_tile;
  if (tile < first || tile >= first + scope->wave.tile_count) return HIT_NONE;
  return (tile - first + sample * scope->wave.tile_count) * TILE_PIXELS + tile_slot(x, y);
}

// Turns to another view.
static inline void scope_turn(Scope *scope, constant CameraInfo *cameras, uint view_count, uint view)
{
  scope->camera = &cameras[view];
  scope->grid = views_tiles(cameras, view_count);
  scope->first_row = view * camera_tiles(cameras).y;
}

// Where a triangle may be met: what these let in, triangle_intersect decides.
typedef struct SampleEdges {
  float edge_x[3], edge_y[3], edge_0[3];  // >= 0 (or NaN) at a sample that may be met
  uint nearest;                           // bits of a depth that no hit is before
} SampleEdges;

// A hit is not before the triangle's bounding box, not even where its t is in doubt (lib/hit.cl).
static inline uint nearest_depth(constant RasterView *view, const Vec3L a[3])
{
  Vec3L low, high;
  low.x = min3_lane(a[0].x, a[1].x, a[2].x), high.x = max3_lane(a[0].x, a[1].x, a[2].x);
  low.y = min3_lane(a[0].y, a[1].y, a[2].y), high.y = max3_lane(a[0].y, a[1].y, a[2].y);
  low.z = min3_lane(a[0].z, a[1].z, a[2].z), high.z = max3_lane(a[0].z, a[1].z, a[2].z);
  Float4 row = view->depth;
  float nearest = min(row.x * low.x, row.x * high.x) + min(row.y * low.y, row.y * high.y) +
                  min(row.z * low.z, row.z * high.z) + row.w;
  float far_off = max(fabs(low.x), fabs(high.x)) + max(fabs(low.y), fabs(high.y)) + max(fabs(low.z), fabs(high.z));
  nearest -= 4 * RASTER_ROUNDING * far_off + view->error_m;
  return nearest > 0 ? as_uint(nearest) : 0;  // 0 for NaN
}

static inline SampleEdges sample_edges(const VisibleTriangle *t, constant RasterView *view, const Vec3L a[3])
{
  SampleEdges out;
  for (uint i = 0; i < 3; i++) {
    out.edge_x[i] = t->edge_x[i];
    out.edge_y[i] = t->edge_y[i];
    out.edge_0[i] = t->edge_0[i] - 1.5f * (fabs(t->edge_x[i]) + t->edge_x[i] + fabs(t->edge_y[i]) + t->edge_y[i]);
  }
  out.nearest = nearest_depth(view, a);
  return out;
}

// An edge function at y, then at x. NaN is not below 0.
static inline float edge_row(const SampleEdges *e, uint i, float y)
{
  return MULTIPLY_ADD(e->edge_y[i], y, e->edge_0[i]);
}
static inline bool edges_meet(const SampleEdges *e, const float row[3], float x)
{
  return !(fmin(fmin(MULTIPLY_ADD(e->edge_x[0], x, row[0]), MULTIPLY_ADD(e->edge_x[1], x, row[1])),
                MULTIPLY_ADD(e->edge_x[2], x, row[2])) < 0);
}

// Could a sample of the box's pixels be met?
static inline bool edges_meet_box(const SampleEdges *e, int4 bounds)
{
  for (uint i = 0; i < 3; i++) {
    float x = (float)(e->edge_x[i] > 0 ? bounds.z + 1 : bounds.x);
    float y = (float)(e->edge_y[i] > 0 ? bounds.w + 1 : bounds.y);
    if (MULTIPLY_ADD(e->edge_x[i], x, edge_row(e, i, y)) < 0) return false;
  }
  return true;
}

// Draws a sample of a slot of the wave that was at `depth`.
static inline void slot_draw(const Triangle *t, TurnedTriangle *turned, const Scope *scope, int2 at, uint sample,
                             uint slot, uint depth, global ulong *keys)
{
  CameraRay ray = camera_ray(scope->camera, (uint)at.x, (uint)at.y, scope->offsets[scope->wave.first_sample + sample]);
  ulong key = sample_key(t, turned, scope, &ray);
  if (key != ULONG_MAX && (uint)(key >> 32) <= depth) atom_min(&keys[slot], key);
}

// The upper half of a key is its second word: devices are little-endian. It is looked at early, and has come when the
// intersection is done.
static inline void sample_draw(const Triangle *t, TurnedTriangle *turned, const Scope *scope, int2 at, uint sample,
                               global ulong *keys)
{
  uint slot = wave_slot(scope, (uint)at.x, (uint)at.y, sample);
  if (slot == HIT_NONE) return;
  slot_draw(t, turned, scope, at, sample, slot, depth_now((global const uint *)&keys[slot] + 1), keys);
}

// Moves `at` on, row by row, to the next sample that may be met.
static inline bool sample_next(const SampleEdges *edges, const Scope *scope, uint sample, int4 bounds, int2 *at)
{
  Float2 offset = scope->offsets[scope->wave.first_sample + sample];
  for (; at->y <= bounds.w; at->y++, at->x = bounds.x) {
    float along = (float)at->x + offset.x, down = (float)at->y + offset.y;
    const float row[3] = {edge_row(edges, 0, down), edge_row(edges, 1, down), edge_row(edges, 2, down)};
    for (; at->x <= bounds.z; at->x++, along += 1)
      if (edges_meet(edges, row, along)) return true;
  }
  return false;
}

// Draws the triangle's samples of a box.
static inline void box_draw(const Triangle *t, const SampleEdges *edges, const Scope *scope, int4 bounds,
                            global ulong *keys)
{
  TurnedTriangle turned = {.kz = KZ_NONE};
  for (uint sample = 0; sample < scope->wave.sample_count; sample++) {
    int2 at = bounds.xy;
    for (; sample_next(edges, scope, sample, bounds, &at); at.x++) sample_draw(t, &turned, scope, at, sample, keys);
  }
}
