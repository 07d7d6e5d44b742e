// Raster of depth maps on a GPU, triangle by triangle: the least depth of each texel stays.
//
//   in    blocks, views   the scene's triangles, [view_count] square maps of the same size
//   out   maps            [view][size * size] (shared/depth_map.h) as the bits of floats, 1 before the first launch
//
//   depth_small   a work-item a triangle and view: draws it if its box is small, else lists it
//   depth_boxes   RASTER_TEAM work-items a tile of a listed triangle
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
  if (!depth_may_fall(texel, depth)) return;
#ifdef HAS_MASK
  global const RasterBlock *block = &scope->blocks[number / RASTER_STEP];
  uint slot = number % RASTER_STEP;
  if (block->flags[slot] & TRIANGLE_MASKED && !texels_pass(scope->attributes, block, slot, scope->view, 1,
                                                           (float)(window.x + x) + 0.5f, (float)(window.y + y) + 0.5f))
    return;
#endif
  atomic_min(texel, depth);
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
  box_list(!t.culled && !small, box_of(number, view, box), &queued, &first, boxes, box_starts, box_counter);
  if (!small) return;
  WindowTriangle in;
  int4 window = (int4)(box.x & ~3, box.y & ~3, box.z - (box.x & ~3) + 1, box.w - (box.y & ~3) + 1);
  if (!triangle_window(&in, &t, window)) return;
  global uint *map = maps + view * scope.view->width * scope.view->width;
  for (int y = in.first_y; y <= in.last_y; y++)
    for (int x = in.first_x; x <= in.last_x; x++) texel_draw(&in, x, y, window, number, &scope, map);
}

// A team's part of one triangle in a tile.
static inline void tile_draw(const WindowTriangle *t, int4 window, uint number, const Scope *scope, global uint *map)
{
  int2 member = piece_pixel(get_global_id(0) % RASTER_TEAM), start = piece_start(t->first_x, t->first_y) + member;
  for (int y = start.y; y <= t->last_y; y += 4)
    for (int x = start.x; x <= t->last_x; x += 8)
      if (x >= t->first_x && y >= t->first_y) texel_draw(t, x, y, window, number, scope, map);
}

static inline void tile_draw_clipped(const MapTriangle *t, int4 window, uint number, const Scope *scope,
                                     global uint *map)
{
  WindowTriangle in;
  ClipPolygon polygon = depth_clip(scope->view, clip_corner(t, 0, 0), clip_corner(t, 1, 0), clip_corner(t, 2, 0));
  for (uint i = 2; i < polygon.count; i++)
    if (window_fan_triangle(&in, &polygon, i, scope->view, window)) tile_draw(&in, window, number, scope, map);
}

kernel void depth_boxes(global const RasterBlock *blocks, constant RasterView *views, global uint *maps,
                        global const RasterBox *boxes, global const ulong *box_starts, global const ulong *box_counter,
                        ATTRIBUTE_PARAMETERS)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  ulong counter = *box_counter, teams = get_global_size(0) / RASTER_TEAM;
  BoxTurn turn;
  for (ulong i = get_global_id(0) / RASTER_TEAM; box_turn(&turn, i, teams, box_starts, counter); i += teams)
    while (box_next(&turn, boxes, box_starts)) {
      uint number = turn.box.number;
      Scope scope = {&views[turn.box.view], blocks, &attributes};
      MapTriangle t = triangle_setup(&scope, number);
      global uint *map = maps + turn.box.view * scope.view->width * scope.view->width;
      for (uint k = turn.from; k < turn.to; k++) {
        int4 tile = box_tile(turn.box, k), window = (int4)(tile.xy, tile.zw - tile.xy + 1);
        WindowTriangle in;
        if (t.clipped)
          tile_draw_clipped(&t, window, number, &scope, map);
        else if (triangle_window(&in, &t, window) && window_meets(&in))
          tile_draw(&in, window, number, &scope, map);
      }
    }
}
