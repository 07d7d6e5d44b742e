// Reflected rays answered by the environment or by the cube map of the reflector that they start on.
//
//   in    rays, slots      reflected rays; those of mirrors say where they start (RAY_FROM_MIRROR)
//         cube_of_object   CUBE_NONE where an object has none, [object_count]
//         cubes, texels    shared/cube.h
//         hull, cells      the same; REFLECT_BY_IMPOSTOR and REFLECT_BY_HYBRID alone
//         doubts, names    the same; REFLECT_BY_HYBRID alone, as what follows
//         levels           the same; of cubes that rough surfaces ask
//         environment_levels   the environment's (shared/scene.h)
//         rough_alone      1: rays of mirrors are left as they are
//         positions, corners, materials   of the scene's triangles
//         scale, allowed   of radiance for display (INFINITY: not known), and how far off that may be
//   out   radiance[slot]   weight x what the map shows
//         left_rays        the rays that are left to be traced, packed: those of rough surfaces, of objects without a
//                          cube, and those of which a method says itself that it cannot tell
//         named_rays, _slots, _hits, _ids   those that need not be traced but must be shaded, packed, and what they hit
//         counts           of rays that are left, and of those that are named
//
//   REFLECT_BY_ENVIRONMENT  what lies in the ray's direction beyond the scene. Fails wherever the scene stands before
//                           it.
//   REFLECT_BY_CUBE         what the cube shows in the ray's direction, as if all of it were infinitely far away. The
//                           error is that of host/plan/cube_error.h.
//   REFLECT_BY_BOX          what it shows where the ray meets the box. Exact (but for the texels) where that is where
//                           the walls are; what stands within the box is displaced, more than by REFLECT_BY_CUBE where
//                           it is near. Rays that start outside the box are left.
//   REFLECT_BY_IMPOSTOR     what it shows where the ray goes behind the surface that the cube saw. Cost, and which rays
//                           are left: lib/impostor.cl.
//
//   What a rough surface reflects comes as one ray about its lobe's axis, which is never left: it sees the cube's
//   levels, where the axis ends by the method, as rough as the lobe is wide from the cube's centre: alpha x (way of the
//   ray) / (distance from the centre), for what is near is seen sharper. Where the impostor cannot tell, the axis ends
//   at the mean distances that the levels show. Rays that start outside the box see the cube as if infinitely far away,
//   those without a cube the environment's levels.
//
//   REFLECT_BY_HYBRID       the same where the picture would not be off by more than what is allowed (cube_doubt.cl).
//                           Elsewhere the exact hit on one of the triangles that the four texels name, if there is one
//                           within HYBRID_NEAR of the place; the others are left, as are rays that are under the
//                           reflector's surface by more than HULL_SLACK_HYBRID. Rays that meet nothing see the
//                           environment itself. Fails where no texel saw a thing.
//
//   Cost  16 bytes x 4 a lookup.
//   The reflector itself is not in its cube: by the other methods it does not show itself.
//   A ray's radiance is added slot by slot in the order of launches: no atomics, the same sum on every run.
//   Fails for rough surfaces as the split sum: the lobe is round and not cut at the horizon, and what is near fills all
//         of it or none.
//   From  Blinn, Newell, "Texture and Reflection in Computer Generated Images", 1976; Greene, "Environment Mapping and
//         Other Applications of World Projections", 1986 (cube); Lagarde, Zanuttini, "Local Image-based Lighting with
//         Parallax-corrected Cubemaps", 2012 (box); Lagarde, de Rousiers, "Moving Frostbite to Physically Based
//         Rendering", 2014 (roughness by distance).

#include "lib/environment.cl"
#include "lib/impostor.cl"
#include "lib/named_hit.cl"
#include "lib/radiance.cl"
#include "lib/reflected.cl"

#define HULL_SLACK_HYBRID 3e-4f
#define HYBRID_NEAR 0.05f
#define ROUGH_STEPS 24
#define ROUGH_LEAST 0.125f  // that distances are blurred by

#define ANSWER_LEFT 0  // to be traced
#define ANSWER_GIVEN 1
#define ANSWER_OPEN 2   // nothing but the environment is there
#define ANSWER_NAMED 3  // to be shaded

// What hybrid reflections are told.
typedef struct HybridTerms {
  NamedTriangles triangles;
  global const float2 *doubts;
  global const uint *names;
  float scale, allowed;
} HybridTerms;

// The hit of a ray on what the texels about a place name, if it is there.
static inline bool named_at(NamedHit *out, const MarchMap *map, CubePlace place, CubeRay ray, const HybridTerms *terms,
                            float3 origin, float3 direction)
{
  uint names[NAMED_MOST], within = (place.texel - map->cube->first_texel) % (place.size * place.size);
  uint column = within % place.size, row = within / place.size;
  if (column == 0 || row == 0 || column + 2 >= place.size || row + 2 >= place.size) return false;
  for (uint i = 0; i < NAMED_MOST; i++)
    names[i] = terms->names[place.texel + (i / 4 - 1) * place.size + i % 4 - 1] & ~CUBE_STEPPED;
  *out = named_hit(names, &terms->triangles, origin, direction);
  if (out->id == HIT_NONE) return false;
  CubePlace there = cube_place(map->cube, ray.origin + direction * out->t);
  float ratio = cube_depth(map->texels, place).here * there.major;
  return ratio > 1 - HYBRID_NEAR && ratio < 1 + HYBRID_NEAR;
}

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
static inline float aside_share(const MarchMap *map, CubeRay ray)
{
  float aside = length(ray.origin - ray.direction * dot(ray.origin, ray.direction)) / map->cube->reach_m;
  return max(aside, min(2 * aside, 1.0f));
}

// What a ray of that weight shows by its reflector's cube, for REFLECT_BY_HYBRID.
static inline int hybrid_answer(float4 *out, NamedHit *named, const MarchMap *map, CubeRay ray, float3 origin,
                                float3 direction, float3 weight, const HybridTerms *terms)
{
  CubePlace place;
  float t;
  if (map_meet(&place, &t, map, ray, arc_of(ray), 0, INFINITY) == MARCH_UNSURE) return ANSWER_LEFT;
  if (terms->names[place.texel] & CUBE_STEPPED) return ANSWER_LEFT;
  if (cube_depth(map->texels, place).most <= 0) return ANSWER_OPEN;
  float2 doubt = terms->doubts[place.texel];
  *out = cube_sample(map->texels, place);
  float3 off = weight * (doubt.x + doubt.y * aside_share(map, ray));
  if (shown_off(weight * out->xyz, off, terms->scale) <= terms->allowed) return ANSWER_GIVEN;
  bool is_named = named_at(named, map, place, ray, terms, origin, direction);
  return is_named ? ANSWER_NAMED : ANSWER_LEFT;
}

// The same for other methods.
static inline int cube_answer(float4 *out, uint method, const MarchMap *map, CubeRay ray)
{
  CubePlace place;
  float3 towards = ray.direction;
  if (method == REFLECT_BY_IMPOSTOR) {
    float t;
    if (map_meet(&place, &t, map, ray, arc_of(ray), 0, INFINITY) == MARCH_UNSURE) return ANSWER_LEFT;
  } else {
    if (method == REFLECT_BY_BOX && !box_direction(&towards, map->cube, ray)) return ANSWER_LEFT;
    place = cube_place(map->cube, towards);
  }
  *out = cube_sample(map->texels, place);
  return ANSWER_GIVEN;
}

// Where a ray ends of which the march cannot tell: where it goes behind the mean distances that the level shows, which
// have no outlines, looked at after each of ROUGH_STEPS even turns. False where it does not.
static inline bool rough_end(float3 *end, const MarchMap *map, global const float4 *levels, CubeRay ray,
                             float roughness)
{
  CubeArc arc = arc_of(ray);
  float turn = acos(clamp(arc.cosine, -1.0f, 1.0f)) / ROUGH_STEPS, gap_before = -1;
  float2 angle = (float2)(1, 0), step = (float2)(cos(turn), sin(turn));
  if (arc.straight) return false;
  for (uint i = 1; i <= ROUGH_STEPS; i++) {
    float2 last = angle;
    angle = turned(angle, step);
    bool whole = i == ROUGH_STEPS;
    float3 towards = whole ? ray.direction : arc.e * angle.x + arc.n * angle.y;
    float inverse = whole ? 0 : (angle.x - arc.cotangent * angle.y) / arc.reach;
    float gap = inverse - cube_prefiltered(map->cube, map->texels, levels, towards, max(roughness, ROUGH_LEAST)).w;
    if (gap < 0 && gap_before >= 0) {
      float2 at = mix(last, angle, gap_before / (gap_before - gap));
      float t = arc_distance(arc, at * rsqrt(dot(at, at)));
      *end = ray.origin + t * ray.direction;
      return t < INFINITY;
    }
    gap_before = gap;
  }
  return false;
}

// What a rough surface reflects about a ray.
static inline float4 rough_answer(uint method, const MarchMap *map, global const float4 *levels, CubeRay ray,
                                  float roughness)
{
  CubePlace place;
  float t;
  float3 end = ray.direction;
  bool ends = false;
  if (method == REFLECT_BY_BOX) ends = box_direction(&end, map->cube, ray);
  if (method == REFLECT_BY_IMPOSTOR) {
    int state = map_meet(&place, &t, map, ray, arc_of(ray), 0, INFINITY);
    ends = state == MARCH_HIT;
    if (ends) end = ray.origin + t * ray.direction;
    if (state == MARCH_UNSURE) ends = rough_end(&end, map, levels, ray, roughness);
  }
  if (ends) roughness *= sqrt(distance(end, ray.origin) / length(end));
  return cube_prefiltered(map->cube, map->texels, levels, ends ? end : ray.direction, min(roughness, 1.0f));
}

kernel void cube_reflect(uint method, uint rough_alone, global const float *rays, global const uint *slots,
                         uint capacity, uint ray_count, global const uint *object_starts, uint object_count,
                         global const uint *cube_of_object, uint cube_count, global const CubeInfo *cubes,
                         global const float4 *texels, global const float *hull, global const float *cells,
                         global const float4 *levels, global const float2 *doubts, global const uint *names,
                         float scale, float allowed, global const float *positions,
                         global const TriangleCorners *corners, global const MaterialInfo *materials,
                         constant EnvironmentInfo *environment, global const Float4 *environment_pixels,
                         global const Float4 *environment_levels, global float4 *radiance, global float *left_rays,
                         global uint *left_slots, global float *named_rays, global uint *named_slots,
                         global float *named_hits, global uint *named_ids, global uint *counts)
{
  ReflectorCubes reflectors = {object_starts, object_count, cube_of_object};
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  HybridTerms terms = {{positions, corners, materials}, doubts, names, scale, allowed};
  for (uint first = begin; first < end; first += LANES) {
    UintL slot = LANE_LOAD(slots, first);
    FloatL density = LANE_LOAD(rays + RAY_DENSITY * capacity, first);
    UintL source = LANE_AS_UINT(density);
    FloatL reach = stream_load_t_max(rays, capacity, first, ray_count);
    IntL active = reach > FLOATL(0), rough = active & (reach <= FLOATL(1));
    IntL mirrored = active & !rough & ((source & UINTL(RAY_FROM_MIRROR)) != UINTL(0));
    if (rough_alone) mirrored = INTL(0);
    IntL left = active & !(mirrored | rough), unmapped = INTL(0);
    Vec3L origin = stream_load3(rays, capacity, RAY_ORIGIN_X, first);
    Vec3L direction = stream_load3(rays, capacity, RAY_DIRECTION_X, first), unit = unit3(direction);
    Vec3L weight = stream_load3(rays, capacity, RAY_WEIGHT_R, first);
    IntL open = method == REFLECT_BY_ENVIRONMENT ? mirrored : INTL(0);
    for (uint bits = lane_bits(mirrored & !open); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits);
      uint number = reflector_cube(reflectors, LANE_UINT(source, lane));
      float4 throughput = lane_float4(weight, lane);
      float4 value;
      int answer = ANSWER_LEFT;
      if (number != CUBE_NONE) {
        MarchMap map = march_map_of_cube(&cubes[number], texels, cells, hull);
        if (method == REFLECT_BY_HYBRID) map.hull_slack = HULL_SLACK_HYBRID;
        float3 from = lane_float3(origin, lane);
        CubeRay ray = cube_ray(map.cube, from, lane_float3(unit, lane));
        NamedHit named;
        if (method == REFLECT_BY_HYBRID)
          answer = hybrid_answer(&value, &named, &map, ray, from, lane_float3(direction, lane), throughput.xyz, &terms);
        else
          answer = cube_answer(&value, method, &map, ray);
        if (answer == ANSWER_NAMED)
          named_append(&named, rays, slots, capacity, first + lane, named_rays, named_slots, named_hits, named_ids,
                       &counts[1]);
      }
      if (answer == ANSWER_LEFT) LANE_INT(left, lane) = -1;
      if (answer == ANSWER_OPEN) LANE_INT(open, lane) = -1;
      if (answer == ANSWER_GIVEN) radiance[LANE_UINT(slot, lane)] += throughput * value;
    }
    for (uint bits = lane_bits(rough); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits);
      uint number = reflector_any_cube(reflectors, LANE_UINT(source, lane)) & ~CUBE_FOR_ROUGH;
      if (number >= cube_count || cubes[number].first_level == CUBE_NONE) {
        LANE_INT(unmapped, lane) = -1;
        continue;
      }
      MarchMap map = march_map_of_cube(&cubes[number], texels, cells, 0);
      CubeRay ray = cube_ray(map.cube, lane_float3(origin, lane), lane_float3(unit, lane));
      float4 throughput = lane_float4(weight, lane);
      radiance[LANE_UINT(slot, lane)] += throughput * rough_answer(method, &map, levels, ray, LANE_FLOAT(reach, lane));
    }
    if (any_lane(unmapped)) {
      Vec3L seen = environment_prefiltered(environment, environment_pixels, environment_levels, unit, reach, unmapped);
      radiance_add(radiance, slot, unmapped, mul3(seen, weight));
    }
    if (any_lane(open)) {
      Vec3L seen = environment_radiance(environment, environment_pixels, unit, open);
      radiance_add(radiance, slot, open, mul3(seen, weight));
    }
    density = mirrored ? FLOATL(INFINITY) : density;
    stream_append_path(left, origin, direction, FLOATL(INFINITY), weight, slot, true, density, left_rays, capacity,
                       left_slots, &counts[0]);
  }
}
