// Shadow-map compare: how much of a light's radiance arrives at a surface, by the depths that one texel or several of
// its map hold. Part of shading, as in a raster frame: no ray is written or read.
//
//   SHADOW_BY_TEXEL   the texel that holds the point: lit or dark (Williams 1978)
//   SHADOW_BY_PCF     kernel_px x kernel_px texels about it, the outer ones by the share that the kernel covers
//                     (Reeves, Salesin, Cook 1987): an edge becomes a ramp kernel_px texels wide
//   SHADOW_BY_PCSS    nearer texels within the light's reach give the width of its half-shadow, a disc that wide is
//                     averaged (Fernando 2005); with radius 0 it is PCF of one texel
//
//   A texel's depth is compared with that of the receiver's own plane at the texel's centre, not with the point's: on a
//   plane no bias is needed but that of rounding and of vertices snapped to 1 / RASTER_SNAP of a texel, whatever the
//   light's angle (receiver-plane depth bias: Isidoro, "Shadow Mapping: GPU-based Tips and Techniques", GDC 2006). For
//   surfaces that bend, a caster must stand before that plane by its growth over slope_px texels (ShadowInfo); what
//   stands closer casts no shadow.
//   A point outside all maps is lit; shadow_fit leaves none that the camera sees.
//
//   Fails at edges of shadows, by up to a texel's footprint (SHADOW_BY_TEXEL: half of it on average to either side);
//   on finely curved surfaces, whose neighbouring triangles leave the receiver's plane within the kernel; where casters
//   are thinner than a texel.
//   Cost  4 ns a point by the nearest texel; PCF: lib/shadow_kernel.cl.
//
//   From  Williams, "Casting Curved Shadows on Curved Surfaces", SIGGRAPH 1978; Reeves, Salesin, Cook, "Rendering
//         Antialiased Shadows with Depth Maps", SIGGRAPH 1987; Fernando, "Percentage-Closer Soft Shadows", 2005.

#include "lib/shadow_kernel.cl"

static inline FloatL dot_float3(Vec3L a, Float3 b) { return a.x * FLOATL(b.x) + a.y * FLOATL(b.y) + a.z * FLOATL(b.z); }

static inline PlaneDepth plane_depth(global const ShadowInfo *info, global const ShadowView *view, Vec3L relative,
                                     const MapPoint *at, Vec3L normal)
{
  PlaneDepth out;
  FloatL scale;
  if (view->raster.parallel) {
    scale = FLOATL(-1) / dot_float3(normal, view->axis);
  } else {
    scale = FLOATL(view->raster.depth_by_w) / dot3(normal, relative);
  }
  out.depth = at->depth;
  out.by_x = dot_float3(normal, view->sight_x) * scale;
  out.by_y = dot_float3(normal, view->sight_y) * scale;
  // A plane seen edge on has no depth: nothing then is said to be in front of it.
  IntL flat = (fabs(out.by_x) < FLOATL(1)) & (fabs(out.by_y) < FLOATL(1));
  FloatL slope = fabs(out.by_x) + fabs(out.by_y);
  out.slack = flat ? FLOATL(info->depth_slack) + slope * FLOATL(info->slope_px) : FLOATL(2);
  out.by_x = flat ? out.by_x : FLOATL(0);
  out.by_y = flat ? out.by_y : FLOATL(0);
  return out;
}

// Depths of texels, clamped to the map.
static inline FloatL map_fetch(global const float *map, uint size, IntL x, IntL y)
{
  IntL zero = INTL(0), last = INTL((int)size - 1);
  x = x < zero ? zero : x > last ? last : x;
  y = y < zero ? zero : y > last ? last : y;
  IntL index =
      ((y >> INTL(2)) * INTL((int)size / 4) + (x >> INTL(2))) * INTL(16) + (y & INTL(3)) * INTL(4) + (x & INTL(3));
  return LANE_GATHER(FloatL, map, index);
}

// 1 where the texel leaves the receiver's plane lit.
static inline FloatL texel_lit(global const float *map, uint size, const MapPoint *at, const PlaneDepth *plane, IntL x,
                               IntL y)
{
  FloatL half_texel = FLOATL(0.5f), one = FLOATL(1);
  FloatL dx = LANE_CONVERT_FLOAT(x) + half_texel - at->x, dy = LANE_CONVERT_FLOAT(y) + half_texel - at->y;
  FloatL receiver = plane->depth + plane->by_x * dx + plane->by_y * dy - plane->slack;
  return min_lane(receiver, one) <= map_fetch(map, size, x, y) ? one : FLOATL(0);  // 1: nothing is there
}

#ifdef HAS_DISC
// Taps of a disc of radius 1: Vogel's spiral, tap k at radius sqrt((k + 1 / 2) / 32) and k times the golden angle; all
// stand for the same area.
constant Float2 disc_taps[SHADOW_DISC_TAPS] = {
    {0.1250f, 0.0000f},   {-0.1596f, 0.1462f}, {0.0244f, -0.2784f},  {0.2012f, 0.2625f},   {-0.3693f, -0.0653f},
    {0.3498f, -0.2225f},  {-0.1170f, 0.4352f}, {-0.2231f, -0.4296f}, {0.4841f, 0.1768f},   {-0.5036f, 0.2079f},
    {0.2428f, -0.5188f},  {0.1794f, 0.5720f},  {-0.5408f, -0.3134f}, {0.6344f, -0.1395f},  {-0.3871f, 0.5507f},
    {-0.0894f, -0.6902f}, {0.5491f, 0.4628f},  {-0.7389f, 0.0306f},  {0.5390f, -0.5363f},  {-0.0361f, 0.7798f},
    {-0.5128f, -0.6145f}, {0.8124f, 0.1093f},  {-0.6883f, 0.4789f},  {0.1881f, -0.8361f},  {0.4350f, 0.7592f},
    {-0.8504f, -0.2713f}, {0.8261f, -0.3817f}, {-0.3579f, 0.8552f},  {-0.3194f, -0.8880f}, {0.8499f, 0.4467f},
    {-0.9440f, 0.2488f},  {0.5366f, -0.8345f}};

// Mean closeness of the texels in the disc that stand before the receiver's plane: 1 / w, or in parallel projection the
// depth; and how many they are.
static inline FloatL blockers(FloatL *count, global const ShadowView *view, global const float *map, uint size,
                              const MapPoint *at, const PlaneDepth *plane, FloatL radius_px)
{
  FloatL sum = FLOATL(0), one = FLOATL(1);
  *count = FLOATL(0);
  for (uint i = 0; i < SHADOW_DISC_TAPS; i++) {
    Float2 tap = disc_taps[i];
    FloatL dx = radius_px * FLOATL(tap.x), dy = radius_px * FLOATL(tap.y);
    IntL x = LANE_CONVERT_INT(floor_lane(at->x + dx)), y = LANE_CONVERT_INT(floor_lane(at->y + dy));
    FloatL depth = map_fetch(map, size, x, y);
    FloatL across_x = LANE_CONVERT_FLOAT(x) + FLOATL(0.5f) - at->x,
           across_y = LANE_CONVERT_FLOAT(y) + FLOATL(0.5f) - at->y;
    FloatL receiver = plane->depth + plane->by_x * across_x + plane->by_y * across_y;
    IntL before = (receiver > depth + plane->slack) & (depth < one);
    FloatL closeness =
        view->raster.parallel ? depth : (depth - FLOATL(view->raster.depth_far)) * FLOATL(1 / view->raster.depth_by_w);
    sum += before ? closeness : FLOATL(0);
    *count += before ? one : FLOATL(0);
  }
  return sum / *count;
}

// Radius of the light as seen from the receiver past a blocker, in texels. At closeness c = 1 / w of the blocker and
// c0 of the receiver, what is a metre wide at the light is (c - c0) metres wide at w = 1.
// 0 where no texel stands before it.
static inline FloatL half_shadow_px(global const ShadowInfo *info, global const ShadowView *view,
                                    global const float *map, const MapPoint *at, const PlaneDepth *plane)
{
  Float3 step = view->sight_x;
  float reach = info->radius / sqrt(step.x * step.x + step.y * step.y + step.z * step.z);
  FloatL most = FLOATL(SHADOW_DISC_PX), least = FLOATL(0.5f), one = FLOATL(1), count;
  // Blockers may stand anywhere before the receiver: look as far as the greatest disc reaches.
  FloatL search = min_lane(FLOATL(reach) * (view->raster.parallel ? at->depth : FLOATL(1e3f)), most);
  FloatL closeness = blockers(&count, view, map, info->size_px, at, plane, max_lane(search, least));
  FloatL apart = view->raster.parallel ? at->depth - closeness : closeness - one / at->w;
  return count > FLOATL(0) ? FLOATL(reach) * max_lane(apart, FLOATL(0)) : FLOATL(0);
}

static inline FloatL lit_by_disc(global const ShadowInfo *info, global const ShadowView *view, const LightMap *map,
                                 const MapPoint *at, const PlaneDepth *plane, UintL id, IntL group)
{
  FloatL radius = half_shadow_px(info, view, map->texels, at, plane);
  IntL soft = (radius > FLOATL(0.5f)) & group;
  radius = min_lane(radius, FLOATL(SHADOW_DISC_PX));
  FloatL lit = lit_by_kernel(map, 1, at, plane, id, group);
  if (!any_lane(soft)) return lit;
  FloatL sum = FLOATL(0);
  for (uint i = 0; i < SHADOW_DISC_TAPS; i++) {
    Float2 tap = disc_taps[i];
    IntL x = LANE_CONVERT_INT(floor_lane(at->x + radius * FLOATL(tap.x)));
    IntL y = LANE_CONVERT_INT(floor_lane(at->y + radius * FLOATL(tap.y)));
    sum += texel_lit(map->texels, map->size, at, plane, x, y);
  }
  return soft ? sum * FLOATL(1.0f / SHADOW_DISC_TAPS) : lit;
}
#endif

static inline FloatL lit_fraction(global const ShadowInfo *info, global const ShadowView *view, const LightMap *map,
                                  const MapPoint *at, const PlaneDepth *plane, UintL id, IntL group)
{
#ifdef HAS_DISC
  if (info->method == SHADOW_BY_PCSS) return lit_by_disc(info, view, map, at, plane, id, group);
#endif
  if (info->method == SHADOW_BY_PCF) return lit_by_kernel(map, info->kernel_px, at, plane, id, group);
  return texel_lit(map->texels, info->size_px, at, plane, LANE_CONVERT_INT(floor_lane(at->x)),
                   LANE_CONVERT_INT(floor_lane(at->y)));
}

// A point in a view, and its triangle's plane there.
typedef struct ShadowLookup {
  MapPoint at;
  PlaneDepth plane;
} ShadowLookup;

static inline ShadowLookup shadow_lookup(global const ShadowInfo *info, global const ShadowView *view, Vec3L point,
                                         Vec3L normal)
{
  ShadowLookup out;
  Vec3L relative = shadow_relative(view, point);
  out.at = shadow_project(view, relative);
  out.plane = plane_depth(info, view, relative, &out.at, normal);
  return out;
}

// Lit fraction for the lanes of `mask`: points (world space) of triangles `id` with the normals given, of either side.
// `views` and `maps` are those of all lights.
static inline FloatL shadow_lit(global const ShadowInfo *info, global const ShadowView *views, global const float *maps,
                                Vec3L point, Vec3L normal, UintL id, IntL mask)
{
  views += info->first_view;
  maps += info->first_texel;
  FloatL lit = FLOATL(1);
#if LANES > 1
  if (info->views == SHADOW_VIEWS_ONE) {  // is projected once
    LightMap map = light_map(info, maps, 0);
    ShadowLookup lookup = shadow_lookup(info, views, point, normal);
    IntL within = mask & shadow_in_view(&lookup.at, info, views->raster.parallel);
    if (!any_lane(within)) return lit;
    return within ? lit_fraction(info, views, &map, &lookup.at, &lookup.plane, id, within) : lit;
  }
#endif
  UintL chosen = shadow_view_choose(info, views, point);
  for (uint bits = lane_bits(mask & (chosen != UINTL(SHADOW_VIEW_NONE))); bits;) {
    uint number = LANE_UINT(chosen, lowest_bit(bits));
    IntL group = mask & (chosen == UINTL(number));
    bits &= ~lane_bits(group);
    global const ShadowView *view = &views[number];
    LightMap map = light_map(info, maps, number);
    ShadowLookup lookup = shadow_lookup(info, view, point, normal);
    lit = group ? lit_fraction(info, view, &map, &lookup.at, &lookup.plane, id, group) : lit;
  }
  return lit;
}
