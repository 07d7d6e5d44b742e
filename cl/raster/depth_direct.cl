// Raster of depth maps on a GPU, triangle by triangle: the least depth of each texel stays.
//
//   in    blocks, views   the scene's triangles, [view_count] square maps of the same size
//   out   maps            [view][size * size] (shared/depth_map.h) as the bits of floats, 1 before the first launch
//
//   depth_small   a work-item a triangle and view: draws it if its box is small, else lists it
//   depth_medium  RASTER_TEAM work-items a listed triangle of medium size
//   depth_large   a work-group a tile: looks at all large triangles, keeps those that meet the tile, draws them
//
//   Cost  44 bytes a triangle and view, a plane and three sums a triangle and texel of its box.
//   Depths are not below 0, so that their bits are in their order. LANES is 1. The lists hold every triangle and view
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

// The box of texels that a triangle may cover, from the start of a block.
static inline int4 box_window(int first_x, int first_y, int last_x, int last_y)
{
  int x = first_x & ~3, y = first_y & ~3;
  return (int4)(x, y, last_x - x + 1, last_y - y + 1);
}

kernel void depth_small(global const RasterBlock *blocks, uint first_triangle, uint triangle_count,
                        constant RasterView *views, uint view_count, global uint *maps, BOX_PARAMETERS,
                        ATTRIBUTE_PARAMETERS)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  uint item = get_global_id(0), number = first_triangle + item % triangle_count, view = item / triangle_count;
  if (view >= view_count) return;
  Scope scope = {&views[view], blocks, &attributes};
  MapTriangle t = triangle_setup(&scope, number);
  if (t.culled) return;
  if (box_list(number, view, t.first_x, t.first_y, t.last_x, t.last_y, t.clipped, medium, large, counts)) return;
  WindowTriangle in;
  int4 window = box_window(t.first_x, t.first_y, t.last_x, t.last_y);
  if (!triangle_window(&in, &t, window)) return;
  global uint *map = maps + view * scope.view->width * scope.view->width;
  for (int y = in.first_y; y <= in.last_y; y++)
    for (int x = in.first_x; x <= in.last_x; x++) texel_draw(&in, x, y, window, number, &scope, map);
}

kernel void depth_medium(global const RasterBlock *blocks, constant RasterView *views, global uint *maps,
                         global const RasterBox *medium, global const uint *counts, ATTRIBUTE_PARAMETERS)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  uint member = get_global_id(0) % RASTER_TEAM, teams = get_global_size(0) / RASTER_TEAM,
       count = counts[RASTER_MEDIUM_COUNT];
  for (uint i = get_global_id(0) / RASTER_TEAM; i < count; i += teams) {
    RasterBox box = medium[i];
    Scope scope = {&views[box.view], blocks, &attributes};
    MapTriangle t = triangle_setup(&scope, box.number);
    WindowTriangle in;
    int4 window = box_window((int)(box.x & 0xffffu), (int)(box.y & 0xffffu), (int)(box.x >> 16), (int)(box.y >> 16));
    if (!triangle_window(&in, &t, window)) continue;
    global uint *map = maps + box.view * scope.view->width * scope.view->width;
    int width = in.last_x - in.first_x + 1, size = width * (in.last_y - in.first_y + 1);
    for (int at = (int)member; at < size; at += RASTER_TEAM)
      texel_draw(&in, in.first_x + at % width, in.first_y + at / width, window, box.number, &scope, map);
  }
}

// A triangle set up for a tile: its window, or where it must be clipped first its number alone.
typedef struct TileTriangle {
  WindowTriangle window;
  uint number;
  uint there, clipped;
} TileTriangle;

static inline TileTriangle tile_triangle(const Scope *scope, uint number, int4 window)
{
  TileTriangle out = {{{0}}};  // all of it is copied, whatever is there
  MapTriangle t = triangle_setup(scope, number);
  out.number = number;
  out.clipped = t.clipped;
  out.there = t.clipped || triangle_window(&out.window, &t, window);
  return out;
}

// The work-group's part of one triangle in its tile.
static inline void tile_draw(const WindowTriangle *t, int4 window, uint number, const Scope *scope, global uint *map)
{
  int width = t->last_x - t->first_x + 1, size = width * (t->last_y - t->first_y + 1);
  for (int at = (int)get_local_id(0); at < size; at += GROUP_SIZE)
    texel_draw(t, t->first_x + at % width, t->first_y + at / width, window, number, scope, map);
}

static inline void tile_draw_clipped(uint number, int4 window, const Scope *scope, global uint *map)
{
  WindowTriangle in;
  MapTriangle t = triangle_setup(scope, number);
  ClipPolygon polygon = depth_clip(scope->view, clip_corner(&t, 0, 0), clip_corner(&t, 1, 0), clip_corner(&t, 2, 0));
  for (uint i = 2; i < polygon.count; i++)
    if (window_fan_triangle(&in, &polygon, i, scope->view, window)) tile_draw(&in, window, number, scope, map);
}

kernel void depth_large(global const RasterBlock *blocks, constant RasterView *views, uint view_count,
                        global uint *maps, global const RasterBox *large, global const uint *counts, uint columns,
                        ATTRIBUTE_PARAMETERS)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  local uint queue[QUEUE_SIZE];
  local uint queued;
  local TileTriangle triangles[GROUP_SIZE];
  uint tile = get_group_id(0) % (columns * columns), view = get_group_id(0) / (columns * columns);
  uint member = get_local_id(0), count = counts[RASTER_LARGE_COUNT];
  if (view >= view_count || count == 0) return;
  Scope scope = {&views[view], blocks, &attributes};
  uint size = scope.view->width, x = tile % columns * RASTER_TILE_PX, y = tile / columns * RASTER_TILE_PX;
  int4 window =
      (int4)((int)x, (int)y, (int)min(size - x, (uint)RASTER_TILE_PX), (int)min(size - y, (uint)RASTER_TILE_PX));
  global uint *map = maps + view * size * size;
  queue_clear(&queued);
  for (uint first = 0; first < count; first += GROUP_SIZE) {
    uint waiting = boxes_gather(queue, &queued, large, first, count, view, x, y);
    if (waiting <= GROUP_SIZE && first + GROUP_SIZE < count) continue;
    for (uint done = 0; done < waiting; done += GROUP_SIZE) {
      uint now = min(waiting - done, (uint)GROUP_SIZE);
      if (member < now) triangles[member] = tile_triangle(&scope, queue[done + member], window);
      barrier(CLK_LOCAL_MEM_FENCE);
      for (uint k = 0; k < now; k++) {
        TileTriangle t = triangles[k];
        if (t.clipped)
          tile_draw_clipped(t.number, window, &scope, map);
        else if (t.there)
          tile_draw(&t.window, window, t.number, &scope, map);
      }
      barrier(CLK_LOCAL_MEM_FENCE);
    }
    queue_clear(&queued);
  }
}
