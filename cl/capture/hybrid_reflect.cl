// Hybrid reflections: reflected rays answered by the cube map of the reflector that they start on where that is right,
// and shaded, or traced, where it is not.
//
//   in    rays, slots      reflected rays; those of mirrors say where they start (RAY_FROM_MIRROR)
//         cube_of_object   CUBE_NONE where an object has none, [object_count]
//         cubes, texels, doubts, names   shared/cube.h
//         scale, allowed   of radiance for display (INFINITY: not known), and how far off that may be
//         own_hits, own_ids   by ray: what near_trace found of the reflector itself
//         infos .. rows    by cube: what else stands about it, triangle by triangle (lib/sure_march.cl)
//         triangles        in the order of the BVH's leaves
//   out   radiance[slot]   weight x what the map shows
//         left_rays        the rays that are left to be traced, packed: those of rough surfaces, of objects without a
//                          cube, and those of which the lists say themselves that they cannot tell
//         named_rays, _slots, _hits, _ids   those that need not be traced but must be shaded, packed, and what they hit
//         counts           of rays that are left, and of those that are named
//
//   What a ray meets is what rays say that it meets. If the four texels about that place, as seen from the cube's
//   centre, show the same triangle, and what they show cannot be off by more than what is allowed (cube_doubt.cl), they
//   are what the ray shows. Else the hit is shaded. Rays that meet nothing see the environment.
//
//   Cost  that of lib/sure_march.cl; 16 bytes x 4 a ray that hits something.
//   Fails where something of the same triangle lies between texels: a shadow's tip, a texture finer than them, a narrow
//         highlight.

#include "lib/cube.cl"
#include "lib/environment.cl"
#include "lib/radiance.cl"
#include "lib/reflected.cl"
#include "lib/sure_march.cl"

#define ANSWER_LEFT 0  // to be traced
#define ANSWER_GIVEN 1
#define ANSWER_OPEN 2   // nothing but the environment is there
#define ANSWER_NAMED 3  // to be shaded

// What the cubes' texels know.
typedef struct HybridTexels {
  global const float4 *texels;
  global const float2 *doubts;
  global const uint *names;
  float scale, allowed;
} HybridTexels;

static inline float3 shown3(float3 linear)
{
  float3 low = linear * 12.92f, high = 1.055f * powr(max(linear, 1e-6f), 1 / 2.4f) - 0.055f;
  return linear <= 0.0031308f ? low : high;
}

// What a radiance that may be `off` makes wrong on a display, times `scale`; INFINITY: by the exposure under which that
// is the most, if it does not blow out.
static inline float shown_off(float3 radiance, float3 off, float scale)
{
  float3 most = radiance + off, least = max(radiance - off, 0.0f);
  float brightest = max(max(most.x, most.y), most.z);
  if (!(brightest < INFINITY)) return INFINITY;
  if (scale == INFINITY) scale = brightest > 0 ? 1 / brightest : 0;
  float3 shown = shown3(radiance * scale) - shown3(least * scale);
  return max(max(shown.x, shown.y), shown.z);
}

// How far beside the centre a ray passes, in parts of the reflector's reach: so much of a change is taken to be seen,
// and twice as much, up to all of it, as it may come early.
static inline float aside_share(global const CubeInfo *cube, CubeRay ray)
{
  float aside = length(ray.origin - ray.direction * dot(ray.origin, ray.direction)) / cube->reach_m;
  return max(aside, min(2 * aside, 1.0f));
}

// Do all of the four texels about a place show the triangle?
static inline bool is_shown(global const uint *names, CubePlace place, uint id)
{
  global const uint *upper = names + place.texel, *lower = upper + place.size;
  return upper[0] == id && upper[1] == id && lower[0] == id && lower[1] == id;
}

// Is what the texels show of a hit right? If so it is *out.
static inline bool is_given(float4 *out, const HybridTexels *maps, global const CubeInfo *cube, const NamedHit *hit,
                            CubeRay ray, float3 direction, float3 weight)
{
  CubePlace place = cube_place(cube, ray.origin + direction * hit->t);
  if (!is_shown(maps->names, place, hit->id)) return false;
  float2 doubt = maps->doubts[place.texel];
  *out = cube_sample(maps->texels, place);
  float3 off = weight * (doubt.x + doubt.y * aside_share(cube, ray));
  return shown_off(weight * out->xyz, off, maps->scale) <= maps->allowed;
}

static inline NamedHit hit_of(global const float *hits, global const uint *ids, uint capacity, uint at)
{
  NamedHit none = {INFINITY, 0, 0, HIT_NONE};
  NamedHit hit = {hits[HIT_T * capacity + at], hits[HIT_U * capacity + at], hits[HIT_V * capacity + at], ids[at]};
  return hit.id == HIT_NONE ? none : hit;
}

kernel void hybrid_reflect(global const float *rays, global const uint *slots, uint capacity, uint ray_count,
                           global const float *own_hits, global const uint *own_ids, global const uint *object_starts,
                           uint object_count, global const uint *cube_of_object, global const CubeInfo *cubes,
                           global const float4 *texels, global const float2 *doubts, global const uint *names,
                           float scale, float allowed, global const ShadowInfo *infos, global const ShadowView *views,
                           global const ShadowTile *tiles, global const ShadowBlock *blocks,
                           global const ShadowRow *rows, uint block_count, global const BvhTriangle *triangles,
                           constant EnvironmentInfo *environment, global const Float4 *environment_pixels,
                           global float4 *radiance, global float *left_rays, global uint *left_slots,
                           global float *named_rays, global uint *named_slots, global float *named_hits,
                           global uint *named_ids, global uint *counts)
{
  ReflectorCubes reflectors = {object_starts, object_count, cube_of_object};
  HybridTexels maps = {texels, doubts, names, scale, allowed};
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint first = begin; first < end; first += LANES) {
    ReflectedRays r = reflected_load(rays, slots, capacity, first, ray_count);
    IntL left = r.active & !r.mirrored;
    IntL open = INTL(0);
    for (uint bits = lane_bits(r.mirrored); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits);
      uint number = reflector_cube(reflectors, LANE_UINT(r.source, lane));
      float4 throughput = lane_float4(r.weight, lane), value;
      NamedHit hit;
      int answer = ANSWER_LEFT;
      if (number != CUBE_NONE) {
        float3 from = lane_float3(r.origin, lane), along = lane_float3(r.direction, lane);
        CubeRay ray = cube_ray(&cubes[number], from, lane_float3(r.unit, lane));
        global const ShadowInfo *info = &infos[number];
        const SureLists lists = {info, views + info->first_view, tiles, blocks, rows, block_count, triangles};
        hit = hit_of(own_hits, own_ids, capacity, first + lane);
        int meets = sure_meet(&hit, &lists, from, along);
        if (meets == MEETS_NOTHING) answer = ANSWER_OPEN;
        if (meets == MEETS_HIT)
          answer =
              is_given(&value, &maps, &cubes[number], &hit, ray, along, throughput.xyz) ? ANSWER_GIVEN : ANSWER_NAMED;
      }
      if (answer == ANSWER_NAMED)
        named_append(&hit, rays, slots, capacity, first + lane, named_rays, named_slots, named_hits, named_ids,
                     &counts[1]);
      if (answer == ANSWER_LEFT) LANE_INT(left, lane) = -1;
      if (answer == ANSWER_OPEN) LANE_INT(open, lane) = -1;
      if (answer == ANSWER_GIVEN) radiance[LANE_UINT(r.slot, lane)] += throughput * value;
    }
    if (any_lane(open)) {
      Vec3L seen = environment_radiance(environment, environment_pixels, r.unit, open);
      radiance_add(radiance, r.slot, open, mul3(seen, r.weight));
    }
    reflected_append(&r, left, left_rays, capacity, left_slots, &counts[0]);
  }
}
