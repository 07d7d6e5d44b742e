// What shadow maps may get wrong, told by the maps and the camera alone: no shadow ray is traced.
//
//   in    rays, slots          shadow rays of probes to `light`, [ray_count] of segment `segment`, with receivers
//         infos, views, maps   of all lights, as shading reads them (lib/shadow_lookup.cl)
//         corners, positions   the receivers' triangles
//         least_weight         rays that bring less radiance are not missed, and not doubted
//         scale                of radiance for display; INFINITY where that is not known
//         showing              1: no doubts, but shown[slot] gains what light arrives by the map
//         shown                what all lights so bring, which are shown by sRGB
//   out   doubts[slot]         the chance that the map's answer is wrong, where it is more than what is there
//
//   SHADOW_BY_TEXEL   |nearest texel's verdict - the four nearest texels', weighted bilinearly|; 1 where a texel's
//                     verdict is neither its left and right nor its upper and lower neighbour's
//   SHADOW_BY_PCF     1 where the kernel is neither all dark nor lit to 98 %
//   SHADOW_BY_PCSS    1 where the disc of the light's half-shadow and a texel more, or 3 x 3 texels, are neither
//
//   Why. Between the middles of a lit and a dark texel there is an edge of the shadow, and the map tells nothing of
//   where: let it be anywhere with the same chance. At a share u of the way from the lit one to the dark one the edge
//   is behind the point, which then is dark, with chance u; the nearest texel says lit up to u = 1/2: it is wrong with
//   chance min(u, 1 - u), 1/4 in the mean over both sides: a quarter of a texel for each texel of edge, which is the
//   known edge length x m / 4 (m: texels in pixels). In two dimensions the bilinear weights stand for u. Along one
//   straight edge u may stay the same, and the error be twice the mean: host/render/shadow_bound.h has that factor.
//   Averages of texels are ramps where the truth is a step: off by more than 2/255 nearly all along the ramp.
//   A caster of width w < 1 texels is drawn where it covers texels' middles, in a share w of the texels that it runs
//   through: each of them is wrong but for the caster's own width, and stands for as much that is missing elsewhere.
//   Hence the 1, which that factor doubles.
//   Where light grazes a surface a texel is drawn out along it (60-fold at one degree), and casters that are thinner
//   than that leave no trace: no less than DOUBT_GRAZED then. Angle and share were found by trial, on a wall that the
//   sun grazes (`frugal stability --only projective-aliasing`).
//
//   Knows only what the map holds. It misses casters thinner than a texel that no texel caught (host/render/
//   shadow_bound.h asks finer maps too); what is falsely lit by the bias where surfaces touch; and half-shadows wider
//   than the disc that PCSS searches (SHADOW_DISC_PX). A light is not doubted where it would not show beside the others
//   if it were all there, or not at all.
//   Cost  100 ns a ray on a core.
//   From  the argument above; Williams 1978, and Reeves, Salesin, Cook 1987, for what is doubted.

#include "lib/radiance.cl"
#include "lib/ray_stream.cl"
#include "lib/shadow_lookup.cl"
#include "shared/scene.h"

// Lit to more than this is lit: off by less than 2/255 once displayed.
#define DOUBT_LIT 0.98f

// A change of what is displayed from which on it counts: half of the 2/255, as other lights may be wrong there too.
#define DOUBT_SHOWN (1.0f / 255)

// Sine of 0.9 degrees between light and surface, and what is doubted below that at the least.
#define DOUBT_GRAZING 0.0157f
#define DOUBT_GRAZED 0.15f

static inline FloatL texel_doubt(global const ShadowInfo *info, global const float *map, const MapPoint *at,
                                 const PlaneDepth *plane, UintL id, IntL group)
{
  uint size = info->size_px;
  IntL x = LANE_CONVERT_INT(floor(at->x)), y = LANE_CONVERT_INT(floor(at->y)), one = INTL(1);
  FloatL lit = texel_lit(map, size, at, plane, x, y);
  FloatL doubt = fabs(lit - lit_by_kernel(map, size, 1, at, plane, id, group));
  FloatL left = texel_lit(map, size, at, plane, x - one, y), right = texel_lit(map, size, at, plane, x + one, y);
  FloatL above = texel_lit(map, size, at, plane, x, y - one), below = texel_lit(map, size, at, plane, x, y + one);
  IntL thin = ((left != lit) & (right != lit)) | ((above != lit) & (below != lit));
  return thin ? FLOATL(1) : doubt;
}

static inline FloatL ramp_doubt(FloatL lit)
{
  return ((lit > FLOATL(0)) & (lit < FLOATL(DOUBT_LIT))) ? FLOATL(1) : FLOATL(0);
}

#ifdef HAS_DISC
static inline FloatL disc_doubt(global const ShadowInfo *info, global const ShadowView *view, global const float *map,
                                const MapPoint *at, const PlaneDepth *plane, UintL id, IntL group)
{
  uint size = info->size_px;
  if (!(info->radius > 0)) return ramp_doubt(lit_by_kernel(map, size, 1, at, plane, id, group));
  FloatL doubt = ramp_doubt(lit_by_kernel(map, size, 3, at, plane, id, group));
  FloatL radius = half_shadow_px(info, view, map, at, plane) + FLOATL(1), sum = FLOATL(0);
  for (uint i = 0; i < SHADOW_DISC_TAPS; i++) {
    Float2 tap = disc_taps[i];
    IntL x = LANE_CONVERT_INT(floor(at->x + radius * FLOATL(tap.x)));
    IntL y = LANE_CONVERT_INT(floor(at->y + radius * FLOATL(tap.y)));
    sum += texel_lit(map, size, at, plane, x, y);
  }
  return max_lane(doubt, ramp_doubt(sum * FLOATL(1.0f / SHADOW_DISC_TAPS)));
}
#endif

static inline FloatL lookup_doubt(global const ShadowInfo *info, global const ShadowView *view, global const float *map,
                                  const MapPoint *at, const PlaneDepth *plane, UintL id, IntL group)
{
#ifdef HAS_DISC
  if (info->method == SHADOW_BY_PCSS) return disc_doubt(info, view, map, at, plane, id, group);
#endif
  if (info->method == SHADOW_BY_TEXEL) return texel_doubt(info, map, at, plane, id, group);
  return ramp_doubt(lit_by_kernel(map, info->size_px, info->kernel_px, at, plane, id, group));
}

// Normals of the lanes' triangles, of any length.
static inline Vec3L triangle_normals(global const TriangleCorners *corners, global const float *positions, UintL id,
                                     IntL mask)
{
  Vec3L normal = vec3l(FLOATL(0), FLOATL(0), FLOATL(0));
  for (uint bits = lane_bits(mask); bits;) {
    uint triangle = LANE_UINT(id, lowest_bit(bits));
    IntL group = mask & (id == UINTL(triangle));
    bits &= ~lane_bits(group);
    global const uint *vertex = corners[triangle].vertex;
    float3 a = vload3(vertex[0], positions), b = vload3(vertex[1], positions) - a, c = vload3(vertex[2], positions) - a;
    FloatL x = FLOATL(b.y * c.z - b.z * c.y), y = FLOATL(b.z * c.x - b.x * c.z), z = FLOATL(b.x * c.y - b.y * c.x);
    normal = select3(group, vec3l(x, y, z), normal);
  }
  return normal;
}

// Does light graze the receiver's plane?
static inline IntL is_grazed(global const ShadowView *view, Vec3L point, Vec3L normal)
{
  Float3 axis = view->axis;
  Vec3L along = vec3l(FLOATL(axis.x), FLOATL(axis.y), FLOATL(axis.z));
  if (!view->raster.parallel) along = shadow_relative(view, point);
  FloatL across = dot3(along, normal);
  return across * across < FLOATL(DOUBT_GRAZING * DOUBT_GRAZING) * dot3(along, along) * dot3(normal, normal);
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
                         uint light, global const float *rays, uint capacity, uint ray_count, uint segment,
                         global const uint *slots, global const TriangleCorners *corners, global const float *positions,
                         float least_weight, float scale, uint showing, global float4 *shown, global float *doubts)
{
  global const ShadowInfo *info = &infos[light];
  global const ShadowView *of_light = views + info->first_view;
  global const float *maps_of_light = maps + info->first_texel;
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
    Vec3L normal = triangle_normals(corners, positions, id, active);
    FloatL lit = shadow_lit(info, views, maps, point, normal, id, active);
    if (showing) {
      radiance_add(shown, slot, active, scale3(weight, lit));
      continue;
    }
    UintL chosen = shadow_view_choose(info, of_light, point);
    FloatL doubt = FLOATL(0);
    for (uint bits = lane_bits(active & (chosen != UINTL(SHADOW_VIEW_NONE))); bits;) {
      uint number = LANE_UINT(chosen, lowest_bit(bits));
      IntL group = active & (chosen == UINTL(number));
      bits &= ~lane_bits(group);
      global const ShadowView *view = &of_light[number];
      global const float *map = maps_of_light + number * info->size_px * info->size_px;
      ShadowLookup lookup = shadow_lookup(info, view, point, normal);
      FloatL of_view = lookup_doubt(info, view, map, &lookup.at, &lookup.plane, id, group);
      IntL grazed = is_grazed(view, point, normal);
      of_view = grazed ? max_lane(of_view, FLOATL(DOUBT_GRAZED)) : of_view;
      doubt = group ? of_view : doubt;
    }
    IntL doubted = active & (doubt > FLOATL(0));
    if (isfinite(scale) && any_lane(doubted))
      doubted = doubted & error_shows(radiance_load(shown, slot, doubted).rgb, weight, lit, scale);
    for (uint bits = lane_bits(doubted); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits), to = LANE_UINT(slot, lane);
      doubts[to] = max(doubts[to], LANE_FLOAT(doubt, lane));
    }
  }
}
