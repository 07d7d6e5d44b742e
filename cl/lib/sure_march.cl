// Where a ray first meets a triangle, by what the texels of six maps about a point know (shared/shadow.h): maps of
// triangles whichever way they face.
//
// As seen from the maps' centre a ray runs along a line on each face that it crosses; along that closeness is linear,
// and so is closeness times the way so far. The line is followed tile by tile, and texel by texel where a tile holds
// something as close as the ray is there. In a texel the ray is tested against the triangles that it names, by the very
// function that rays ask; what is met before the ray leaves the texel is what it meets first, as all that is nearer is
// named in that texel or in one before it.
//
// Not sure are a ray that comes behind more triangles than a texel names, or behind one that hides all of the texel
// without having met it; one that meets a masked or blended triangle; and one that starts so near the centre that
// rounding moves it on the maps.
//
//   Cost  one look a tile and 8 bytes a texel of the way where something is as close; a named triangle is tested once.
//   From  Amanatides, Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing", 1987 (the walk).

#include "lib/named_hit.cl"
#include "lib/sure_tiles.cl"
#include "shared/cube.h"
#include "shared/shadow.h"

// Triangles that a ray has tested of late: texels beside each other name the same.
#define MARCH_TESTED 16

// The maps of one centre, and what they name.
typedef struct SureLists {
  global const ShadowInfo *info;
  global const ShadowView *views;  // six
  global const ShadowTile *tiles;
  global const ShadowBlock *blocks;
  global const ShadowRow *rows;
  uint block_count;
  global const BvhTriangle *triangles;
} SureLists;

typedef struct ListRay {
  float3 from, direction;  // from the centre
  NamedRay ray;
  float slack;  // of closeness, relative
  NamedHit nearest;
  float unclear_t;  // where the lists cannot tell; INFINITY: nowhere
  uint tested[MARCH_TESTED], turn;
} ListRay;

// A part of a ray on one face, for s from 0 to 1.
typedef struct FaceLine {
  float2 at, along;     // texels
  float2 close, grows;  // closeness, and that times t; how they grow
  uint face;
} FaceLine;

static inline float2 line_close(const FaceLine *line, float s) { return line->close + s * line->grows; }

static inline float line_t(float2 close) { return close.x > 0 ? close.y / close.x : INFINITY; }

// The cells of a grid that a line crosses, one after the other.
typedef struct GridWalk {
  int2 cell, step;
  float2 begin, each;  // s at which column and row 0 begin, and what one takes
  float2 ends;         // s at which the cell's column and row end
} GridWalk;

static inline int2 sign_of(float2 v) { return (int2)(v.x > 0 ? 1 : v.x < 0 ? -1 : 0, v.y > 0 ? 1 : v.y < 0 ? -1 : 0); }

static inline void grid_ends(GridWalk *walk)
{
  float column = (float)(walk->cell.x + (walk->step.x > 0)), row = (float)(walk->cell.y + (walk->step.y > 0));
  walk->ends.x = walk->step.x ? walk->begin.x + column * walk->each.x : INFINITY;
  walk->ends.y = walk->step.y ? walk->begin.y + row * walk->each.y : INFINITY;
}

// Cells are `side` texels wide; the first is that of s, within [low, high].
static inline GridWalk grid_walk(const FaceLine *line, float s, float side, int2 low, int2 high)
{
  GridWalk walk;
  float2 first = line->at / side, along = line->along / side;
  walk.cell = clamp(convert_int2(floor(first + s * along)), low, high);
  walk.step = sign_of(along);
  walk.each = (float2)(walk.step.x ? 1 / along.x : 0, walk.step.y ? 1 / along.y : 0);
  walk.begin = (float2)(0, 0) - first * walk.each;
  grid_ends(&walk);
  return walk;
}

// False where the next cell is outside of [low, high].
static inline bool grid_step(GridWalk *walk, int2 low, int2 high)
{
  if (walk->ends.x <= walk->ends.y)
    walk->cell.x += walk->step.x;
  else
    walk->cell.y += walk->step.y;
  grid_ends(walk);
  return walk->cell.x >= low.x && walk->cell.x <= high.x && walk->cell.y >= low.y && walk->cell.y <= high.y;
}

static inline bool was_tested(ListRay *ray, uint number)
{
  for (uint i = 0; i < MARCH_TESTED; i++)
    if (ray->tested[i] == number) return true;
  ray->tested[ray->turn++ % MARCH_TESTED] = number;
  return false;
}

// Tests what entry `entry` of block `index` names that is no less close than `least`.
static inline void texel_test(ListRay *ray, const SureLists *lists, uint index, uint entry, float least)
{
  global const ShadowBlock *block = &lists->blocks[index];
  NamedTriangles some = named_none();
  for (uint k = 0; k < block->row_count; k++) {
    global const ShadowRow *row = k ? &lists->rows[(k - 1) * lists->block_count + index] : &block->first;
    uint number = row->number[entry];
    if (row->near[entry] < least) break;
    if (was_tested(ray, number)) continue;
    global const BvhTriangle *of = &lists->triangles[number];
    named_add(&some, &ray->ray, vload3(0, of->vertex[0]), vload3(0, of->vertex[1]), vload3(0, of->vertex[2]), of->id,
              of->flags & TRIANGLE_SINGLE_SIDED, of->flags & (TRIANGLE_MASKED | TRIANGLE_BLENDED));
    if (some.count < LANES) continue;
    named_test(&ray->nearest, &ray->unclear_t, &ray->ray, &some);
    some = named_none();
  }
  if (some.count) named_test(&ray->nearest, &ray->unclear_t, &ray->ray, &some);
}

// Closeness of the ray at its nearest hit.
static inline float hit_close(const ListRay *ray, const SureLists *lists, const FaceLine *line)
{
  Float4 w = lists->views[line->face].raster.w;
  float3 axis = (float3)(w.x, w.y, w.z);
  return 1 / (dot(axis, ray->from) + ray->nearest.t * dot(axis, ray->direction));
}

// The line within a texel, from `begin` to `end`. True where it ends: it meets something, or what it meets is not
// known.
static inline bool texel_pass(ListRay *ray, const SureLists *lists, const FaceLine *line, uint first_block, int2 texel,
                              float begin, float end)
{
  uint index = first_block + tile_block((uint)texel.x / 4, (uint)texel.y / 4);
  uint entry = (uint)(texel.y % 4 * 4 + texel.x % 4);
  global const ShadowBlock *block = &lists->blocks[index];
  float2 ahead = line_close(line, end);
  float here = line_close(line, begin).x, least = min(here, ahead.x), slack = 1 - ray->slack;
  if (block->first.near[entry] < least * slack) return false;
  texel_test(ray, lists, index, entry, least * slack);
  bool met = ray->nearest.t < INFINITY && ray->nearest.t <= line_t(ahead);
  if (met) least = min(here, hit_close(ray, lists, line));
  if (block->rest[entry] >= least * slack || block->covered[entry] * slack * slack > least) ray->unclear_t = 0;
  return met || ray->unclear_t == 0;
}

// The same within a tile.
static inline bool tile_pass(ListRay *ray, const SureLists *lists, const FaceLine *line, uint first_block, int2 tile,
                             float begin, float end)
{
  int2 low = tile * SHADOW_TILE_PX, high = min(low + SHADOW_TILE_PX, (int2)((int)lists->info->size_px)) - 1;
  GridWalk walk = grid_walk(line, begin, 1, low, high);
  do {
    float next = min(min(walk.ends.x, walk.ends.y), end);
    if (texel_pass(ray, lists, line, first_block, walk.cell, begin, max(next, begin))) return true;
    if (next >= end) return false;
    begin = max(next, begin);
  } while (grid_step(&walk, low, high));
  return false;
}

// The same on a face.
static inline bool face_pass(ListRay *ray, const SureLists *lists, const FaceLine *line)
{
  int columns = TILE_COLUMNS((int)lists->info->size_px);
  int2 low = (int2)(0, 0), high = (int2)(columns - 1, columns - 1);
  global const ShadowTile *tiles = lists->tiles + lists->info->first_texel + line->face * (uint)(columns * columns);
  GridWalk walk = grid_walk(line, 0, SHADOW_TILE_PX, low, high);
  float begin = 0;
  do {
    float end = max(min(min(walk.ends.x, walk.ends.y), 1.0f), begin);
    ShadowTile tile = tiles[walk.cell.y * columns + walk.cell.x];
    float least = min(line_close(line, begin).x, line_close(line, end).x);
    bool empty = tile.near == -INFINITY || tile.near < least * (1 - ray->slack);
    if (!empty && tile_pass(ray, lists, line, tile.first_block, walk.cell, begin, end)) return true;
    if (end >= 1) return false;
    begin = end;
  } while (grid_step(&walk, low, high));
  return false;
}

static inline float axis_component(float3 v, uint axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

static inline uint face_of(float3 d)
{
  float3 size = fabs(d);
  uint axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return 2 * axis + (axis_component(d, axis) < 0);
}

// t at which a ray that is on a face leaves it, and the face that it comes to.
static inline float face_end(uint *next, const ListRay *ray, uint face)
{
  float t = INFINITY, sign = face & 1 ? -1 : 1;
  float w = sign * axis_component(ray->from, face / 2), grows = sign * axis_component(ray->direction, face / 2);
  for (uint other = 0; other < 6; other++) {
    float side = other & 1 ? -1 : 1, at = side * axis_component(ray->from, other / 2),
          slope = grows - side * axis_component(ray->direction, other / 2);
    if (other / 2 == face / 2 || !(slope < 0) || !((at - w) / slope < t)) continue;
    t = (at - w) / slope;
    *next = other;
  }
  return t;
}

// Where a point, or with a w of 0 a direction, is on a face: texels, and w.
static inline float3 face_place(const SureLists *lists, uint face, float3 p, float w)
{
  global const RasterView *view = &lists->views[face].raster;
  float4 at = (float4)(p.x, p.y, p.z, w);
  float depth = dot((float4)(view->w.x, view->w.y, view->w.z, view->w.w), at);
  return (float3)(dot((float4)(view->x.x, view->x.y, view->x.z, view->x.w), at) / depth,
                  dot((float4)(view->y.x, view->y.y, view->y.z, view->y.w), at) / depth, depth);
}

static inline FaceLine face_line(const SureLists *lists, const ListRay *ray, uint face, float begin_t, float end_t)
{
  FaceLine line;
  bool endless = end_t == INFINITY;
  float3 a = face_place(lists, face, ray->from + begin_t * ray->direction, 1);
  float3 b = face_place(lists, face, endless ? ray->direction : ray->from + end_t * ray->direction, endless ? 0 : 1);
  float2 end_close = endless ? (float2)(0, 1 / b.z) : (float2)(1 / b.z, end_t / b.z);
  line.at = a.xy;
  line.along = b.xy - a.xy;
  line.close = (float2)(1 / a.z, begin_t / a.z);
  line.grows = end_close - line.close;
  line.face = face;
  return line;
}

#define MEETS_NOTHING 0
#define MEETS_HIT 1
#define MEETS_UNSURE 2

// What a ray meets before *nearest, a hit that is known otherwise, or else that. `origin` and `direction` are in world
// space; t counts in lengths of the direction.
static inline int sure_meet(NamedHit *nearest, const SureLists *lists, float3 origin, float3 direction)
{
  ListRay ray;
  Float3 center = lists->views[0].raster.origin;
  ray.from = origin - (float3)(center.x, center.y, center.z);
  ray.direction = direction;
  float3 near = fabs(ray.from), far = fabs(origin);
  float rounding = 4.8e-7f * max(max(far.x, far.y), far.z) / max(max(near.x, near.y), near.z) + 1e-6f;
  if (!(rounding * (float)lists->info->size_px < SURE_PADDING / 2)) return MEETS_UNSURE;
  ray.slack = SHADOW_ROUNDING + rounding;
  ray.ray = named_ray(origin, direction);
  ray.nearest = *nearest;
  ray.unclear_t = INFINITY;
  ray.turn = 0;
  for (uint i = 0; i < MARCH_TESTED; i++) ray.tested[i] = HIT_NONE;
  uint face = face_of(ray.from);
  float begin = 0, t_most = nearest->t;
  bool ends = false;
  for (uint i = 0; i < 2 * CUBE_FACES && !ends; i++) {
    uint next = face;
    float end = min(max(face_end(&next, &ray, face), begin), t_most);
    FaceLine line = face_line(lists, &ray, face, begin, end);
    ends = face_pass(&ray, lists, &line) || end >= t_most;
    begin = end;
    face = next;
  }
  *nearest = ray.nearest;
  if (!ends || ray.unclear_t < ray.nearest.t) return MEETS_UNSURE;
  return ray.nearest.t < INFINITY ? MEETS_HIT : MEETS_NOTHING;
}
