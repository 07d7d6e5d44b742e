// What shadow maps may get wrong, told by maps and the camera alone: no shadow ray is traced.
//
//   in    rays, slots          shadow rays of probes to `light`, [ray_count] of segment `segment`, with receivers
//         infos, views, maps   of all lights, as shading reads them (lib/shadow_lookup.cl)
//         finer_infos, ..      finer maps of the same lights, where has_finer
//         corners, positions   the receivers' triangles
//         least_weight         rays that bring less radiance are not missed, and not doubted
//         scale                of radiance for display; INFINITY where that is not known
//         showing              1: no doubts, but shown[slot] gains what light arrives by the map
//         shown                what all lights so bring, which are shown by sRGB
//   out   doubts[slot]         the chance that the map's answer is wrong, where it is more than what is there
//
//   SHADOW_BY_TEXEL   |nearest texel's verdict - the likely share of light|, which is what the four nearest texels of
//                     the finer map tell, weighted bilinearly; or of the map itself where there is no finer one, and
//                     then 1 where a texel's verdict is neither its left and right nor its upper and lower neighbour's
//   SHADOW_BY_PCF     1 where the kernel is neither all dark nor lit to 98 %
//   SHADOW_BY_PCSS    1 where the disc of the light's half-shadow and a texel more, or 3 x 3 texels, are neither, in
//                     either map
//
//   Why. Between the middles of a lit and a dark texel there is an edge of the shadow, and the map tells nothing of
//   where: let it be anywhere with the same chance. At a share u of the way from the lit one to the dark one the edge
//   is behind the point, which then is dark, with chance u; the nearest texel says lit up to u = 1/2: it is wrong with
//   chance min(u, 1 - u), 1/4 in the mean over both sides: a quarter of a texel for each texel of edge, which is the
//   known edge length x m / 4 (m: texels in pixels). In two dimensions the bilinear weights stand for u. Along one
//   straight edge u may stay the same, and the error be twice the mean: host/render/shadow_bound.h has that factor.
//   A finer map tells more of where the edge is, and u is its own. Averages of texels are ramps where the truth is a
//   step: off by more than 2/255 nearly all along the ramp.
//   Thin. A caster, or a gap, of width w < 1 texels is drawn where it covers texels' middles, in a share w of the
//   texels that it runs through: in the mean over where it lies the finer map shows as much of it as there is, and
//   n times as fine, with n^2 times as many texels caught, it strays n times less from that. By the map alone each of
//   those texels is wrong but for the caster's own width, and stands for as much that is missing elsewhere: hence the
//   1, which that factor doubles.
//   Touching. What stands before the receiver's plane, but by less than the bias (slope_px of ShadowInfo), is lit by
//   the map: a facet that laps over the next, the foot of a wall. Where the middle of a texel lies on the receiver's
//   own triangle the map holds that triangle there, or what stands before it and so makes it dark. Drawn, the
//   triangle is off by rounding and by what its vertices are snapped by, half of 1 / RASTER_SNAP of a texel, no more
//   anywhere within it: what is before its plane by four times that is something else. Beside the triangle the map does
//   not tell such a caster from the next facet of the same surface, and the bias is believed.
//   Where light grazes a surface a texel is drawn out along it (60-fold at one degree), and casters that are thinner
//   than that leave no trace: no less than DOUBT_GRAZED then. Angle and share were found by trial, on a wall that the
//   sun grazes (`frugal stability --only projective-aliasing`).
//
//   Knows only what the maps hold. It misses casters much thinner than a texel that no texel caught; what touches
//   triangles that are smaller than a texel, or that the map must clip (before the light's eye plane, or thousands of
//   texels off), and, by averages, all that touches; and half-shadows wider than the disc that PCSS searches
//   (SHADOW_DISC_PX). A light is not doubted where it would not show beside the others if it were all there, or not at
//   all.
//   Cost  100 ns a ray on a core, twice that with a finer map.
//   From  the argument above; Williams 1978, and Reeves, Salesin, Cook 1987, for what is doubted.

#include "lib/radiance.cl"
#include "lib/ray_stream.cl"
#include "lib/shadow_lookup.cl"
#include "shared/raster.h"
#include "shared/scene.h"

// Lit to more than this is lit: off by less than 2/255 once displayed.
#define DOUBT_LIT 0.98f

// A change of what is displayed from which on it counts: half of the 2/255, as other lights may be wrong there too.
#define DOUBT_SHOWN (1.0f / 255)

// Sine of 0.9 degrees between light and surface, and what is doubted below that at the least.
#define DOUBT_GRAZING 0.0157f
#define DOUBT_GRAZED 0.15f

// The receiver's triangle: its corners, and their plane's normal, of any length.
typedef struct Receiver {
  Vec3L corners[3], normal;
} Receiver;

static inline Vec3L lanes3(IntL mask, float3 a, Vec3L b)
{
  return select3(mask, vec3l(FLOATL(a.x), FLOATL(a.y), FLOATL(a.z)), b);
}

static inline Receiver receiver_load(global const TriangleCorners *corners, global const float *positions, UintL id,
                                     IntL mask)
{
  Receiver r;
  r.normal = r.corners[0] = r.corners[1] = r.corners[2] = vec3l(FLOATL(0), FLOATL(0), FLOATL(0));
  for (uint bits = lane_bits(mask); bits;) {
    uint triangle = LANE_UINT(id, lowest_bit(bits));
    IntL group = mask & (id == UINTL(triangle));
    bits &= ~lane_bits(group);
    global const uint *vertex = corners[triangle].vertex;
    float3 a = vload3(vertex[0], positions), b = vload3(vertex[1], positions), c = vload3(vertex[2], positions);
    r.corners[0] = lanes3(group, a, r.corners[0]);
    r.corners[1] = lanes3(group, b, r.corners[1]);
    r.corners[2] = lanes3(group, c, r.corners[2]);
    r.normal = lanes3(group, cross(b - a, c - a), r.normal);
  }
  return r;
}

// The receiver as a view draws it.
typedef struct DrawnReceiver {
  Vec3L corners[3];  // relative to the view's origin
  PlaneDepth plane;  // without bias: what is before it is not the receiver
  IntL known;        // it need not be clipped
} DrawnReceiver;

static inline DrawnReceiver receiver_drawn(global const ShadowInfo *info, global const ShadowView *view,
                                           const Receiver *receiver, const PlaneDepth *plane)
{
  DrawnReceiver drawn;
  FloatL guard = FLOATL(RASTER_GUARD_PX), deepest = FLOATL(1);
  drawn.known = plane->slack < FLOATL(1);
  for (uint i = 0; i < 3; i++) {
    drawn.corners[i] = shadow_relative(view, receiver->corners[i]);
    MapPoint p = shadow_project(view, drawn.corners[i]);
    drawn.known = drawn.known & (p.w >= FLOATL(view->raster.least_w)) & (fabs(p.x) < guard) & (fabs(p.y) < guard);
    deepest = max_lane(deepest, fabs(p.depth));
  }
  drawn.plane = *plane;
  drawn.plane.slack =
      FLOATL(info->depth_slack) * deepest + FLOATL(2.0f / RASTER_SNAP) * (fabs(plane->by_x) + fabs(plane->by_y));
  return drawn;
}

// Does the receiver's triangle, or what is on the other side of the light, lie in the middle of the texel?
static inline IntL receiver_in_texel(global const ShadowView *view, const DrawnReceiver *drawn, IntL x, IntL y)
{
  Float3 from = view->sight_0, step_x = view->sight_x, step_y = view->sight_y, axis = view->axis;
  FloatL px = LANE_CONVERT_FLOAT(x) + FLOATL(0.5f), py = LANE_CONVERT_FLOAT(y) + FLOATL(0.5f), zero = FLOATL(0);
  Vec3L sight = vec3l(FLOATL(from.x) + px * FLOATL(step_x.x) + py * FLOATL(step_y.x),
                      FLOATL(from.y) + px * FLOATL(step_x.y) + py * FLOATL(step_y.y),
                      FLOATL(from.z) + px * FLOATL(step_x.z) + py * FLOATL(step_y.z));
  Vec3L a = drawn->corners[0], b = drawn->corners[1], c = drawn->corners[2];
  if (view->raster.parallel) {
    a = sub3(a, sight);
    b = sub3(b, sight);
    c = sub3(c, sight);
    sight = vec3l(FLOATL(axis.x), FLOATL(axis.y), FLOATL(axis.z));
  }
  FloatL ab = dot3(sight, cross3(a, b)), bc = dot3(sight, cross3(b, c)), ca = dot3(sight, cross3(c, a));
  return ((ab >= zero) & (bc >= zero) & (ca >= zero)) | ((ab <= zero) & (bc <= zero) & (ca <= zero));
}

// 1 where the texel tells that light reaches the receiver's plane in the middle of it.
static inline FloatL texel_likely(global const ShadowView *view, global const float *map, uint size,
                                  const ShadowLookup *lookup, const DrawnReceiver *drawn, IntL x, IntL y)
{
  IntL there = drawn->known & receiver_in_texel(view, drawn, x, y);
  FloatL biased = texel_lit(map, size, &lookup->at, &lookup->plane, x, y);
  return there ? texel_lit(map, size, &lookup->at, &drawn->plane, x, y) : biased;
}

// How far the share of light that the four texels about the point make likely is from `lit`, 0 or 1.
static inline FloatL texels_doubt(global const ShadowInfo *info, global const ShadowView *view, global const float *map,
                                  const ShadowLookup *lookup, const Receiver *receiver, FloatL lit)
{
  const DrawnReceiver drawn = receiver_drawn(info, view, receiver, &lookup->plane);
  FloatL left = lookup->at.x - FLOATL(0.5f), top = lookup->at.y - FLOATL(0.5f), sum = FLOATL(0);
  FloatL share_x = left - floor(left), share_y = top - floor(top);
  for (int i = 0; i < 4; i++) {
    IntL x = LANE_CONVERT_INT(floor(left)) + INTL(i & 1), y = LANE_CONVERT_INT(floor(top)) + INTL(i >> 1);
    FloatL across = i & 1 ? share_x : FLOATL(1) - share_x, down = i >> 1 ? share_y : FLOATL(1) - share_y;
    sum += across * down * fabs(lit - texel_likely(view, map, info->size_px, lookup, &drawn, x, y));
  }
  return sum;
}

// Texels whose verdict is neither their left and right nor their upper and lower neighbours'.
static inline IntL texel_is_thin(global const float *map, uint size, const MapPoint *at, const PlaneDepth *plane)
{
  IntL x = LANE_CONVERT_INT(floor(at->x)), y = LANE_CONVERT_INT(floor(at->y)), one = INTL(1);
  FloatL lit = texel_lit(map, size, at, plane, x, y);
  FloatL left = texel_lit(map, size, at, plane, x - one, y), right = texel_lit(map, size, at, plane, x + one, y);
  FloatL above = texel_lit(map, size, at, plane, x, y - one), below = texel_lit(map, size, at, plane, x, y + one);
  return ((left != lit) & (right != lit)) | ((above != lit) & (below != lit));
}

static inline FloatL ramp_doubt(FloatL lit)
{
  return ((lit > FLOATL(0)) & (lit < FLOATL(DOUBT_LIT))) ? FLOATL(1) : FLOATL(0);
}

#ifdef HAS_DISC
static inline FloatL disc_doubt(global const ShadowInfo *info, global const ShadowView *view, const LightMap *map,
                                const MapPoint *at, const PlaneDepth *plane, UintL id, IntL group)
{
  if (!(info->radius > 0)) return ramp_doubt(lit_by_kernel(map, 1, at, plane, id, group));
  FloatL doubt = ramp_doubt(lit_by_kernel(map, 3, at, plane, id, group));
  FloatL radius = half_shadow_px(info, view, map->texels, at, plane) + FLOATL(1), sum = FLOATL(0);
  for (uint i = 0; i < SHADOW_DISC_TAPS; i++) {
    Float2 tap = disc_taps[i];
    IntL x = LANE_CONVERT_INT(floor(at->x + radius * FLOATL(tap.x)));
    IntL y = LANE_CONVERT_INT(floor(at->y + radius * FLOATL(tap.y)));
    sum += texel_lit(map->texels, map->size, at, plane, x, y);
  }
  return max_lane(doubt, ramp_doubt(sum * FLOATL(1.0f / SHADOW_DISC_TAPS)));
}
#endif

// Does light graze the receiver's plane?
static inline IntL is_grazed(global const ShadowView *view, Vec3L point, Vec3L normal)
{
  Float3 axis = view->axis;
  Vec3L along = vec3l(FLOATL(axis.x), FLOATL(axis.y), FLOATL(axis.z));
  if (!view->raster.parallel) along = shadow_relative(view, point);
  FloatL across = dot3(along, normal);
  return across * across < FLOATL(DOUBT_GRAZING * DOUBT_GRAZING) * dot3(along, along) * dot3(normal, normal);
}

// A light's maps; finer ones than those that gave the answer in doubt?
typedef struct LightMaps {
  global const ShadowInfo *info;
  global const ShadowView *views;
  global const float *maps;
  bool finer;
} LightMaps;

static inline LightMaps light_maps(global const ShadowInfo *infos, global const ShadowView *views,
                                   global const float *maps, uint light, bool finer)
{
  LightMaps of = {&infos[light], views + infos[light].first_view, maps + infos[light].first_texel, finer};
  return of;
}

// What of an answer, `lit`, is doubted for the lanes of `group`, which one view sees.
static inline FloatL view_doubt(const LightMaps *of, uint number, Vec3L point, const Receiver *receiver, UintL id,
                                IntL group, FloatL lit)
{
  global const ShadowInfo *info = of->info;
  global const ShadowView *view = &of->views[number];
  LightMap map = light_map(info, of->maps, number);
  ShadowLookup lookup = shadow_lookup(info, view, point, receiver->normal);
  FloatL doubt;
  if (info->method == SHADOW_BY_TEXEL) {
    doubt = texels_doubt(info, view, map.texels, &lookup, receiver, lit);
    if (!of->finer) doubt = texel_is_thin(map.texels, info->size_px, &lookup.at, &lookup.plane) ? FLOATL(1) : doubt;
#ifdef HAS_DISC
  } else if (info->method == SHADOW_BY_PCSS) {
    doubt = disc_doubt(info, view, &map, &lookup.at, &lookup.plane, id, group);
#endif
  } else {
    doubt = ramp_doubt(lit_by_kernel(&map, info->kernel_px, &lookup.at, &lookup.plane, id, group));
  }
  return is_grazed(view, point, receiver->normal) ? max_lane(doubt, FLOATL(DOUBT_GRAZED)) : doubt;
}

static inline FloatL maps_doubt(const LightMaps *of, Vec3L point, const Receiver *receiver, UintL id, IntL mask,
                                FloatL lit)
{
  UintL chosen = shadow_view_choose(of->info, of->views, point);
  FloatL doubt = FLOATL(0);
  for (uint bits = lane_bits(mask & (chosen != UINTL(SHADOW_VIEW_NONE))); bits;) {
    uint number = LANE_UINT(chosen, lowest_bit(bits));
    IntL group = mask & (chosen == UINTL(number));
    bits &= ~lane_bits(group);
    doubt = group ? view_doubt(of, number, point, receiver, id, group, lit) : doubt;
  }
  return doubt;
}

// Light as a display takes it, in [0, 1].
static inline FloatL displayed(FloatL linear)
{
  FloatL one = FLOATL(1), x = max_lane(min_lane(linear, one), FLOATL(0)), least = FLOATL(1e-6f);
  FloatL curved = FLOATL(1.055f) * pow(max_lane(x, least), FLOATL(1 / 2.4f)) - FLOATL(0.055f);
  return x <= FLOATL(0.0031308f) ? x * FLOATL(12.92f) : curved;
}

// Would it show if a light's fraction `lit` of `weight` were all or none of it, beside what else is shown?
static inline IntL channel_shows(FloatL shown, FloatL weight, FloatL lit)
{
  FloatL now = displayed(shown), dark = displayed(shown - lit * weight),
         bright = displayed(shown + (FLOATL(1) - lit) * weight);
  return (bright - now > FLOATL(DOUBT_SHOWN)) | (now - dark > FLOATL(DOUBT_SHOWN));
}

static inline IntL error_shows(Vec3L shown, Vec3L weight, FloatL lit, float scale)
{
  FloatL s = FLOATL(scale);
  return channel_shows(shown.x * s, weight.x * s, lit) | channel_shows(shown.y * s, weight.y * s, lit) |
         channel_shows(shown.z * s, weight.z * s, lit);
}

kernel void shadow_doubt(global const ShadowInfo *infos, global const ShadowView *views, global const float *maps,
                         global const ShadowInfo *finer_infos, global const ShadowView *finer_views,
                         global const float *finer_maps, uint has_finer, uint light, global const float *rays,
                         uint capacity, uint ray_count, uint segment, global const uint *slots,
                         global const TriangleCorners *corners, global const float *positions, float least_weight,
                         float scale, uint showing, global float4 *shown, global float *doubts)
{
  const LightMaps own = light_maps(infos, views, maps, light, false);
  const LightMaps asked = has_finer ? light_maps(finer_infos, finer_views, finer_maps, light, true) : own;
  rays += segment * RAY_FIELD_COUNT * capacity;
  slots += segment * capacity;
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint first = begin; first < end; first += LANES) {
    IntL active = stream_load_t_max(rays, capacity, first, ray_count) > FLOATL(0);
    Vec3L weight = stream_load3(rays, capacity, RAY_WEIGHT_R, first);
    active = active & (max_component3(weight) > FLOATL(least_weight));
    Vec3L point = stream_load3(rays, capacity, RAY_ORIGIN_X, first);
    UintL slot = LANE_LOAD(slots, first), id = LANE_AS_UINT(LANE_LOAD(rays + RAY_RECEIVER * capacity, first));
    const Receiver receiver = receiver_load(corners, positions, id, active);
    FloatL lit = shadow_lit(own.info, views, maps, point, receiver.normal, id, active);
    if (showing) {
      radiance_add(shown, slot, active, scale3(weight, lit));
      continue;
    }
    FloatL doubt = maps_doubt(&asked, point, &receiver, id, active, lit);
#ifdef HAS_DISC
    if (has_finer && own.info->method == SHADOW_BY_PCSS)
      doubt = max_lane(doubt, maps_doubt(&own, point, &receiver, id, active, lit));
#endif
    IntL doubted = active & (doubt > FLOATL(0));
    if (isfinite(scale) && any_lane(doubted))
      doubted = doubted & error_shows(radiance_load(shown, slot, doubted).rgb, weight, lit, scale);
    for (uint bits = lane_bits(doubted); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits), to = LANE_UINT(slot, lane);
      doubts[to] = max(doubts[to], LANE_FLOAT(doubt, lane));
    }
  }
}
