// Reflected rays answered by the environment or by the cube map of the reflector that they start on.
//
//   in    rays, slots      reflected rays; those of mirrors say where they start (RAY_FROM_MIRROR)
//         cube_of_object   of mirrors: CUBE_NONE where an object has none, [object_count]
//         rough_of_object  the same, of rough surfaces
//         cubes, texels    shared/cube.h
//         hull, cells      the same; REFLECT_BY_IMPOSTOR alone
//         levels           the same; of cubes that rough surfaces ask
//         environment_levels   the environment's (shared/scene.h)
//         rough_alone      1: rays of mirrors are left as they are
//         closed           1: no ray of a mirror is left: where a method cannot tell it sees the cube as if infinitely
//                          far away, without one the environment
//   out   radiance[slot]   weight x what the map shows
//         left_rays        the rays that are left to be traced, packed: those of rough surfaces, of objects without a
//                          cube, and those of which a method says itself that it cannot tell
//         count            of these
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
#include "lib/radiance.cl"
#include "lib/reflected.cl"

#define ROUGH_STEPS 24
#define ROUGH_LEAST 0.125f  // that distances are blurred by

// What a ray shows by its reflector's cube. False where that cannot tell.
static inline bool cube_answer(float4 *out, uint method, const MarchMap *map, CubeRay ray)
{
  CubePlace place;
  float3 towards = ray.direction;
  if (method == REFLECT_BY_IMPOSTOR) {
    float t;
    if (map_meet(&place, &t, map, ray, arc_of(ray), 0, INFINITY) == MARCH_UNSURE) return false;
  } else {
    if (method == REFLECT_BY_BOX && !box_direction(&towards, map->cube, ray)) return false;
    place = cube_place(map->cube, towards);
  }
  *out = cube_sample(map->texels, place);
  return true;
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

kernel void cube_reflect(uint method, uint rough_alone, uint closed, global const float *rays, global const uint *slots,
                         uint capacity, uint ray_count, global const uint *object_starts, uint object_count,
                         global const uint *cube_of_object, global const uint *rough_of_object, uint cube_count,
                         global const CubeInfo *cubes, global const float4 *texels, global const float *hull,
                         global const float *cells, global const float4 *levels, constant EnvironmentInfo *environment,
                         global const Float4 *environment_pixels, global const Float4 *environment_levels,
                         global float4 *radiance, global float *left_rays, global uint *left_slots, global uint *count)
{
  ReflectorCubes reflectors = {object_starts, object_count, cube_of_object};
  ReflectorCubes rough_ones = {object_starts, object_count, rough_of_object};
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint first = begin; first < end; first += LANES) {
    ReflectedRays r = reflected_load(rays, slots, capacity, first, ray_count);
    IntL rough = r.active & (r.reach <= FLOATL(1)), mirrored = rough_alone ? INTL(0) : r.mirrored & !rough;
    if (rough_alone) r.density = LANE_AS_FLOAT(r.source);
    IntL left = r.active & !(mirrored | rough), unmapped = INTL(0);
    IntL open = method == REFLECT_BY_ENVIRONMENT ? mirrored : INTL(0);
    for (uint bits = lane_bits(mirrored & !open); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits);
      uint number = reflector_cube(reflectors, LANE_UINT(r.source, lane));
      float4 throughput = lane_float4(r.weight, lane);
      float4 value;
      bool answered = false;
      if (number != CUBE_NONE) {
        MarchMap map = march_map_of_cube(&cubes[number], texels, cells, hull);
        CubeRay ray = cube_ray(map.cube, lane_float3(r.origin, lane), lane_float3(r.unit, lane));
        answered = cube_answer(&value, method, &map, ray);
        if (closed & !answered) answered = cube_answer(&value, REFLECT_BY_CUBE, &map, ray);
      }
      if (answered)
        radiance[LANE_UINT(r.slot, lane)] += throughput * value;
      else if (closed)
        LANE_INT(open, lane) = -1;
      else
        LANE_INT(left, lane) = -1;
    }
    for (uint bits = lane_bits(rough); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits);
      uint number = reflector_any_cube(rough_ones, LANE_UINT(r.source, lane)) & ~CUBE_FOR_ROUGH;
      if (number >= cube_count || cubes[number].first_level == CUBE_NONE) {
        LANE_INT(unmapped, lane) = -1;
        continue;
      }
      MarchMap map = march_map_of_cube(&cubes[number], texels, cells, 0);
      CubeRay ray = cube_ray(map.cube, lane_float3(r.origin, lane), lane_float3(r.unit, lane));
      float4 throughput = lane_float4(r.weight, lane);
      radiance[LANE_UINT(r.slot, lane)] +=
          throughput * rough_answer(method, &map, levels, ray, LANE_FLOAT(r.reach, lane));
    }
    if (any_lane(unmapped)) {
      Vec3L seen =
          environment_prefiltered(environment, environment_pixels, environment_levels, r.unit, r.reach, unmapped);
      radiance_add(radiance, r.slot, unmapped, mul3(seen, r.weight));
    }
    if (any_lane(open)) {
      Vec3L seen = environment_radiance(environment, environment_pixels, r.unit, open);
      radiance_add(radiance, r.slot, open, mul3(seen, r.weight));
    }
    reflected_append(&r, left, left_rays, capacity, left_slots, count);
  }
}
