// What a light's maps (shared/shadow.h) tell of shadow rays at a look, before any triangle is tested.

#include "lib/shadow_view.cl"
#include "shared/bvh.h"
#include "shared/shadow.h"

// Where the packet's points are on the maps.
typedef struct TexelLook {
  IntL mapped;       // lanes that a map holds
  UintL tile, x, y;  // index into the tiles of all lights; column and row of the block in the map
  UintL texel;       // of the block
  FloatL closeness, slack;
} TexelLook;

static inline TexelLook texels_look(global const ShadowInfo *info, global const ShadowView *views, Vec3L origin,
                                    IntL active)
{
  TexelLook look;
  uint tile_columns = TILE_COLUMNS(info->size_px);
  UintL chosen = shadow_view_choose(info, views, origin), texel_x = UINTL(0), texel_y = UINTL(0), three = UINTL(3);
  look.mapped = active & (chosen != UINTL(SHADOW_VIEW_NONE));
  look.closeness = look.slack = FLOATL(0);
  for (uint bits = lane_bits(look.mapped); bits;) {
    uint number = LANE_UINT(chosen, lowest_bit(bits));
    IntL group = look.mapped & (chosen == UINTL(number));
    bits &= ~lane_bits(group);
    global const ShadowView *view = &views[number];
    MapPoint at = shadow_project(view, shadow_relative(view, origin));
    FloatL last = FLOATL((float)(info->size_px - 1)), zero = FLOATL(0), one = FLOATL(1);
    texel_x = group ? LANE_AS_UINT(LANE_CONVERT_INT(min_lane(max_lane(at.x, zero), last))) : texel_x;
    texel_y = group ? LANE_AS_UINT(LANE_CONVERT_INT(min_lane(max_lane(at.y, zero), last))) : texel_y;
    bool parallel = view->raster.parallel;
    FloatL closeness = parallel ? zero - at.depth : one / at.w;
    look.closeness = group ? closeness : look.closeness;
    look.slack =
        group ? (parallel ? FLOATL(SHADOW_ROUNDING_PARALLEL) : closeness * FLOATL(SHADOW_ROUNDING)) : look.slack;
  }
  look.x = texel_x >> UINTL(2);
  look.y = texel_y >> UINTL(2);
  look.texel = ((texel_y & three) << UINTL(2)) + (texel_x & three);
  look.tile = (chosen * UINTL(tile_columns) + (look.y >> UINTL(2))) * UINTL(tile_columns) + (look.x >> UINTL(2)) +
              UINTL(info->first_texel);
  return look;
}

// What is known of the packet's rays so far.
typedef struct Verdicts {
  IntL lit, dark, waiting;  // waiting: their blocks may tell
  UintL block;              // of those that wait
  FloatL least;             // what is less close is not known to be lit
} Verdicts;

// What whole tiles tell; neighbouring rays are mostly in the same.
static inline Verdicts tiles_judge(const TexelLook *look, global const ShadowTile *tiles)
{
  Verdicts v = {INTL(0), INTL(0), INTL(0), UINTL(0), FLOATL(0)};
  FloatL least_close = look->closeness - look->slack, most_close = look->closeness + look->slack;
  UintL three = UINTL(3), block = ((look->y & three) << UINTL(2)) + (look->x & three);
  for (uint bits = lane_bits(look->mapped); bits;) {
    uint number = LANE_UINT(look->tile, lowest_bit(bits));
    IntL group = look->mapped & (look->tile == UINTL(number));
    bits &= ~lane_bits(group);
    ShadowTile tile = tiles[number];
    if (tile.first_block == SHADOW_TILE_UNKNOWN) continue;
    v.lit = v.lit | (group & (least_close > FLOATL(tile.near)) & (least_close >= FLOATL(tile.least)));
    v.dark = v.dark | (group & (most_close < FLOATL(tile.covered)));
    if (tile.near > -INFINITY) v.waiting = v.waiting | (group & !(v.lit | v.dark));
    v.block = group ? block + UINTL(tile.first_block) : v.block;
    v.least = group ? FLOATL(tile.least) : v.least;
  }
  return v;
}

// What the maps of all lights hold.
typedef struct SureSources {
  global const ShadowTile *tiles;
  global const ShadowBlock *blocks;
  global const ShadowRow *rows;
  uint block_count;
  global const BvhTriangle *triangles;  // in the order of the BVH's leaves
} SureSources;

// How close to the light anything comes but the triangle `own` of a ray's start, in the texel; no ray meets that again.
static inline float near_beside(const SureSources *of, global const ShadowBlock *block, uint number, uint texel,
                                uint own)
{
  uint name = block->first.number[texel];
  if (name & SHADOW_CLOSED || of->triangles[name].id != own) return block->first.near[texel];
  float second = block->row_count > 1 ? of->rows[number].near[texel] : -INFINITY;
  return max(second, block->rest[texel]);
}

// What the texels of those that wait tell; `own`: the triangles that the rays start on.
static inline void own_judge(Verdicts *v, const TexelLook *look, const SureSources *of, UintL own)
{
  FloatL near = FLOATL(INFINITY), least_close = look->closeness - look->slack;
  for (uint bits = lane_bits(v->waiting & (least_close >= v->least)); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits), number = LANE_UINT(v->block, lane);
    LANE_FLOAT(near, lane) =
        near_beside(of, &of->blocks[number], number, LANE_UINT(look->texel, lane), LANE_UINT(own, lane));
  }
  v->lit = v->lit | (v->waiting & (least_close > near));
  v->waiting = v->waiting & !v->lit;
}

// What the texels of those that wait tell.
static inline void texels_judge(Verdicts *v, const TexelLook *look, global const ShadowBlock *blocks)
{
  FloatL near = FLOATL(INFINITY), covered = FLOATL(-INFINITY), least_close = look->closeness - look->slack;
  for (uint bits = lane_bits(v->waiting); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits), texel = LANE_UINT(look->texel, lane);
    global const ShadowBlock *block = &blocks[LANE_UINT(v->block, lane)];
    LANE_FLOAT(near, lane) = block->first.near[texel];
    LANE_FLOAT(covered, lane) = block->covered[texel];
  }
  v->lit = v->lit | (v->waiting & (least_close > near) & (least_close >= v->least));
  v->dark = v->dark | (v->waiting & (look->closeness + look->slack < covered));
  v->waiting = v->waiting & !(v->lit | v->dark);
}

// Judges the rays `active` from `origin` (world space) to the light.
static inline Verdicts sure_judge(TexelLook *look, global const ShadowInfo *info, global const ShadowView *views,
                                  const SureSources *of, Vec3L origin, IntL active)
{
  *look = texels_look(info, views + info->first_view, origin, active);
  Verdicts v = tiles_judge(look, of->tiles);
  if (any_lane(v.waiting)) texels_judge(&v, look, of->blocks);
  return v;
}
