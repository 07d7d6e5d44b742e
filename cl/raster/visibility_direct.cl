// Raster of camera visibility on a GPU, triangle by triangle into a buffer of keys: the least (depth, id) of each slot
// of the wave stays.
//
//   in    blocks, views       the scene's triangles and the cameras' views of them
//         items               chunks and views, of which [first_item, first_item + item_count) are drawn
//         cameras, offsets    as the ray generator takes them
//         hidden              ranges of triangle ids that are not there, [hidden_count]
//         wave                first_tile, tile_count, first_sample, sample_count
//   out   keys                [slots]: bits of t << 32 | id; all ones before the first launch, and again once resolved
//         hits, hit_ids       the hit stream of the wave: the bits that trace_closest gives (visibility_resolve)
//
//   visibility_small   a work-item a triangle of an item: lists its samples if its box is small, else its box;
//                      a work-group then draws the samples that it has listed
//   visibility_split   a work-item a tile of a large box: lists it if the triangle may be met there
//   visibility_tiles   RASTER_TEAM work-items a listed tile
//   visibility_resolve a work-item a slot: t, u and v of the triangle that won; leaves keys as it would find them, so
//                      that nobody has to clear them. Shading may do the same in its place (shade/shade.cl)
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
#include "lib/sample_key.cl"
#include "raster/chunks_seen.cl"
#include "raster/triangle_pack.cl"

// Samples of small triangles that may be met, listed by a work-group so that its members then intersect together: most
// small triangles have none.
typedef struct SampleList {
  uint count;
  uint pixel[RASTER_LISTED_SAMPLES];   // x | y << 16
  uint member[RASTER_LISTED_SAMPLES];  // whose triangle it is | sample << 16
} SampleList;

// Lists the triangle's samples of a box; false where the list is full.
static inline bool samples_list(local SampleList *list, const SampleEdges *edges, const Scope *scope, int4 bounds)
{
  for (uint sample = 0; sample < scope->wave.sample_count; sample++) {
    int2 at = bounds.xy;
    for (; sample_next(edges, scope, sample, bounds, &at); at.x++) {
      uint place = atomic_inc(&list->count);
      if (place >= RASTER_LISTED_SAMPLES) return false;
      list->pixel[place] = (uint)at.x | (uint)at.y << 16;
      list->member[place] = (uint)get_local_id(0) | sample << 16;
    }
  }
  return true;
}

// Draws what a work-group has listed of its triangles, of which the first is `first_number`.
static inline void samples_draw(local const SampleList *list, global const RasterBlock *blocks, uint first_number,
                                const Scope *scope, global ulong *keys)
{
  uint count = min(list->count, (uint)RASTER_LISTED_SAMPLES);
  for (uint i = get_local_id(0); i < count; i += GROUP_SIZE) {
    TurnedTriangle turned = {.kz = KZ_NONE};
    Triangle triangle = triangle_load(blocks, first_number + (list->member[i] & 0xffffu));
    int2 at = (int2)((int)(list->pixel[i] & 0xffffu), (int)(list->pixel[i] >> 16));
    sample_draw(&triangle, &turned, scope, at, list->member[i] >> 16, keys);
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

// Slot of a pixel of the tile.
static inline uint piece_slot(const Scope *scope, int2 first, uint bit, uint sample)
{
  int2 at = first + piece_offset(bit);
  return wave_slot(scope, (uint)at.x, (uint)at.y, sample);
}

// Bits of the depth that a slot is at; 0 outside the wave.
static inline uint slot_depth(uint slot, global const ulong *keys)
{
  return slot == HIT_NONE ? 0 : depth_now((global const uint *)&keys[slot] + 1);
}

// What a member of a team draws of its share of a tile. Pixels before the bounds are no less within the edges for that.
static inline void tile_draw(global const uint4 *from, TileShare share, Scope *scope, constant CameraInfo *cameras,
                             uint view_count, global ulong *keys)
{
  Triangle t;
  TurnedTriangle turned = {.kz = KZ_NONE};
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
    for (met &= within; met;) {
      uint count = min(popcount(met), 4u);
      uint4 bit = bits_take(&met);
      uint4 slot = (uint4)(piece_slot(scope, first, bit.x, sample), piece_slot(scope, first, bit.y, sample),
                           piece_slot(scope, first, bit.z, sample), piece_slot(scope, first, bit.w, sample));
      uint4 now = (uint4)(slot_depth(slot.x, keys), slot_depth(slot.y, keys), slot_depth(slot.z, keys),
                          slot_depth(slot.w, keys));
      for (; count; count--, bit = bit.yzwx, slot = slot.yzwx, now = now.yzwx)
        if (slot.x != HIT_NONE && edges.nearest <= now.x)
          slot_draw(&t, &turned, scope, first + piece_offset(bit.x), sample, slot.x, now.x, keys);
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

// The picture's rows that a wave may touch.
static inline uint2 wave_rows(constant CameraInfo *cameras, uint view_count, uint first_tile, uint tile_count)
{
  if (view_count > 1) return (uint2)(0, cameras->height);
  uint row_tiles = cameras->tiles_per_row * BIN_TILES;
  return (uint2)(first_tile / row_tiles * RASTER_BIN_PX,
                 min(((first_tile + tile_count - 1) / row_tiles + 1) * RASTER_BIN_PX, cameras->height));
}

// Lists the samples of a triangle if its box is small. Returns how many tiles the box has if it is not, or the list is
// full; 0 where nothing is left to do.
static inline uint triangle_list(RasterBox *box, local SampleList *list, global const RasterBlock *blocks, uint number,
                                 constant RasterView *view, uint view_number, uint2 rows, const Scope *scope,
                                 global const uint2 *hidden, uint hidden_count)
{
  Vec3L a[3];
  int4 bounds;
  Triangle triangle = triangle_load(blocks, number);
  triangle_relative(a, &triangle, view);
  VisibleTriangle t = visible_setup(
      view, a, triangle.flags, (triangle.id == RASTER_UNUSED) | triangles_hidden(triangle.id, hidden, hidden_count));
  if (!visible_box(&bounds, &t, view, rows.x, rows.y, scope->offsets + scope->wave.first_sample,
                   scope->wave.sample_count))
    return 0;
  *box = box_of(number, view_number, bounds);
  if (box_is_small(bounds.x, bounds.y, bounds.z, bounds.w)) {
    SampleEdges edges = sample_edges(&t, view, a);
    if (samples_list(list, &edges, scope, bounds)) return 0;
  }
  return box_tile_count(*box);
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
  local SampleList list;
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  Scope scope = {cameras, (uint2)(0), 0, offsets, {first_tile, tile_count, first_sample, sample_count},
                 t_min,   &attributes};
  counts_turn(box_counts, set);
  // Whole work-groups return, here and below: a chunk is of whole ones.
  uint slot = get_global_id(0), member = get_local_id(0);
  if (slot >= item_count * RASTER_CHUNK) return;
  RasterItem item = items[first_item + slot / RASTER_CHUNK];
  uint view_number = item.view, number = item.chunk * RASTER_CHUNK + slot % RASTER_CHUNK;
  constant RasterView *view = &views[view_number];
  scope_turn(&scope, cameras, view_count, view_number);
  uint2 rows = wave_rows(cameras, view_count, first_tile, tile_count);
  if (!bounds_visible(&bounds[item.chunk], view, (float)rows.x, (float)rows.y)) return;
  if (member == 0) list.count = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  RasterBox box = {0, 0, 0, 0};
  uint tile_total = triangle_list(&box, &list, blocks, number, view, view_number, rows, &scope, hidden, hidden_count);
  box_list(tile_total, box, &queued, &first, boxes, box_starts, BOX_COUNTS);
  samples_draw(&list, blocks, number - member, &scope, keys);
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
  ulong all = BOX_TILES(BOX_COUNTS[RASTER_BOX_COUNT]);
  uint box_count = (uint)(BOX_COUNTS[RASTER_BOX_COUNT] >> BOX_SHIFT);
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
    uint place = tile_place(meets, &queued, &first, BOX_COUNTS);
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
  uint listed = (uint)min(BOX_COUNTS[RASTER_TILE_COUNT], (ulong)room), teams = tile_teams(listed);
  uint count = listed * teams, team = get_local_id(0) / RASTER_TEAM;
  for (uint i = tiles_take(&first, BOX_COUNTS); i < count; i = tiles_take(&first, BOX_COUNTS)) {
    TileShare share = tile_share((i + team) % teams, teams);
    if (i + team < count)
      tile_draw(&tiles[(i + team) / teams * RASTER_TILE_VECTORS], share, &scope, cameras, view_count, keys);
  }
}

kernel void visibility_resolve(constant CameraInfo *cameras, uint view_count, constant Float2 *offsets, uint first_tile,
                               uint tile_count, uint first_sample, uint slot_count, global ulong *keys,
                               global const TriangleCorners *corners, global const float *positions, uint capacity,
                               global float *hits, global uint *hit_ids)
{
  uint slot = get_global_id(0);
  if (slot >= slot_count) return;
  UintL x, y;
  CameraSources sources = {cameras, view_count, offsets, first_tile, tile_count, first_sample};
  WaveTile tile = wave_tile(&sources, get_group_id(0) * (uint)get_local_size(0));  // of the whole work-group
  constant CameraInfo *camera = tile.view.camera;
  tile_pixels(&x, &y, &tile.view, slot % TILE_PIXELS);
  ulong key = key_take(keys, slot);
  HitPlace hit = {camera_ray_end(camera, x, y), 0, 0};
  if (key != ULONG_MAX) {
    CameraRay ray = camera_ray(camera, x, y, tile.offset);
    hit = key_hit(key, &ray, camera, corners, positions);
  }
  hits[HIT_T * capacity + slot] = hit.t;
  hits[HIT_U * capacity + slot] = hit.u;
  hits[HIT_V * capacity + slot] = hit.v;
  hit_ids[slot] = (uint)key;
}
