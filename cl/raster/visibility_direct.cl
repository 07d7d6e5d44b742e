// Raster of camera visibility on a GPU, triangle by triangle into a buffer of keys: the least (depth, id) of each slot
// of the wave stays.
//
//   in    blocks, views       the scene's triangles and the cameras' views of them
//         items               chunks and views, of which [first_item, first_item + item_count) are drawn
//         cameras, offsets    as the ray generator takes them
//         hidden              ranges of triangle ids that are not there, [hidden_count]
//         wave                first_tile, tile_count, first_sample, sample_count
//   out   keys                [slots]: bits of t << 32 | id; all ones before the first launch
//         hits, hit_ids       the hit stream of the wave: the bits that trace_closest gives (visibility_resolve)
//
//   visibility_small   a work-item a triangle of an item: draws it if its box is small, else lists it
//   visibility_split   a work-item a tile of a large box: lists it if the triangle may be met there
//   visibility_tiles   RASTER_TEAM work-items a listed tile
//   visibility_resolve a work-item a slot: t, u and v of the triangle that won
//
//   Cost  44 bytes a triangle of the chunks in view, three sums a triangle and sample of its box, an intersection where
//         they leave it open, 8 to 24 bytes a slot.
//   Needs cl_khr_int64_base_atomics and cl_khr_int64_extended_atomics; without them visibility_bins.cl does the same.
//   LANES is 1. The list holds every triangle of a pass: nothing overflows. Its order varies, the least key does not.
//
//   From  Kenzel, Kerbl, Schmalstieg, Steinberger, "A High-Performance Software Graphics Pipeline Architecture for the
//         GPU", 2018 (size classes); Karis, Stubbe, Wihlidal, "Nanite: A Deep Dive", 2021 (atomic depth and id).

#pragma OPENCL EXTENSION cl_khr_int64_extended_atomics : enable

#include "lib/boxes.cl"
#include "lib/camera_ray.cl"
#include "lib/hit.cl"
#include "lib/visible.cl"
#include "raster/chunks_seen.cl"
#include "raster/triangle_pack.cl"

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

typedef struct Triangle {
  float3 corner[3];  // world space
  uint id, flags;
} Triangle;

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

typedef struct SampleRay {
  CameraRay ray;
  ShearedRay sheared;
  uint kz;
} SampleRay;

static inline SampleRay sample_ray(constant CameraInfo *camera, uint x, uint y, Float2 offset)
{
  SampleRay s;
  s.ray = camera_ray(camera, x, y, offset);
  s.kz = dominant_axis(s.ray.direction);
  s.sheared = shear_ray(s.ray.origin, s.ray.direction, s.kz);
  return s;
}

static inline TriangleHit sample_intersect(const SampleRay *s, const Triangle *t)
{
  float3 a = t->corner[0], b = t->corner[1], c = t->corner[2];
  if (s->kz == 0) a = a.yzx, b = b.yzx, c = c.yzx;
  if (s->kz == 1) a = a.zxy, b = b.zxy, c = c.zxy;
  return triangle_intersect(&s->sheared, a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z);
}

static inline void sample_hold(TriangleHit *hit, const SampleRay *s, const Triangle *t, float t_min)
{
  const SlabAxis slab[3] = {slab_axis(s->ray.origin.x, s->ray.direction.x),
                            slab_axis(s->ray.origin.y, s->ray.direction.y),
                            slab_axis(s->ray.origin.z, s->ray.direction.z)};
  float vertex[3][3];
  for (uint i = 0; i < 3; i++) {
    vertex[i][0] = t->corner[i].x;
    vertex[i][1] = t->corner[i].y;
    vertex[i][2] = t->corner[i].z;
  }
  hit_hold(hit, t_min, slab, vertex[0], vertex[1], vertex[2]);
}

// The key of a triangle at a sample; all ones where it is not seen.
static inline ulong sample_key(const Triangle *t, const Scope *scope, const SampleRay *s)
{
  TriangleHit hit = sample_intersect(s, t);
  IntL positive_kz = component3(s->ray.direction, s->kz) > 0;
  float far_m = scope->camera->far_m;
  if (!hit_is_closest(&hit, 1, scope->t_min, far_m, HIT_NONE, t->id, t->flags, positive_kz)) return ULONG_MAX;
  if (hit.doubtful) {
    sample_hold(&hit, s, t, scope->t_min);
    if (!hit_is_closest(&hit, 1, scope->t_min, far_m, HIT_NONE, t->id, t->flags, positive_kz)) return ULONG_MAX;
  }
  // Where t is not in doubt it is above its error.
  bool asks = hit.doubtful || t->flags & TRIANGLE_MASKED;
  if (asks && !hit_counts(&hit, 1, t->id, t->flags, scope->attributes)) return ULONG_MAX;
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

// The upper half of a key is its second word: devices are little-endian. It is looked at early, and has come when the
// intersection is done.
static inline void sample_draw(const Triangle *t, const Scope *scope, int x, int y, uint sample, Float2 offset,
                               global ulong *keys)
{
  uint slot = wave_slot(scope, (uint)x, (uint)y, sample);
  if (slot == HIT_NONE) return;
  uint depth = depth_now((global const uint *)&keys[slot] + 1);
  SampleRay ray = sample_ray(scope->camera, (uint)x, (uint)y, offset);
  ulong key = sample_key(t, scope, &ray);
  if (key != ULONG_MAX && (uint)(key >> 32) <= depth) atom_min(&keys[slot], key);
}

// Moves (x, y) on, row by row, to the next sample that may be met.
static inline bool sample_next(const SampleEdges *edges, Float2 offset, int4 bounds, int *x, int *y)
{
  for (; *y <= bounds.w; (*y)++, *x = bounds.x) {
    float along = (float)*x + offset.x, down = (float)*y + offset.y;
    const float row[3] = {edge_row(edges, 0, down), edge_row(edges, 1, down), edge_row(edges, 2, down)};
    for (; *x <= bounds.z; (*x)++, along += 1)
      if (edges_meet(edges, row, along)) return true;
  }
  return false;
}

// Draws the triangle's samples of a box. The search for the next one that may be met is a loop of its own, so that the
// work-items of a warp intersect together.
static inline void box_draw(const Triangle *t, const SampleEdges *edges, const Scope *scope, int4 bounds,
                            global ulong *keys)
{
  for (uint sample = 0; sample < scope->wave.sample_count; sample++) {
    Float2 offset = scope->offsets[scope->wave.first_sample + sample];
    int x = bounds.x, y = bounds.y;
    for (; sample_next(edges, offset, bounds, &x, &y); x++) sample_draw(t, scope, x, y, sample, offset, keys);
  }
}

// A tile in the list: first and last pixel, id and flags, vertices, edges, nearest depth, view.
static inline void tile_store(global uint4 *to, RasterBox box, const Triangle *t, const SampleEdges *e)
{
  float3 a = t->corner[0], b = t->corner[1], c = t->corner[2];
  to[0] = (uint4)(box.x, box.y, t->id, t->flags);
  to[1] = as_uint4((float4)(a.x, a.y, a.z, b.x));
  to[2] = as_uint4((float4)(b.y, b.z, c.x, c.y));
  to[3] = as_uint4((float4)(c.z, e->edge_0[0], e->edge_0[1], e->edge_0[2]));
  to[4] = as_uint4((float4)(e->edge_x[0], e->edge_x[1], e->edge_x[2], e->edge_y[0]));
  to[5] = (uint4)(as_uint(e->edge_y[1]), as_uint(e->edge_y[2]), e->nearest, box.view);
}

static inline RasterBox tile_load(Triangle *t, SampleEdges *e, global const uint4 *from)
{
  uint4 head = from[0];
  float4 v1 = as_float4(from[1]), v2 = as_float4(from[2]), v3 = as_float4(from[3]), v4 = as_float4(from[4]);
  uint4 tail = from[5];
  RasterBox box = {0, tail.w, head.x, head.y};
  t->id = head.z;
  t->flags = head.w;
  t->corner[0] = v1.xyz;
  t->corner[1] = (float3)(v1.w, v2.x, v2.y);
  t->corner[2] = (float3)(v2.z, v2.w, v3.x);
  e->edge_0[0] = v3.y, e->edge_0[1] = v3.z, e->edge_0[2] = v3.w;
  e->edge_x[0] = v4.x, e->edge_x[1] = v4.y, e->edge_x[2] = v4.z;
  e->edge_y[0] = v4.w, e->edge_y[1] = as_float(tail.x), e->edge_y[2] = as_float(tail.y);
  e->nearest = tail.z;
  return box;
}

// Bits of the depth that a sample is at; 0 outside the wave.
static inline uint sample_depth(const Scope *scope, int2 first, uint bit, uint sample, global const ulong *keys)
{
  int2 at = first + piece_offset(bit);
  uint slot = wave_slot(scope, (uint)at.x, (uint)at.y, sample);
  return slot == HIT_NONE ? 0 : depth_now((global const uint *)&keys[slot] + 1);
}

// What a member of a team draws of its share of a tile. Pixels before the bounds are no less within the edges for that.
static inline void tile_draw(global const uint4 *from, TileShare share, Scope *scope, constant CameraInfo *cameras,
                             uint view_count, global ulong *keys)
{
  Triangle t;
  SampleEdges edges;
  RasterBox box = tile_load(&t, &edges, from);
  int4 bounds = box_bounds(box);
  scope_turn(scope, cameras, view_count, box.view);
  int2 start = piece_start(bounds.xy), first = start + piece_pixel(), last = (bounds.zw - start) / (int2)(8, 4);
  uint within = pieces_within(first, bounds.zw) & share_bits(share);
  for (uint sample = 0; sample < scope->wave.sample_count; sample++) {
    Float2 offset = scope->offsets[scope->wave.first_sample + sample];
    uint met = 0;
    for (int y = share.first_row; y <= min(last.y, share.end_row - 1); y++) {
      float down = (float)(first.y + 4 * y) + offset.y;
      float along = (float)first.x + offset.x;
      const float row[3] = {edge_row(&edges, 0, down), edge_row(&edges, 1, down), edge_row(&edges, 2, down)};
      for (int x = 0; x <= last.x; x++, along += 8) met |= (uint)edges_meet(&edges, row, along) << (4 * y + x);
    }
    met &= within;
    for (uint bits = met; bits;) {
      uint4 at = bits_take(&bits);
      uint4 now =
          (uint4)(sample_depth(scope, first, at.x, sample, keys), sample_depth(scope, first, at.y, sample, keys),
                  sample_depth(scope, first, at.z, sample, keys), sample_depth(scope, first, at.w, sample, keys));
      uint hidden = (uint)(edges.nearest > now.x) << at.x | (uint)(edges.nearest > now.y) << at.y |
                    (uint)(edges.nearest > now.z) << at.z | (uint)(edges.nearest > now.w) << at.w;
      met &= ~hidden;
    }
    for (; met; met &= met - 1) {
      int2 at = first + piece_offset(lowest_bit(met));
      sample_draw(&t, scope, at.x, at.y, sample, offset, keys);
    }
  }
}

// Pixels that may be met, within the picture's rows [first_row, end_row); false where there is none.
static inline bool visible_box(int4 *out, const VisibleTriangle *t, constant RasterView *view, uint first_row,
                               uint end_row, constant Float2 *offsets, uint sample_count)
{
  if (t->culled || !visible_samples(t, view, first_row, end_row, offsets, sample_count)) return false;
  float2 low_offset = (float2)(0, 0), high_offset = (float2)(1, 1);
  if (sample_count == 1) low_offset = high_offset = (float2)(offsets->x, offsets->y);
  int x0 = max((int)ceil(max(t->low_x, -1.0f) - high_offset.x), 0),
      y0 = max((int)ceil(max(t->low_y, -1.0f) - high_offset.y), (int)first_row);
  int x1 = (int)floor(min(t->high_x, (float)view->width) - low_offset.x),
      y1 = (int)floor(min(t->high_y, (float)end_row) - low_offset.y);
  x1 = min(x1, (int)view->width - 1);
  y1 = min(y1, (int)end_row - 1);
  *out = (int4)(x0, y0, x1, y1);
  return x0 <= x1 && y0 <= y1;
}

kernel void visibility_small(global const RasterBlock *blocks, global const RasterBounds *bounds,
                             global const RasterItem *items, uint first_item, uint item_count,
                             constant RasterView *views, constant CameraInfo *cameras, uint view_count,
                             global const uint2 *hidden, uint hidden_count, constant Float2 *offsets, uint first_tile,
                             uint tile_count, uint first_sample, uint sample_count, float t_min, global ulong *keys,
                             BOX_PARAMETERS, ATTRIBUTE_PARAMETERS)
{
  local uint queued;
  local ulong first;
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  Scope scope = {cameras, (uint2)(0), 0, offsets, {first_tile, tile_count, first_sample, sample_count},
                 t_min,   &attributes};
  // Whole work-groups return, here and below: a chunk is of whole ones.
  uint slot = get_global_id(0);
  if (slot >= item_count * RASTER_CHUNK) return;
  RasterItem item = items[first_item + slot / RASTER_CHUNK];
  uint view_number = item.view, number = item.chunk * RASTER_CHUNK + slot % RASTER_CHUNK;
  constant RasterView *view = &views[view_number];
  scope_turn(&scope, cameras, view_count, view_number);
  uint row_tiles = cameras->tiles_per_row * BIN_TILES, end_row = cameras->height;
  uint first_row = view_count > 1 ? 0 : first_tile / row_tiles * RASTER_BIN_PX;
  if (view_count == 1) end_row = min(((first_tile + tile_count - 1) / row_tiles + 1) * RASTER_BIN_PX, end_row);
  if (!bounds_visible(&bounds[item.chunk], view, (float)first_row, (float)end_row)) return;
  Triangle triangle = triangle_load(blocks, number);
  Vec3L a[3];
  triangle_relative(a, &triangle, view);
  VisibleTriangle t = visible_setup(
      view, a, triangle.flags, (triangle.id == RASTER_UNUSED) | triangles_hidden(triangle.id, hidden, hidden_count));
  int4 box = (int4)(0);
  bool seen = visible_box(&box, &t, view, first_row, end_row, offsets + first_sample, sample_count);
  bool small = seen && box_is_small(box.x, box.y, box.z, box.w);
  RasterBox listed = box_of(number, view_number, box);
  uint tile_total = seen && !small ? box_tile_count(listed) : 0;
  box_list(tile_total, listed, &queued, &first, boxes, box_starts, box_counts);
  uint place = tile_place(tile_total == 1, &queued, &first, box_counts);
  if (!small && tile_total != 1) return;
  SampleEdges edges = sample_edges(&t, view, a);
  if (small || place >= room)
    box_draw(&triangle, &edges, &scope, box, keys);
  else
    tile_store(&tiles[place * RASTER_TILE_VECTORS], listed, &triangle, &edges);
}

kernel void visibility_split(global const RasterBlock *blocks, constant RasterView *views, constant CameraInfo *cameras,
                             uint view_count, constant Float2 *offsets, uint first_tile, uint tile_count,
                             uint first_sample, uint sample_count, float t_min, global ulong *keys, BOX_PARAMETERS,
                             ATTRIBUTE_PARAMETERS)
{
  local uint queued;
  local ulong first;
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  Scope scope = {cameras, (uint2)(0), 0, offsets, {first_tile, tile_count, first_sample, sample_count},
                 t_min,   &attributes};
  ulong all = BOX_TILES(box_counts[RASTER_BOX_COUNT]);
  uint box_count = (uint)(box_counts[RASTER_BOX_COUNT] >> BOX_SHIFT);
  for (ulong begin = get_group_id(0) * GROUP_SIZE; begin < all; begin += get_global_size(0)) {
    ulong at = begin + get_local_id(0);
    bool meets = false;
    RasterBox tile;
    Triangle triangle;
    SampleEdges edges;
    if (at < all) {
      tile = box_tile(at, boxes, box_starts, box_count);
      constant RasterView *view = &views[tile.view];
      scope_turn(&scope, cameras, view_count, tile.view);
      Vec3L a[3];
      triangle = triangle_load(blocks, tile.number);
      triangle_relative(a, &triangle, view);
      VisibleTriangle t = visible_setup(view, a, triangle.flags, 0);
      edges = sample_edges(&t, view, a);
      meets = edges_meet_box(&edges, box_bounds(tile));
    }
    uint place = tile_place(meets, &queued, &first, box_counts);
    if (!meets) continue;
    if (place < room)
      tile_store(&tiles[place * RASTER_TILE_VECTORS], tile, &triangle, &edges);
    else
      box_draw(&triangle, &edges, &scope, box_bounds(tile), keys);
  }
}

kernel void visibility_tiles(global const RasterBlock *blocks, constant RasterView *views, constant CameraInfo *cameras,
                             uint view_count, constant Float2 *offsets, uint first_tile, uint tile_count,
                             uint first_sample, uint sample_count, float t_min, global ulong *keys, BOX_PARAMETERS,
                             ATTRIBUTE_PARAMETERS)
{
  local ulong first;
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  Scope scope = {cameras, (uint2)(0), 0, offsets, {first_tile, tile_count, first_sample, sample_count},
                 t_min,   &attributes};
  uint listed = (uint)min(box_counts[RASTER_TILE_COUNT], (ulong)room), teams = tile_teams(listed);
  uint count = listed * teams, team = get_local_id(0) / RASTER_TEAM;
  for (uint i = tiles_take(&first, box_counts); i < count; i = tiles_take(&first, box_counts)) {
    TileShare share = tile_share((i + team) % teams, teams);
    if (i + team < count)
      tile_draw(&tiles[(i + team) / teams * RASTER_TILE_VECTORS], share, &scope, cameras, view_count, keys);
  }
}

kernel void visibility_resolve(constant CameraInfo *cameras, uint view_count, constant Float2 *offsets, uint first_tile,
                               uint tile_count, uint first_sample, uint slot_count, global const ulong *keys,
                               global const TriangleCorners *corners, global const float *positions, uint capacity,
                               global float *hits, global uint *hit_ids)
{
  uint slot = get_global_id(0), tile = slot / TILE_PIXELS;
  if (slot >= slot_count) return;
  UintL x, y;
  TileView view = tile_view(cameras, view_count, first_tile + tile % tile_count);
  tile_pixels(&x, &y, &view, slot % TILE_PIXELS);
  ulong key = keys[slot];
  float t = camera_ray_end(view.camera, x, y), u = 0, v = 0;
  uint id = (uint)key;
  if (id != HIT_NONE) {
    global const uint *vertex = corners[id].vertex;
    Triangle triangle;
    for (uint i = 0; i < 3; i++) triangle.corner[i] = vload3(vertex[i], positions);
    SampleRay s = sample_ray(view.camera, x, y, offsets[first_sample + tile / tile_count]);
    TriangleHit hit = sample_intersect(&s, &triangle);
    t = as_float((uint)(key >> 32));
    u = hit.u;
    v = hit.v;
  }
  hits[HIT_T * capacity + slot] = t;
  hits[HIT_U * capacity + slot] = u;
  hits[HIT_V * capacity + slot] = v;
  hit_ids[slot] = id;
}
