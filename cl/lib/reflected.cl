// Reflected rays of a stream, one by one: which cube map is their reflector's, and where they run relative to it.

#include "lib/cube.cl"
#include "lib/object.cl"
#include "lib/ray_stream.cl"

// The cubes by object, and the objects' triangles.
typedef struct ReflectorCubes {
  global const uint *object_starts;
  uint object_count;
  global const uint *cube_of_object;  // CUBE_NONE where an object has none; with CUBE_FOR_ROUGH
} ReflectorCubes;

// The cube of the reflector on which a ray starts that says so (RAY_FROM_MIRROR), with CUBE_FOR_ROUGH, or CUBE_NONE.
static inline uint reflector_any_cube(ReflectorCubes cubes, uint source)
{
  uint triangle = source & ~RAY_FROM_MIRROR;
  return cubes.cube_of_object[object_of_triangle(cubes.object_starts, cubes.object_count, triangle)];
}

// The same for a ray that a mirror sent: not those that rough surfaces alone ask.
static inline uint reflector_cube(ReflectorCubes cubes, uint source)
{
  uint number = reflector_any_cube(cubes, source);
  return number & CUBE_FOR_ROUGH ? CUBE_NONE : number;
}

static inline float3 lane_float3(Vec3L v, uint lane)
{
  return (float3)(LANE_FLOAT(v.x, lane), LANE_FLOAT(v.y, lane), LANE_FLOAT(v.z, lane));
}

// The fourth is 0.
static inline float4 lane_float4(Vec3L v, uint lane)
{
  return (float4)(LANE_FLOAT(v.x, lane), LANE_FLOAT(v.y, lane), LANE_FLOAT(v.z, lane), 0);
}

// `direction` is of unit length.
static inline CubeRay cube_ray(global const CubeInfo *cube, float3 origin, float3 direction)
{
  CubeRay ray = {origin - (float3)(cube->center.x, cube->center.y, cube->center.z), direction};
  return ray;
}
