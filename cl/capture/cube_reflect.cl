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
//   REFLECT_BY_IMPOSTOR     what it shows where the ray goes behind the surface that the cube saw: marched in strides
//                           of CUBE_STRIDE texels, texel by texel where a cell holds something as close as the ray, and
//                           halved IMPOSTOR_HALVINGS times. Left are rays that come behind any of four texels that show
//                           more than one surface (silhouettes, and what they hide), rays that start behind one, and
//                           those that are under the reflector's own outermost surface on their way. Fails where no
//                           texel saw a thing, and where the reflector shows itself from hollows of less than
//                           HULL_SLACK of the distance from its centre.
//
//   Cost  16 bytes x 4 a lookup; by the impostor 4 bytes a stride, up to size / 2 of them, and 64 a texel of the way.
//   The reflector itself is not in its cube: by the other methods it does not show itself.
//   A ray's radiance is added slot by slot in the order of launches: no atomics, the same sum on every run.
//   From  Blinn, Newell, "Texture and Reflection in Computer Generated Images", 1976; Greene, "Environment Mapping and
//         Other Applications of World Projections", 1986 (cube); Lagarde, Zanuttini, "Local Image-based Lighting with
//         Parallax-corrected Cubemaps", 2012 (box); Szirmay-Kalos, Aszodi, Lazanyi, Premecz, "Approximate Ray-Tracing
//         on the GPU with Distance Impostors", 2005 (impostor).

#include "lib/cube.cl"
#include "lib/environment.cl"
#include "lib/object.cl"
#include "lib/ray_stream.cl"

#define IMPOSTOR_HALVINGS 8
#define IMPOSTOR_EVENNESS 0.8f
#define HULL_SLACK 0.02f

// A ray relative to a cube's centre.
typedef struct CubeRay {
  float3 origin, direction;  // the direction is of unit length
} CubeRay;

// The direction in which a ray leaves the cube's box. False where it starts outside.
static inline bool box_direction(float3 *out, global const CubeInfo *cube, CubeRay ray)
{
  float3 low = (float3)(cube->low.x, cube->low.y, cube->low.z);
  float3 high = (float3)(cube->high.x, cube->high.y, cube->high.z);
  if (any(ray.origin < low) || any(ray.origin > high)) return false;
  float3 wall = (float3)(ray.direction.x > 0 ? high.x : low.x, ray.direction.y > 0 ? high.y : low.y,
                         ray.direction.z > 0 ? high.z : low.z);
  float3 t = (wall - ray.origin) / ray.direction;
  float nearest = INFINITY;  // t of a component that does not move is infinite, or no number
  nearest = t.x < nearest ? t.x : nearest;
  nearest = t.y < nearest ? t.y : nearest;
  nearest = t.z < nearest ? t.z : nearest;
  *out = nearest < INFINITY ? ray.origin + nearest * ray.direction : ray.direction;
  return dot(*out, *out) > 0;
}

// The way of a ray as seen from the centre: towards e cos(a) + n sin(a), 0 <= a <= whole, it is met at a distance of
// reach sin(whole) / sin(whole - a). An angle is given as its cosine and sine.
typedef struct CubeArc {
  float3 e, n;
  float cotangent;  // of the whole
  float reach;
} CubeArc;

// Closeness of the ray at an angle of its arc; `place` receives where that is.
static inline float arc_closeness(CubePlace *place, CubeArc arc, float2 angle, global const CubeInfo *cube)
{
  *place = cube_place(cube, arc.e * angle.x + arc.n * angle.y);
  return (angle.x - arc.cotangent * angle.y) / (arc.reach * place->major);
}

// What the impostor looks at.
typedef struct CubeMaps {
  global const CubeInfo *cube;
  global const float4 *texels;
  global const float *hull, *cells;
} CubeMaps;

static inline float2 turned(float2 angle, float2 turn)
{
  return (float2)(angle.x * turn.x - angle.y * turn.y, angle.y * turn.x + angle.x * turn.y);
}

static inline bool is_uneven(CubeDepth depth) { return depth.least < IMPOSTOR_EVENNESS * depth.most; }

#define ARC_IN_FRONT 0
#define ARC_BEHIND 1
#define ARC_UNSURE 2

// Looks for where the ray goes behind a surface after `angle` within CUBE_STRIDE turns. If it does, `place` is where.
static inline int arc_search(CubePlace *place, CubeArc arc, float2 angle, float2 turn, bool at_end, CubeMaps maps)
{
  float2 before = angle;
  int found = ARC_IN_FRONT;
  for (int i = 1; i <= CUBE_STRIDE && found == ARC_IN_FRONT; i++) {
    before = angle;
    angle = turned(angle, turn);
    float closeness = arc_closeness(place, arc, angle, maps.cube);
    if (at_end && i == CUBE_STRIDE) closeness = 0;
    CubeDepth depth = cube_depth(maps.texels, *place);
    if (closeness < depth.most && is_uneven(depth)) return ARC_UNSURE;
    found = closeness < depth.here ? ARC_BEHIND : ARC_IN_FRONT;
  }
  if (found == ARC_IN_FRONT) return found;
  for (int k = 0; k < IMPOSTOR_HALVINGS; k++) {
    float2 middle = before + angle;
    middle *= 1 / length(middle);
    bool is_behind = arc_closeness(place, arc, middle, maps.cube) < cube_depth(maps.texels, *place).here;
    before = is_behind ? before : middle;
    angle = is_behind ? middle : angle;
  }
  return is_uneven(cube_depth(maps.texels, *place)) ? ARC_UNSURE : ARC_BEHIND;
}

// Where a ray meets what the cube shows. False where that cannot be told.
static inline bool impostor_place(CubePlace *place, CubeMaps maps, CubeRay ray)
{
  CubeArc arc;
  arc.reach = length(ray.origin);
  *place = cube_place(maps.cube, ray.direction);
  arc.e = arc.reach > 0 ? ray.origin / arc.reach : ray.direction;
  float cosine = dot(arc.e, ray.direction);
  float3 across = ray.direction - arc.e * cosine;
  float sine = length(across);
  if (sine < 1e-6f) return cosine > 0 && !is_uneven(cube_depth(maps.texels, *place));
  arc.n = across / sine;
  arc.cotangent = cosine / sine;
  float whole = atan2(sine, cosine), texels_passed = whole * (float)maps.cube->size * 0.6366198f;  // of pi / 2 a face
  int strides = (int)(texels_passed / CUBE_STRIDE) + 1;
  float step = whole / (float)(strides * CUBE_STRIDE);
  float2 turn = (float2)(cos(step), sin(step)), stride = turned(turned(turn, turn), turned(turn, turn));
  float2 angle = (float2)(1, 0);
  float closeness = arc_closeness(place, arc, angle, maps.cube), cell = maps.cells[place->cell];
  if (closeness < cell && closeness < cube_depth(maps.texels, *place).most) return false;
  for (int i = 1; i <= strides; i++) {
    float2 next = turned(angle, stride);
    float ahead = arc_closeness(place, arc, next, maps.cube), cell_ahead = maps.cells[place->cell];
    if (i == strides) ahead = 0;
    if (ahead > maps.cube->hull_least && hull_holds(maps.hull, *place, ahead, HULL_SLACK)) return false;
    if (min(closeness, ahead) < max(cell, cell_ahead)) {
      CubePlace hit;
      int found = arc_search(&hit, arc, angle, turn, i == strides, maps);
      if (found != ARC_IN_FRONT) *place = hit;
      if (found != ARC_IN_FRONT) return found == ARC_BEHIND;
    }
    angle = next;
    closeness = ahead;
    cell = cell_ahead;
  }
  return true;
}

// What a ray shows by its reflector's cube. False: it is left to be traced.
static inline bool cube_answer(float4 *out, uint method, CubeMaps maps, CubeRay ray)
{
  CubePlace place;
  float3 towards = ray.direction;
  if (method == REFLECT_BY_IMPOSTOR) {
    if (!impostor_place(&place, maps, ray)) return false;
  } else {
    if (method == REFLECT_BY_BOX && !box_direction(&towards, maps.cube, ray)) return false;
    place = cube_place(maps.cube, towards);
  }
  *out = cube_sample(maps.texels, place);
  return true;
}

kernel void cube_reflect(uint method, global const float *rays, global const uint *slots, uint capacity, uint ray_count,
                         global const uint *object_starts, uint object_count, global const uint *cube_of_object,
                         global const CubeInfo *cubes, global const float4 *texels, global const float *hull,
                         global const float *cells, constant EnvironmentInfo *environment,
                         global const Float4 *environment_pixels, global float4 *radiance, global float *left_rays,
                         global uint *left_slots, global uint *count)
{
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
        uint triangle = LANE_UINT(source, lane) & ~RAY_FROM_MIRROR;
        uint number = cube_of_object[object_of_triangle(object_starts, object_count, triangle)];
        bool answered = number != CUBE_NONE;
        if (answered) {
          CubeMaps maps = {&cubes[number], texels, hull, cells};
          global const CubeInfo *cube = maps.cube;
          float3 center = (float3)(cube->center.x, cube->center.y, cube->center.z);
          CubeRay ray = {
              (float3)(LANE_FLOAT(origin.x, lane), LANE_FLOAT(origin.y, lane), LANE_FLOAT(origin.z, lane)) - center,
              (float3)(LANE_FLOAT(direction.x, lane), LANE_FLOAT(direction.y, lane), LANE_FLOAT(direction.z, lane))};
          answered = cube_answer(&value, method, maps, ray);
        }
        if (!answered) {
          LANE_INT(left, lane) = -1;
          continue;
        }
      }
      float4 throughput =
          (float4)(LANE_FLOAT(weight.x, lane), LANE_FLOAT(weight.y, lane), LANE_FLOAT(weight.z, lane), 0);
      radiance[LANE_UINT(slot, lane)] += throughput * value;
    }
    density = mirrored ? FLOATL(INFINITY) : density;
    stream_append_path(left, origin, stream_load3(rays, capacity, RAY_DIRECTION_X, first), FLOATL(INFINITY), weight,
                       slot, true, density, left_rays, capacity, left_slots, count);
  }
}
