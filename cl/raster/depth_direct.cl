// Raster of depth maps on a GPU, triangle by triangle: the least depth of each texel stays.
//
//   in    blocks, views   the scene's triangles, [view_count] square maps of the same size
//   out   maps            [view][size * size] (shared/depth_map.h) as the bits of floats, 1 before the first launch
//
//   depth_small   a work-item a triangle and view: draws it if its box is small, else lists it
//   depth_split   a work-item a tile of a large box: lists it if the triangle has a part there
//   depth_tiles   RASTER_TEAM work-items a listed tile
//
//   Cost  44 bytes a triangle and view of the chunks in view, a plane and three sums a triangle and texel of its box.
//   Depths are not below 0, so that their bits are in their order. LANES is 1. The list holds every triangle and view
//   of a pass: nothing overflows. Coverage and depth are those of lib/map_triangle.cl, as in depth_bins.cl.

#include "lib/boxes.cl"
#include "lib/map_triangle.cl"
#include "shared/depth_map.h"

// What drawing takes besides the triangle.
typedef struct Scope {
  constant RasterView *view;
  global const RasterBlock *blocks;
  const AttributeSources *attributes;
} Scope;

static inline MapTriangle triangle_setup(const Scope *scope, uint number)
{
  global const RasterBlock *block = &scope->blocks[number / RASTER_STEP];
  uint slot = number % RASTER_STEP;
  Vec3L corners[3], a[3];
  triangles_load(corners, a, scope->blocks, number, scope->view);
  return map_triangle_setup(scope->view, a, block->id[slot] == RASTER_UNUSED);
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

// Draws texel (x, y) of the window, whose first texel begins a block.
static inline void texel_draw(const WindowTriangle *t, int x, int y, int4 window, uint number, const Scope *scope,
                              global uint *map)
{
  int edge0 = t->edge[0] + t->edge_x[0] * x + t->edge_y[0] * y,
      edge1 = t->edge[1] + t->edge_x[1] * x + t->edge_y[1] * y;
  int edge2 = t->edge[2] + t->edge_x[2] * x + t->edge_y[2] * y;
  if ((edge0 | edge1 | edge2) < 0) return;
  uint depth = as_uint(texel_depth(t, block_depth(t, x & ~3, y & ~3), x & 3, y & 3));
  global uint *texel = &map[depth_map_index((uint)(window.x + x), (uint)(window.y + y), scope->view->width)];
  if (depth > depth_now(texel)) return;
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
  int2 start = piece_start(bounds.x, bounds.y);
  return (int4)(start, bounds.zw - start + 1);
}

// Draws a window's texels: all of them, or those of a member of a team.
static inline void window_draw(const WindowTriangle *t, int4 window, uint number, const Scope *scope, global uint *map,
                               bool alone)
{
  if (alone) {
    for (int y = t->first_y; y <= t->last_y; y++)
      for (int x = t->first_x; x <= t->last_x; x++) texel_draw(t, x, y, window, number, scope, map);
    return;
  }
  int2 start = piece_start(t->first_x, t->first_y) + piece_pixel(get_global_id(0) % RASTER_TEAM);
  for (int y = start.y; y <= t->last_y; y += 4)
    for (int x = start.x; x <= t->last_x; x += 8)
      if (x >= t->first_x && y >= t->first_y) texel_draw(t, x, y, window, number, scope, map);
}

// Draws what a triangle has in a box, which holds no more than a tile.
static inline void box_draw(const MapTriangle *t, const Scope *scope, RasterBox box, global uint *maps, bool alone)
{
  WindowTriangle in;
  int4 window = box_window(box);
  global uint *map = maps + box.view * scope->view->width * scope->view->width;
  if (!t->clipped) {
    if (triangle_window(&in, t, window)) window_draw(&in, window, box.number, scope, map, alone);
    return;
  }
  ClipPolygon polygon = depth_clip(scope->view, clip_corner(t, 0, 0), clip_corner(t, 1, 0), clip_corner(t, 2, 0));
  for (uint i = 2; i < polygon.count; i++)
    if (window_fan_triangle(&in, &polygon, i, scope->view, window))
      window_draw(&in, window, box.number, scope, map, alone);
}

kernel void depth_small(global const RasterBlock *blocks, global const RasterBounds *bounds, uint first_triangle,
                        uint triangle_count, constant RasterView *views, uint view_count, global uint *maps,
                        BOX_PARAMETERS, ATTRIBUTE_PARAMETERS)
{
  local uint queued;
  local ulong first;
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  uint item = get_global_id(0), number = first_triangle + item % triangle_count, view = item / triangle_count;
  if (view >= view_count) return;  // whole work-groups, here and below: a chunk is of whole ones
  Scope scope = {&views[view], blocks, &attributes};
  if (!bounds_on_map(&bounds[number / RASTER_CHUNK], scope.view)) return;
  MapTriangle t = triangle_setup(&scope, number);
  bool small = !t.culled && !t.clipped && box_is_small(t.first_x, t.first_y, t.last_x, t.last_y);
  int4 box = (int4)(t.first_x, t.first_y, t.last_x, t.last_y);
  box_list(!t.culled && !small, box_of(number, view, box), &queued, &first, boxes, box_starts, box_tiles, box_counts,
           room);
  if (!small) return;
  box_draw(&t, &scope, box_of(number, view, box), maps, true);
}

kernel void depth_split(global const RasterBlock *blocks, constant RasterView *views, global uint *maps, BOX_PARAMETERS,
                        ATTRIBUTE_PARAMETERS)
{
  local uint queued;
  local ulong first;
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  ulong all = BOX_TILES(box_counts[RASTER_BOX_COUNT]);
  uint box_count = (uint)(box_counts[RASTER_BOX_COUNT] >> BOX_SHIFT);
  for (ulong begin = get_group_id(0) * GROUP_SIZE; begin < all; begin += get_global_size(0)) {
    ulong at = begin + get_local_id(0);
    bool meets = false;
    RasterBox tile;
    MapTriangle t;
    if (at < all) {
      WindowTriangle in;
      tile = box_tile(at, boxes, box_starts, box_count);
      Scope scope = {&views[tile.view], blocks, &attributes};
      t = triangle_setup(&scope, tile.number);
      meets = t.clipped || (triangle_window(&in, &t, box_window(tile)) && window_meets(&in));
    }
    uint place = tile_place(meets, &queued, &first, box_counts);
    if (!meets) continue;
    Scope scope = {&views[tile.view], blocks, &attributes};
    if (place < room)
      box_tiles[place] = tile;
    else
      box_draw(&t, &scope, tile, maps, true);
  }
}

kernel void depth_tiles(global const RasterBlock *blocks, constant RasterView *views, global uint *maps, BOX_PARAMETERS,
                        ATTRIBUTE_PARAMETERS)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  uint all = (uint)min(box_counts[RASTER_TILE_COUNT], (ulong)room), teams = get_global_size(0) / RASTER_TEAM;
  for (uint i = get_global_id(0) / RASTER_TEAM; i < all; i += teams) {
    RasterBox tile = box_tiles[i];
    Scope scope = {&views[tile.view], blocks, &attributes};
    MapTriangle t = triangle_setup(&scope, tile.number);
    box_draw(&t, &scope, tile, maps, false);
  }
}
