// Raster of camera visibility on a GPU, triangle by triangle into a buffer of keys: the least (depth, id) of each slot
// of the wave stays.
//
//   in    blocks, view        the scene's triangles and the camera's view of them
//         camera, offsets     as the ray generator takes them
//         wave                first_tile, tile_count, first_sample, sample_count
//   out   keys                [slots]: bits of t << 32 | id; all ones before the first launch
//         hits, hit_ids       the hit stream of the wave: the bits that trace_closest gives (visibility_resolve)
//
//   visibility_small   a work-item a triangle: draws it if its box is small, else lists it
//   visibility_medium  RASTER_TEAM work-items a listed triangle of medium size
//   visibility_large   a work-group a tile: looks at all large triangles, keeps those that meet the tile, draws them
//   visibility_resolve a work-item a slot: t, u and v of the triangle that won
//
//   Cost  44 bytes a triangle, an intersection a triangle and sample of its box, 8 to 24 bytes a slot.
//   Needs cl_khr_int64_extended_atomics; without it visibility_bins.cl does the same. LANES is 1.
//   The lists hold every triangle of a pass: nothing overflows. Their order varies, the least key does not.
//
//   From  Kenzel, Kerbl, Schmalstieg, Steinberger, "A High-Performance Software Graphics Pipeline Architecture for the
//   GPU",
//         2018 (size classes); Karis, Stubbe, Wihlidal, "Nanite: A Deep Dive", 2021 (atomic depth and id).

#pragma OPENCL EXTENSION cl_khr_int64_extended_atomics : enable

#include "lib/boxes.cl"
#include "lib/camera_ray.cl"
#include "lib/hit.cl"
#include "lib/visible.cl"
#include "raster/triangle_pack.cl"

typedef struct Wave {
  uint first_tile, tile_count, first_sample, sample_count;
} Wave;

// What a sample's test takes besides the triangle.
typedef struct Scope {
  constant CameraInfo *camera;
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
  bool seen = hit_counts(&hit, 1, t->id, t->flags, scope->attributes);
  return seen ? (ulong)as_uint(hit.t) << 32 | t->id : ULONG_MAX;
}

// Slot of a pixel and sample of the wave; HIT_NONE where the wave does not hold it.
static inline uint wave_slot(const Scope *scope, uint x, uint y, uint sample)
{
  uint tile = y / TILE_SIZE * scope->camera->tiles_per_row + x / TILE_SIZE, first = scope->wave.first_tile;
  if (tile < first || tile >= first + scope->wave.tile_count) return HIT_NONE;
  return (tile - first + sample * scope->wave.tile_count) * TILE_PIXELS + tile_slot(x, y);
}

// The upper half of a key is its second word: devices are little-endian.
static inline void sample_draw(const Triangle *t, const Scope *scope, uint x, uint y, uint sample, global ulong *keys)
{
  uint slot = wave_slot(scope, x, y, sample);
  if (slot == HIT_NONE) return;
  SampleRay ray = sample_ray(scope->camera, x, y, scope->offsets[scope->wave.first_sample + sample]);
  ulong key = sample_key(t, scope, &ray);
  if (key == ULONG_MAX) return;
  if (depth_may_fall((volatile global const uint *)&keys[slot] + 1, (uint)(key >> 32))) atom_min(&keys[slot], key);
}

kernel void visibility_small(global const RasterBlock *blocks, uint first_triangle, uint triangle_count,
                             constant RasterView *view, constant CameraInfo *camera, constant Float2 *offsets,
                             uint first_tile, uint tile_count, uint first_sample, uint sample_count, float t_min,
                             global ulong *keys, BOX_PARAMETERS, ATTRIBUTE_PARAMETERS)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  uint number = first_triangle + get_global_id(0);
  if (get_global_id(0) >= triangle_count) return;
  Scope scope = {camera, offsets, {first_tile, tile_count, first_sample, sample_count}, t_min, &attributes};
  Triangle triangle = triangle_load(blocks, number);
  if (triangle.id == RASTER_UNUSED) return;
  uint first_row = first_tile / camera->tiles_per_row * TILE_SIZE;
  uint end_row = min(((first_tile + tile_count - 1) / camera->tiles_per_row + 1) * TILE_SIZE, camera->height);
  Vec3L a[3];
  triangle_relative(a, &triangle, view);
  VisibleTriangle t = visible_setup(view, a, triangle.flags, 0);
  if (t.culled || !visible_samples(&t, view, first_row, end_row, offsets + first_sample, sample_count)) return;
  float2 low_offset = (float2)(0, 0), high_offset = (float2)(1, 1);
  if (sample_count == 1) low_offset = high_offset = (float2)(offsets[first_sample].x, offsets[first_sample].y);
  int x0 = max((int)ceil(max(t.low_x, -1.0f) - high_offset.x), 0),
      y0 = max((int)ceil(max(t.low_y, -1.0f) - high_offset.y), (int)first_row);
  int x1 = (int)floor(min(t.high_x, (float)view->width) - low_offset.x),
      y1 = (int)floor(min(t.high_y, (float)end_row) - low_offset.y);
  x1 = min(x1, (int)view->width - 1);
  y1 = min(y1, (int)end_row - 1);
  if (x0 > x1 || y0 > y1 || box_list(number, 0, x0, y0, x1, y1, false, medium, large, counts)) return;
  for (uint sample = 0; sample < sample_count; sample++)
    for (int y = y0; y <= y1; y++)
      for (int x = x0; x <= x1; x++) sample_draw(&triangle, &scope, (uint)x, (uint)y, sample, keys);
}

kernel void visibility_medium(global const RasterBlock *blocks, constant CameraInfo *camera, constant Float2 *offsets,
                              uint first_tile, uint tile_count, uint first_sample, uint sample_count, float t_min,
                              global ulong *keys, global const RasterBox *medium, global const uint *counts,
                              ATTRIBUTE_PARAMETERS)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  Scope scope = {camera, offsets, {first_tile, tile_count, first_sample, sample_count}, t_min, &attributes};
  uint member = get_global_id(0) % RASTER_TEAM, teams = get_global_size(0) / RASTER_TEAM,
       count = counts[RASTER_MEDIUM_COUNT];
  for (uint i = get_global_id(0) / RASTER_TEAM; i < count; i += teams) {
    RasterBox box = medium[i];
    Triangle triangle = triangle_load(blocks, box.number);
    uint x0 = box.x & 0xffffu, y0 = box.y & 0xffffu, width = (box.x >> 16) - x0 + 1,
         pixels = width * ((box.y >> 16) - y0 + 1);
    for (uint sample = 0; sample < sample_count; sample++)
      for (uint at = member; at < pixels; at += RASTER_TEAM)
        sample_draw(&triangle, &scope, x0 + at % width, y0 + at / width, sample, keys);
  }
}

#define TILE_SHARE (RASTER_TILE_PX * RASTER_TILE_PX / GROUP_SIZE)  // samples of a tile that a work-item has

// A triangle set up for the samples of a tile.
typedef struct TileTriangle {
  Vec3L corner[3];  // world space
  uint id, flags;
  float edge_x[3], edge_y[3], edge_0[3];  // >= 0 (or NaN) at a sample that may be met
} TileTriangle;

static inline TileTriangle tile_triangle(global const RasterBlock *blocks, uint number, constant RasterView *view)
{
  TileTriangle out;
  Vec3L a[3];
  Triangle triangle = triangle_load(blocks, number);
  triangle_relative(a, &triangle, view);
  VisibleTriangle t = visible_setup(view, a, triangle.flags, 0);
  out.id = triangle.id;
  out.flags = triangle.flags;
  for (uint i = 0; i < 3; i++) {
    out.corner[i] = vec3l(triangle.corner[i].x, triangle.corner[i].y, triangle.corner[i].z);
    out.edge_x[i] = t.edge_x[i];
    out.edge_y[i] = t.edge_y[i];
    out.edge_0[i] = t.edge_0[i] - 1.5f * (fabs(t.edge_x[i]) + t.edge_x[i] + fabs(t.edge_y[i]) + t.edge_y[i]);
  }
  return out;
}

// Draws `count` triangles at the work-item's samples of the tile: 8 x 8 pixels of it after each other.
static inline void tile_draw(local const TileTriangle *triangles, uint count, const Scope *scope, uint tile_x,
                             uint tile_y, uint sample, global ulong *keys)
{
  uint member = get_local_id(0);
  Float2 offset = scope->offsets[scope->wave.first_sample + sample];
  for (uint i = 0; i < TILE_SHARE; i++) {
    uint at = i * GROUP_SIZE + member, square = at / 64;
    uint x = tile_x + square % (RASTER_TILE_PX / 8) * 8 + at % 8,
         y = tile_y + square / (RASTER_TILE_PX / 8) * 8 + at % 64 / 8;
    if (x >= scope->camera->width || y >= scope->camera->height) continue;
    uint slot = wave_slot(scope, x, y, sample);
    if (slot == HIT_NONE) continue;
    SampleRay ray = sample_ray(scope->camera, x, y, offset);
    float sample_x = (float)x + offset.x, sample_y = (float)y + offset.y;
    ulong before = keys[slot], best = before;
    for (uint k = 0; k < count; k++) {
      local const TileTriangle *t = &triangles[k];
      if (t->edge_0[0] + t->edge_x[0] * sample_x + t->edge_y[0] * sample_y < 0 ||
          t->edge_0[1] + t->edge_x[1] * sample_x + t->edge_y[1] * sample_y < 0 ||
          t->edge_0[2] + t->edge_x[2] * sample_x + t->edge_y[2] * sample_y < 0)
        continue;
      Triangle triangle = {.id = t->id, .flags = t->flags};
      for (uint c = 0; c < 3; c++) triangle.corner[c] = (float3)(t->corner[c].x, t->corner[c].y, t->corner[c].z);
      ulong key = sample_key(&triangle, scope, &ray);
      best = key < best ? key : best;
    }
    if (best != before) keys[slot] = best;
  }
}

kernel void visibility_large(global const RasterBlock *blocks, constant RasterView *view, constant CameraInfo *camera,
                             constant Float2 *offsets, uint first_tile, uint tile_count, uint first_sample,
                             uint sample_count, float t_min, global ulong *keys, global const RasterBox *large,
                             global const uint *counts, uint columns, uint first_row, uint rows, ATTRIBUTE_PARAMETERS)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  Scope scope = {camera, offsets, {first_tile, tile_count, first_sample, sample_count}, t_min, &attributes};
  local uint queue[QUEUE_SIZE];
  local uint queued;
  local TileTriangle triangles[GROUP_SIZE];
  uint group = get_group_id(0), member = get_local_id(0), count = counts[RASTER_LARGE_COUNT];
  uint x = group % columns * RASTER_TILE_PX, y = (first_row + group / columns % rows) * RASTER_TILE_PX;
  uint sample = group / (columns * rows);
  if (sample >= sample_count || count == 0) return;
  queue_clear(&queued);
  for (uint first = 0; first < count; first += GROUP_SIZE) {
    uint waiting = boxes_gather(queue, &queued, large, first, count, 0, x, y);
    if (waiting <= GROUP_SIZE && first + GROUP_SIZE < count) continue;
    for (uint done = 0; done < waiting; done += GROUP_SIZE) {
      uint now = min(waiting - done, (uint)GROUP_SIZE);
      if (member < now) triangles[member] = tile_triangle(blocks, queue[done + member], view);
      barrier(CLK_LOCAL_MEM_FENCE);
      tile_draw(triangles, now, &scope, x, y, sample, keys);
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    queue_clear(&queued);
  }
}

kernel void visibility_resolve(constant CameraInfo *camera, constant Float2 *offsets, uint first_tile, uint tile_count,
                               uint first_sample, uint slot_count, global const ulong *keys,
                               global const TriangleCorners *corners, global const float *positions, uint capacity,
                               global float *hits, global uint *hit_ids)
{
  uint slot = get_global_id(0), tile = slot / TILE_PIXELS;
  if (slot >= slot_count) return;
  UintL x, y;
  tile_pixels(&x, &y, first_tile + tile % tile_count, slot % TILE_PIXELS, camera->tiles_per_row);
  ulong key = keys[slot];
  float t = camera_ray_end(camera, x, y), u = 0, v = 0;
  uint id = (uint)key;
  if (id != HIT_NONE) {
    global const uint *vertex = corners[id].vertex;
    Triangle triangle;
    for (uint i = 0; i < 3; i++) triangle.corner[i] = vload3(vertex[i], positions);
    SampleRay s = sample_ray(camera, x, y, offsets[first_sample + tile / tile_count]);
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
