// What a light's maps (shared/shadow.h) tell of shadow rays at a look, before any triangle is tested.

#include "lib/shadow_view.cl"
#include "shared/bvh.h"
#include "shared/shadow.h"

// Where the packet's points are on the maps.
typedef struct TexelLook {
  IntL mapped;       // lanes that a map holds
  UintL tile, x, y;  // index into the tiles of all lights; column and row of the block in the map
  UintL texel;       // of the block
  UintL view;        // of the light
  FloatL closeness, slack;
} TexelLook;

// Where on the map of a view the lanes `group` are.
static inline void view_look(TexelLook *look, UintL *texel_x, UintL *texel_y, const MapPoint *at, IntL group,
                             uint size_px, bool parallel)
{
  FloatL last = FLOATL((float)(size_px - 1)), zero = FLOATL(0), one = FLOATL(1);
  *texel_x = group ? LANE_AS_UINT(LANE_CONVERT_INT(min_lane(max_lane(at->x, zero), last))) : *texel_x;
  *texel_y = group ? LANE_AS_UINT(LANE_CONVERT_INT(min_lane(max_lane(at->y, zero), last))) : *texel_y;
  FloatL closeness = parallel ? zero - at->depth : one / at->w;
  look->closeness = group ? closeness : look->closeness;
  look->slack =
      group ? (parallel ? FLOATL(SHADOW_ROUNDING_PARALLEL) : closeness * FLOATL(SHADOW_ROUNDING)) : look->slack;
}

static inline TexelLook texels_look(global const ShadowInfo *info, global const ShadowView *views, Vec3L origin,
                                    IntL active)
{
  TexelLook look;
  uint tile_columns = TILE_COLUMNS(info->size_px);
  UintL chosen = UINTL(SHADOW_VIEW_NONE), texel_x = UINTL(0), texel_y = UINTL(0), three = UINTL(3);
  IntL left = active;
  look.closeness = look.slack = FLOATL(0);
  if (info->views == SHADOW_VIEWS_CUBE) {
    chosen = shadow_view_choose(info, views, origin);
    left = active & (chosen == UINTL(SHADOW_VIEW_NONE));
    for (uint bits = lane_bits(active & !left); bits;) {
      uint number = LANE_UINT(chosen, lowest_bit(bits));
      IntL group = active & (chosen == UINTL(number));
      bits &= ~lane_bits(group);
      MapPoint at = shadow_project(&views[number], shadow_relative(&views[number], origin));
      view_look(&look, &texel_x, &texel_y, &at, group, info->size_px, views[number].raster.parallel);
    }
  } else {
    for (uint i = 0; i < info->view_count && any_lane(left); i++) {
      MapPoint at = shadow_project(&views[i], shadow_relative(&views[i], origin));
      IntL group = left & shadow_in_view(&at, info, views[i].raster.parallel);
      view_look(&look, &texel_x, &texel_y, &at, group, info->size_px, views[i].raster.parallel);
      chosen = group ? UINTL(i) : chosen;
      left = left & !group;
    }
  }
  look.mapped = active & !left;
  look.view = chosen;
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

// Lanes of `asking` that are closer to the light than all in their texels of block `number` but the triangles `own`
// that they start on, and do not meet again.
static inline IntL own_judge(IntL asking, FloatL least_close, UintL texel, uint number, const SureSources *of,
                             UintL own)
{
  IntL owns = INTL(0);
  global const ShadowBlock *block = &of->blocks[number];
  UintL names = table_pick_uint(block->first.number, texel, asking, UINTL(SHADOW_CLOSED));
  for (uint open = lane_bits((names & UINTL(SHADOW_CLOSED)) == UINTL(0)); open;) {
    uint name = LANE_UINT(names, lowest_bit(open));
    IntL named = names == UINTL(name);
    open &= ~lane_bits(named);
    owns = owns | (named & (own == UINTL(of->triangles[name].id)));
  }
  if (!any_lane(owns)) return owns;
  FloatL none = FLOATL(-INFINITY), near = table_pick(block->rest, texel, owns, none);
  if (block->row_count > 1) near = max_lane(table_pick(of->rows[number].near, texel, owns, none), near);
  return owns & (least_close > near);
}

// What the texels of those that wait tell; `own`: NULL, or the triangles that they start on.
static inline void texels_judge(Verdicts *v, const TexelLook *look, const SureSources *of, const UintL *own)
{
  FloatL least_close = look->closeness - look->slack, most_close = look->closeness + look->slack;
  IntL known = least_close >= v->least;
  for (uint bits = lane_bits(v->waiting); bits;) {
    uint number = LANE_UINT(v->block, lowest_bit(bits));
    IntL same = v->waiting & (v->block == UINTL(number));
    bits &= ~lane_bits(same);
    global const ShadowBlock *block = &of->blocks[number];
    FloatL near = table_pick(block->first.near, look->texel, same, FLOATL(INFINITY));
    FloatL covered = table_pick(block->covered, look->texel, same, FLOATL(-INFINITY));
    IntL lit = known & (least_close > near), dark = most_close < covered;
    if (own) {
      IntL asking = same & known & !(lit | dark);
      if (any_lane(asking)) lit = lit | own_judge(asking, least_close, look->texel, number, of, *own);
    }
    v->lit = v->lit | lit;
    v->dark = v->dark | dark;
  }
  v->waiting = v->waiting & !(v->lit | v->dark);
}

// Judges the rays `active` from `origin` (world space) to the light; `own`: NULL, or the triangles that they start on.
static inline Verdicts sure_look(TexelLook *look, global const ShadowInfo *info, global const ShadowView *views,
                                 const SureSources *of, Vec3L origin, IntL active, const UintL *own)
{
  *look = texels_look(info, views + info->first_view, origin, active);
  Verdicts v = tiles_judge(look, of->tiles);
  if (any_lane(v.waiting)) texels_judge(&v, look, of, own);
  return v;
}
