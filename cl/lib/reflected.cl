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

// LANES rays of a stream from `first` on.
typedef struct ReflectedRays {
  UintL slot, source;       // source: of rays of mirrors, RAY_FROM_MIRROR and the triangle
  FloatL density;           // for rays that are left
  FloatL reach;             // t_max; up to 1: the roughness of a surface that asks about its lobe's axis
  IntL active, mirrored;    // mirrored: those of mirrors
  Vec3L origin, direction;  // in the length that t counts in
  Vec3L unit, weight;       // direction of unit length
} ReflectedRays;

static inline ReflectedRays reflected_load(global const float *rays, global const uint *slots, uint capacity,
                                           uint first, uint ray_count)
{
  ReflectedRays r;
  FloatL density = LANE_LOAD(rays + RAY_DENSITY * capacity, first);
  r.slot = LANE_LOAD(slots, first);
  r.source = LANE_AS_UINT(density);
  r.reach = stream_load_t_max(rays, capacity, first, ray_count);
  r.active = r.reach > FLOATL(0);
  r.mirrored = r.active & ((r.source & UINTL(RAY_FROM_MIRROR)) != UINTL(0));
  r.density = r.mirrored ? FLOATL(INFINITY) : density;
  r.origin = stream_load3(rays, capacity, RAY_ORIGIN_X, first);
  r.direction = stream_load3(rays, capacity, RAY_DIRECTION_X, first);
  r.unit = unit3(r.direction);
  r.weight = stream_load3(rays, capacity, RAY_WEIGHT_R, first);
  return r;
}

// Adds the rays of `lanes` to another stream. Returns the place of the first there.
static inline uint reflected_append(const ReflectedRays *r, IntL lanes, global float *to_rays, uint capacity,
                                    global uint *to_slots, global uint *count)
{
  return stream_append_path(lanes, r->origin, r->direction, FLOATL(INFINITY), r->weight, r->slot, true, r->density,
                            to_rays, capacity, to_slots, count);
}
