// Reflected rays answered by the environment or by the cube map of the reflector that they start on.
//
//   in    rays, slots      reflected rays; those of mirrors say where they start (RAY_FROM_MIRROR)
//         cube_of_object   CUBE_NONE where an object has none, [object_count]
//         cubes, texels    shared/cube.h
//         hull, cells      the same; REFLECT_BY_IMPOSTOR alone
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
//   Cost  16 bytes x 4 a lookup.
//   The reflector itself is not in its cube: by the other methods it does not show itself.
//   A ray's radiance is added slot by slot in the order of launches: no atomics, the same sum on every run.
//   From  Blinn, Newell, "Texture and Reflection in Computer Generated Images", 1976; Greene, "Environment Mapping and
//         Other Applications of World Projections", 1986 (cube); Lagarde, Zanuttini, "Local Image-based Lighting with
//         Parallax-corrected Cubemaps", 2012 (box).

#include "lib/environment.cl"
#include "lib/impostor.cl"
#include "lib/radiance.cl"
#include "lib/reflected.cl"

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

kernel void cube_reflect(uint method, global const float *rays, global const uint *slots, uint capacity, uint ray_count,
                         global const uint *object_starts, uint object_count, global const uint *cube_of_object,
                         global const CubeInfo *cubes, global const float4 *texels, global const float *hull,
                         global const float *cells, constant EnvironmentInfo *environment,
                         global const Float4 *environment_pixels, global float4 *radiance, global float *left_rays,
                         global uint *left_slots, global uint *count)
{
  ReflectorCubes reflectors = {object_starts, object_count, cube_of_object};
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint first = begin; first < end; first += LANES) {
    ReflectedRays r = reflected_load(rays, slots, capacity, first, ray_count);
    IntL left = r.active & !r.mirrored;
    IntL open = method == REFLECT_BY_ENVIRONMENT ? r.mirrored : INTL(0);
    for (uint bits = lane_bits(r.mirrored & !open); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits);
      uint number = reflector_cube(reflectors, LANE_UINT(r.source, lane));
      float4 throughput = lane_float4(r.weight, lane);
      float4 value;
      bool answered = false;
      if (number != CUBE_NONE) {
        MarchMap map = march_map_of_cube(&cubes[number], texels, cells, hull);
        CubeRay ray = cube_ray(map.cube, lane_float3(r.origin, lane), lane_float3(r.unit, lane));
        answered = cube_answer(&value, method, &map, ray);
      }
      if (answered)
        radiance[LANE_UINT(r.slot, lane)] += throughput * value;
      else
        LANE_INT(left, lane) = -1;
    }
    if (any_lane(open)) {
      Vec3L seen = environment_radiance(environment, environment_pixels, r.unit, open);
      radiance_add(radiance, r.slot, open, mul3(seen, r.weight));
    }
    reflected_append(&r, left, left_rays, capacity, left_slots, count);
  }
}
