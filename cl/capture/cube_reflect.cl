// Reflected rays answered by the environment or by the cube map of the reflector that they start on.
//
//   in    rays, slots      reflected rays; those of mirrors say where they start (RAY_FROM_MIRROR)
//         cube_of_object   CUBE_NONE where an object has none, [object_count]
//         cubes, texels    shared/cube.h
//         hull, cells      the same; REFLECT_BY_IMPOSTOR alone
//   out   radiance[slot]   weight x what the map shows
//         left_rays        the rays that are left to be traced, packed: those of rough surfaces, of objects without a
//                          cube, and those of which a method says itself that it cannot tell
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
#include "lib/reflected.cl"

// What a ray shows by its reflector's cube. False: it is left to be traced.
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
    UintL slot = LANE_LOAD(slots, first);
    FloatL density = LANE_LOAD(rays + RAY_DENSITY * capacity, first);
    UintL source = LANE_AS_UINT(density);
    IntL active = stream_load_t_max(rays, capacity, first, ray_count) > FLOATL(0);
    IntL mirrored = active & ((source & UINTL(RAY_FROM_MIRROR)) != UINTL(0)), left = active & !mirrored;
    Vec3L origin = stream_load3(rays, capacity, RAY_ORIGIN_X, first);
    Vec3L direction = unit3(stream_load3(rays, capacity, RAY_DIRECTION_X, first));
    Vec3L weight = stream_load3(rays, capacity, RAY_WEIGHT_R, first);
    Vec3L seen = vec3l(FLOATL(0), FLOATL(0), FLOATL(0));
    if (method == REFLECT_BY_ENVIRONMENT && any_lane(mirrored))
      seen = environment_radiance(environment, environment_pixels, direction, mirrored);
    for (uint bits = lane_bits(mirrored); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits);
      float4 value = (float4)(LANE_FLOAT(seen.x, lane), LANE_FLOAT(seen.y, lane), LANE_FLOAT(seen.z, lane), 0);
      if (method != REFLECT_BY_ENVIRONMENT) {
        uint number = reflector_cube(reflectors, LANE_UINT(source, lane));
        bool answered = number != CUBE_NONE;
        if (answered) {
          global const CubeInfo *cube = &cubes[number];
          MarchMap map = march_map_of_cube(cube, texels, cells, hull);
          CubeRay ray = cube_ray(cube, lane_float3(origin, lane), lane_float3(direction, lane));
          answered = cube_answer(&value, method, &map, ray);
        }
        if (!answered) {
          LANE_INT(left, lane) = -1;
          continue;
        }
      }
      float4 throughput = lane_float4(weight, lane);
      radiance[LANE_UINT(slot, lane)] += throughput * value;
    }
    density = mirrored ? FLOATL(INFINITY) : density;
    stream_append_path(left, origin, stream_load3(rays, capacity, RAY_DIRECTION_X, first), FLOATL(INFINITY), weight,
                       slot, true, density, left_rays, capacity, left_slots, count);
  }
}
