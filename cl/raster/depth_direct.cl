// Raster of depth maps on a GPU, triangle by triangle: the least depth of each texel stays.
//
//   in    blocks, bounds  the scene's triangles, of which chunks [first_chunk, first_chunk + chunk_count) are drawn
//         views           square maps, [view_count]
//   out   maps            [size * size] of each view (shared/depth_map.h), from its first_texel on, bits of floats
//
//   depth_clear   nothing is there yet
//   depth_small   a work-item a triangle: draws it in those views where its box is small, lists it for others
//   depth_split   a work-item a tile of a large box: lists it if the triangle has a part there
//   depth_tiles   RASTER_TEAM work-items a listed tile
//
//   Cost  44 bytes a triangle of the chunks in view, a plane and three sums a triangle and texel of its box.
//   Depths are not below 0, so that their bits are in their order. LANES is 1. The list holds every triangle and view
//   of a pass: nothing overflows. Coverage and depth are those of lib/map_triangle.cl, as in depth_bins.cl.

#include "lib/boxes.cl"
#include "lib/map_triangle.cl"
#include "shared/depth_map.h"

static inline bool is_drawn(global const RasterBlock *blocks, uint number)
{
  global const RasterBlock *block = &blocks[number / RASTER_STEP];
  uint slot = number % RASTER_STEP;
  return block->id[slot] != RASTER_UNUSED && !is_shadowless(block->flags[slot]);
}

// What drawing takes besides the triangle.
typedef struct Scope {
  constant RasterView *view;
  global const RasterBlock *blocks;
  const AttributeSources *attributes;
} Scope;

static inline MapTriangle triangle_setup(const Scope *scope, uint number)
{
  Vec3L corners[3], a[3];
  triangles_load(corners, a, scope->blocks, number, scope->view);
  return map_triangle_setup(scope->view, a, !is_drawn(scope->blocks, number));
}

static inline bool triangle_window(WindowTriangle *out, const MapTriangle *t, int4 window)
{
  return window_triangle(out, t->x, t->y, t->depth[0], t->depth_x, t->depth_y,
                         min3_lane(t->depth[0], t->depth[1], t->depth[2]),
                         max3_lane(t->depth[0], t->depth[1], t->depth[2]), window);
}

// Is some texel of the window's part inside each edge?
static inline bool window_meets(const WindowTriangle *t)
{
  for (uint i = 0; i < 3; i++) {
    int x = t->edge_x[i] > 0 ? t->last_x : t->first_x, y = t->edge_y[i] > 0 ? t->last_y : t->first_y;
    if (t->edge[i] + t->edge_x[i] * x + t->edge_y[i] * y < 0) return false;
  }
  return true;
}

static inline bool texel_covered(const WindowTriangle *t, int x, int y)
{
  int edge0 = t->edge[0] + t->edge_x[0] * x + t->edge_y[0] * y,
      edge1 = t->edge[1] + t->edge_x[1] * x + t->edge_y[1] * y;
  int edge2 = t->edge[2] + t->edge_x[2] * x + t->edge_y[2] * y;
  return (edge0 | edge1 | edge2) >= 0;
}

// The bits of a window's depth at texel (x, y); the window's first texel begins a block.
static inline uint window_depth(const WindowTriangle *t, int x, int y)
{
  return as_uint(texel_depth(t, block_depth(t, x & ~3, y & ~3), x & 3, y & 3));
}

static inline global uint *window_texel(int x, int y, int4 window, const Scope *scope, global uint *map)
{
  return &map[depth_map_index((uint)(window.x + x), (uint)(window.y + y), scope->view->width)];
}

// Draws texel (x, y), which is covered and was at depth `now`.
static inline void texel_draw(global uint *texel, uint depth, uint now, int x, int y, int4 window, uint number,
                              const Scope *scope)
{
  if (depth > now) return;
#ifdef HAS_MASK
  global const RasterBlock *block = &scope->blocks[number / RASTER_STEP];
  uint slot = number % RASTER_STEP;
  if (block->flags[slot] & TRIANGLE_MASKED && !texels_pass(scope->attributes, block, slot, scope->view, 1,
                                                           (float)(window.x + x) + 0.5f, (float)(window.y + y) + 0.5f))
    return;
#endif
  atomic_min(texel, depth);
}

// The window of a box, from the start of a piece.
static inline int4 box_window(RasterBox box)
{
  int4 bounds = box_bounds(box);
  int2 start = piece_start(bounds.xy);
  return (int4)(start.x, start.y, bounds.z - start.x + 1, bounds.w - start.y + 1);
}

static inline global uint *map_of(global uint *maps, const Scope *scope) { return maps + scope->view->first_texel; }

// Draws a window's texels, all of them or those of a member of a team that has `share`.
static inline void window_draw(const WindowTriangle *t, int4 window, uint number, const Scope *scope, global uint *map,
                               bool alone, TileShare share)
{
  if (alone) {
    for (int y = t->first_y; y <= t->last_y; y++)
      for (int x = t->first_x; x <= t->last_x; x++)
        if (texel_covered(t, x, y)) {
          global uint *texel = window_texel(x, y, window, scope, map);
          texel_draw(texel, window_depth(t, x, y), depth_now(texel), x, y, window, number, scope);
        }
    return;
  }
  int2 first = piece_pixel(), last = (int2)(t->last_x, t->last_y), pieces = last / (int2)(8, 4);
  uint within = pieces_within(first, last) & share_bits(share), covered = 0;
  for (int y = share.first_row; y <= min(pieces.y, share.end_row - 1); y++)
    for (int x = 0; x <= pieces.x; x++)
      covered |= (uint)texel_covered(t, first.x + 8 * x, first.y + 4 * y) << (4 * y + x);
  for (covered &= within; covered;) {
    uint4 bit = bits_take(&covered);
    int2 a = first + piece_offset(bit.x), b = first + piece_offset(bit.y), c = first + piece_offset(bit.z),
         d = first + piece_offset(bit.w);
    global uint *to_a = window_texel(a.x, a.y, window, scope, map), *to_b = window_texel(b.x, b.y, window, scope, map),
                *to_c = window_texel(c.x, c.y, window, scope, map), *to_d = window_texel(d.x, d.y, window, scope, map);
    uint4 now = (uint4)(depth_now(to_a), depth_now(to_b), depth_now(to_c), depth_now(to_d));
    texel_draw(to_a, window_depth(t, a.x, a.y), now.x, a.x, a.y, window, number, scope);
    texel_draw(to_b, window_depth(t, b.x, b.y), now.y, b.x, b.y, window, number, scope);
    texel_draw(to_c, window_depth(t, c.x, c.y), now.z, c.x, c.y, window, number, scope);
    texel_draw(to_d, window_depth(t, d.x, d.y), now.w, d.x, d.y, window, number, scope);
  }
}

// A tile in the list: the box and the triangle, or a part of one that was clipped, in its window.
static inline void tile_store(global uint4 *to, RasterBox box, const WindowTriangle *t)
{
  to[0] = (uint4)(box.x, box.y, box.number, box.view);
  to[1] = as_uint4((int4)(t->edge[0], t->edge[1], t->edge[2], t->edge_x[0]));
  to[2] = as_uint4((int4)(t->edge_x[1], t->edge_x[2], t->edge_y[0], t->edge_y[1]));
  to[3] = as_uint4((int4)(t->edge_y[2], t->offset_x, t->offset_y, as_int(t->depth)));
  to[4] = as_uint4((float4)(t->depth_x, t->depth_y, t->least, t->greatest));
  to[5].x = (uint)(t->first_x | t->first_y << 8 | t->last_x << 16 | t->last_y << 24);
}

static inline RasterBox tile_load(WindowTriangle *t, global const uint4 *from)
{
  uint4 head = from[0];
  RasterBox box = {head.z, head.w, head.x, head.y};
  int4 v1 = as_int4(from[1]), v2 = as_int4(from[2]), v3 = as_int4(from[3]);
  float4 v4 = as_float4(from[4]);
  int range = as_int(from[5].x);
  t->edge[0] = v1.x, t->edge[1] = v1.y, t->edge[2] = v1.z;
  t->edge_x[0] = v1.w, t->edge_x[1] = v2.x, t->edge_x[2] = v2.y;
  t->edge_y[0] = v2.z, t->edge_y[1] = v2.w, t->edge_y[2] = v3.x;
  t->offset_x = v3.y, t->offset_y = v3.z;
  t->depth = as_float(v3.w), t->depth_x = v4.x, t->depth_y = v4.y, t->least = v4.z, t->greatest = v4.w;
  t->first_x = range & 0xff, t->first_y = range >> 8 & 0xff;
  t->last_x = range >> 16 & 0xff, t->last_y = range >> 24 & 0xff;
  return box;
}

// Where tiles go, and what a work-group needs to give them places.
typedef struct TileList {
  global uint4 *tiles;
  uint room;
  global ulong *counts;
  local uint *queued;
  local ulong *first;
} TileList;

// Lists the tiles that members of a work-group have, or draws them where the list is full; every member calls it.
static inline void tiles_pass(bool meets, const WindowTriangle *in, RasterBox box, const Scope *scope,
                              const TileList *list, global uint *maps)
{
  uint place = tile_place(meets, list->queued, list->first, list->counts);
  if (!meets) return;
  if (place < list->room)
    tile_store(&list->tiles[place * RASTER_TILE_VECTORS], box, in);
  else
    window_draw(in, box_window(box), box.number, scope, map_of(maps, scope), true, tile_share(0, 1));
}

kernel void depth_clear(global uint *maps, constant RasterView *views, uint view_count)
{
  for (uint i = 0; i < view_count; i++) {
    constant RasterView *view = &views[i];
    global uint4 *to = (global uint4 *)(maps + view->first_texel);
    uint count = view->width * view->width / 4;
    for (uint at = get_global_id(0); at < count; at += get_global_size(0)) to[at] = (uint4)(as_uint(1.0f));
  }
}

#if GROUP_SIZE < RASTER_VIEWS_MOST
#error "a work-group has too few members to ask about all views at once"
#endif

// Which of a work-group's views, one for every bit, have something of the chunk on their map? Every member calls it.
static inline uint views_meet(local uint *meeting, global const RasterBounds *bounds, constant RasterView *views,
                              uint view_count, uint share, uint shares)
{
  uint member = get_local_id(0);
  if (member == 0) *meeting = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  if (member < view_count && member % shares == share && bounds_on_map(bounds, &views[member]))
    atomic_or(meeting, 1u << member);
  barrier(CLK_LOCAL_MEM_FENCE);
  return *meeting;
}

// A triangle is read once for all views. Where triangles are few, `shares` work-groups have every so many of its views.
kernel void depth_small(global const RasterBlock *blocks, global const RasterBounds *bounds, uint first_chunk,
                        uint chunk_count, constant RasterView *views, uint view_count, uint shares, global uint *maps,
                        BOX_PARAMETERS, ATTRIBUTE_PARAMETERS)
{
  local uint queued, meeting;
  local ulong first;
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  counts_turn(box_counts, set);
  // Whole work-groups return, here and below: a chunk is of whole ones.
  uint slot = get_global_id(0), chunk = slot / RASTER_CHUNK;
  if (chunk >= chunk_count * shares) return;
  uint share = chunk / chunk_count;
  chunk = first_chunk + chunk % chunk_count;
  uint number = chunk * RASTER_CHUNK + slot % RASTER_CHUNK;
  uint bits = views_meet(&meeting, &bounds[chunk], views, view_count, share, shares);
  if (!bits) return;
  Vec3L corners_world[3];
  corners_load(corners_world, blocks, number);
  bool drawn = is_drawn(blocks, number);
  for (; bits; bits &= bits - 1) {
    uint view = lowest_bit(bits);
    Scope scope = {&views[view], blocks, &attributes};
    Vec3L a[3];
    WindowTriangle in;
    corners_relative(a, corners_world, scope.view);
    MapTriangle t = map_triangle_setup(scope.view, a, !drawn);
    RasterBox box = box_of(number, view, (int4)(t.first_x, t.first_y, t.last_x, t.last_y));
    bool small = !t.clipped && box_is_small(t.first_x, t.first_y, t.last_x, t.last_y);
    box_list(!t.culled && !small ? box_tile_count(box) : 0, box, &queued, &first, boxes, box_starts, BOX_COUNTS);
    if (!t.culled && small && triangle_window(&in, &t, box_window(box)))
      window_draw(&in, box_window(box), number, &scope, map_of(maps, &scope), true, tile_share(0, 1));
  }
}

// A triangle that must be clipped goes through the list as the triangles of its fan.
kernel void depth_split(global const RasterBlock *blocks, constant RasterView *views, global uint *maps, BOX_PARAMETERS,
                        ATTRIBUTE_PARAMETERS)
{
  local uint queued, clipped;
  local ulong first;
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  TileList list = {tiles, room, BOX_COUNTS, &queued, &first};
  ulong all = BOX_TILES(BOX_COUNTS[RASTER_BOX_COUNT]);
  uint box_count = (uint)(BOX_COUNTS[RASTER_BOX_COUNT] >> BOX_SHIFT);
  for (ulong begin = get_group_id(0) * GROUP_SIZE; begin < all; begin += get_global_size(0)) {
    ulong at = begin + get_local_id(0);
    RasterBox box = {0, 0, 0, 0};
    WindowTriangle in;
    ClipPolygon polygon;
    bool meets = false;
    polygon.count = 0;
    if (get_local_id(0) == 0) clipped = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (at < all) {
      box = box_tile(at, boxes, box_starts, box_count);
      Scope scope = {&views[box.view], blocks, &attributes};
      MapTriangle t = triangle_setup(&scope, box.number);
      if (t.clipped) {
        polygon = depth_clip(scope.view, clip_corner(&t, 0, 0), clip_corner(&t, 1, 0), clip_corner(&t, 2, 0));
        atomic_or(&clipped, 1u);
      } else {
        meets = triangle_window(&in, &t, box_window(box)) && window_meets(&in);
      }
    }
    Scope scope = {&views[box.view], blocks, &attributes};
    tiles_pass(meets, &in, box, &scope, &list, maps);
    for (uint corner = 2; clipped && corner < CLIP_VERTICES; corner++) {
      meets = corner < polygon.count && window_fan_triangle(&in, &polygon, corner, scope.view, box_window(box)) &&
              window_meets(&in);
      tiles_pass(meets, &in, box, &scope, &list, maps);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
  }
}

// What a member of a team draws of its share of a listed tile.
static inline void tile_draw(global const uint4 *from, TileShare share, constant RasterView *views,
                             global const RasterBlock *blocks, const AttributeSources *attributes, global uint *maps)
{
  WindowTriangle in;
  RasterBox box = tile_load(&in, from);
  Scope scope = {&views[box.view], blocks, attributes};
  window_draw(&in, box_window(box), box.number, &scope, map_of(maps, &scope), false, share);
}

kernel void depth_tiles(global const RasterBlock *blocks, constant RasterView *views, global uint *maps, BOX_PARAMETERS,
                        ATTRIBUTE_PARAMETERS)
{
  local ulong first;
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  uint listed = (uint)min(BOX_COUNTS[RASTER_TILE_COUNT], (ulong)room), teams = tile_teams(listed);
  uint count = listed * teams, team = get_local_id(0) / RASTER_TEAM;
  for (uint i = tiles_take(&first, BOX_COUNTS); i < count; i = tiles_take(&first, BOX_COUNTS)) {
    TileShare share = tile_share((i + team) % teams, teams);
    if (i + team < count)
      tile_draw(&tiles[(i + team) / teams * RASTER_TILE_VECTORS], share, views, blocks, &attributes, maps);
  }
}
