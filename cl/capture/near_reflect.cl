// Reflected rays answered by what is nearest: a triangle of their reflector's list (near_trace.cl), a snapshot of an
// object of the list, or what the cube map shows, from which the list's objects were left out.
//
//   near_reflect
//   in    rays, slots      reflected rays; those of mirrors say where they start (RAY_FROM_MIRROR)
//         hits, hit_ids    by ray index: what near_trace found
//         cubes ... cells  as in cube_reflect.cl, which also says what `method` does of what is in the cube
//         nears, snapshots, photos, backs, photo_cells   shared/near.h
//   out   radiance[slot]   weight x what a cube or a snapshot shows
//         listed_rays      rays whose hit is the list's, packed, with those hits
//         left_rays        the rays that are left to be traced, packed: those of rough surfaces, of objects without a
//                          cube, and those of which the cube, or a snapshot on the way, cannot tell (lib/impostor.cl)
//         counts           NEAR_*
//
//
//   `invisible` above 0: where a ray's weight times the error that is to be expected of the cube as if it were
//   infinitely far away is no more than that, the cube is asked so. That error is the mean change of the cube's
//   radiance by radian times the parallax (host/plan/cube_error.h) of what the cube shows in the ray's direction.
//
//   Cost  that of near_trace, of lib/impostor.cl for the cube and for each snapshot whose bounds the ray meets, and
//         one test against the bounds of each of them; 56 bytes moved for a ray that is listed.
//   Fails as lib/impostor.cl and cube_reflect.cl; and what a snapshot shows shines as seen from the cube's centre:
//         highlights move with the eye (mirrors are not photographed).
//   A ray's radiance is added slot by slot in the order of launches: no atomics, the same sum on every run.

#include "lib/impostor.cl"
#include "lib/reflected.cl"

// The maps of all cubes.
typedef struct NearMaps {
  global const CubeInfo *cubes;
  global const float4 *texels;
  global const float *cells;
  global const NearInfo *nears;
  global const SnapshotInfo *snapshots;
  global const float4 *photos;
  global const float *backs, *photo_cells;
} NearMaps;

// The part of a ray that is within an object's bounds, before t_most.
static inline bool bounds_meet(float *t_least, float *t_most, global const SnapshotInfo *snapshot, CubeRay ray)
{
  float3 low = (float3)(snapshot->low.x, snapshot->low.y, snapshot->low.z);
  float3 high = (float3)(snapshot->high.x, snapshot->high.y, snapshot->high.z);
  float3 inverse = 1 / ray.direction, a = (low - ray.origin) * inverse, b = (high - ray.origin) * inverse;
  float near[3] = {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)}, far[3] = {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)};
  *t_least = 0;
  for (int i = 0; i < 3; i++) {  // what is no number bounds nothing
    *t_least = near[i] > *t_least ? near[i] : *t_least;
    *t_most = far[i] < *t_most ? far[i] : *t_most;
  }
  return *t_least <= *t_most;
}

// The nearest of an object's snapshots before *t, which is then where. UNSURE where one of them cannot tell.
static inline int snapshots_meet(CubePlace *place, float *t, const NearMaps *maps, global const NearInfo *near,
                                 CubeRay ray, CubeArc arc)
{
  int state = MARCH_FRONT;
  for (uint i = near->first_snapshot; i < near->first_snapshot + near->snapshot_count; i++) {
    global const SnapshotInfo *snapshot = &maps->snapshots[i];
    float t_least, t_most = *t, t_here;
    CubePlace here;
    if (!bounds_meet(&t_least, &t_most, snapshot, ray)) continue;
    MarchMap map = {0, snapshot, maps->photos, maps->photo_cells, 0, maps->backs, snapshot->texels_rad};
    int found = map_meet(&here, &t_here, &map, ray, arc, t_least, t_most);
    if (found == MARCH_UNSURE) return found;
    if (found != MARCH_HIT) continue;
    *place = here;
    *t = t_here;
    state = found;
  }
  return state;
}

// The error to be expected of a cube's radiance as if it were infinitely far away.
static inline float cube_error(global const CubeInfo *cube, global const float4 *texels, float change, CubeRay ray,
                               CubeArc arc)
{
  CubePlace place = cube_place(cube, ray.direction);
  float inverse = cube_depth(texels, place).most * place.major;  // of the distance
  return change * M_PI_2_F * min(arc.reach * inverse * arc.sine, 1.0f);
}

// How far a ray that starts within a radius of the centre stays within it.
static inline float ball_leave(CubeRay ray, float radius)
{
  float along = dot(ray.origin, ray.direction), inside = radius * radius - dot(ray.origin, ray.origin);
  return inside > 0 ? sqrt(along * along + inside) - along : 0;
}

#define NEAR_ANSWERED NEAR_COUNTS

// What becomes of a ray of a cube whose list it meets after t metres; ANSWERED: *out is what it shows.
static inline uint near_answer(float4 *out, uint method, const NearMaps *maps, uint number, CubeRay ray, float t,
                               float weight, float invisible)
{
  global const CubeInfo *cube = &maps->cubes[number];
  global const NearInfo *near = &maps->nears[number];
  CubeArc arc = arc_of(ray);
  CubePlace place, far;
  float t_far;
  float3 towards = ray.direction;
  int photo = snapshots_meet(&place, &t, maps, near, ray, arc);
  if (photo == MARCH_UNSURE) return NEAR_FAILED_SNAPSHOT;
  if (method == REFLECT_BY_IMPOSTOR && invisible > 0 &&
      weight * cube_error(cube, maps->texels, near->change, ray, arc) <= invisible)
    method = REFLECT_BY_CUBE;
  bool beyond = t == INFINITY;
  float t_clear = near->nearest_m < INFINITY ? ball_leave(ray, near->nearest_m) : INFINITY;
  if (method == REFLECT_BY_IMPOSTOR && (beyond || t > t_clear)) {
    MarchMap map = march_map_of_cube(cube, maps->texels, maps->cells, 0);
    int found = map_meet(&far, &t_far, &map, ray, arc, t_clear, t);
    if (found == MARCH_UNSURE) return NEAR_FAILED_CUBE;
    beyond = beyond || found == MARCH_HIT;
  } else if (beyond) {
    if (method == REFLECT_BY_BOX && !box_direction(&towards, cube, ray)) return NEAR_FAILED_CUBE;
    far = cube_place(cube, towards);
  }
  if (beyond) *out = cube_sample(maps->texels, far);
  if (beyond) return NEAR_ANSWERED;
  if (photo != MARCH_HIT) return NEAR_LISTED;
  *out = cube_sample(maps->photos, place);
  return NEAR_ANSWERED;
}

kernel void near_reflect(uint method, float invisible, global const float *rays, global const uint *slots,
                         uint capacity, uint ray_count, global const float *hits, global const uint *hit_ids,
                         global const uint *object_starts, uint object_count, global const uint *cube_of_object,
                         global const CubeInfo *cubes, global const float4 *texels, global const float *cells,
                         global const NearInfo *nears, global const SnapshotInfo *snapshots,
                         global const float4 *photos, global const float *backs, global const float *photo_cells,
                         global float4 *radiance, global float *listed_rays, global uint *listed_slots,
                         global float *listed_hits, global uint *listed_ids, global float *left_rays,
                         global uint *left_slots, global uint *counts)
{
  ReflectorCubes reflectors = {object_starts, object_count, cube_of_object};
  NearMaps maps = {cubes, texels, cells, nears, snapshots, photos, backs, photo_cells};
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint first = begin; first < end; first += LANES) {
    ReflectedRays r = reflected_load(rays, slots, capacity, first, ray_count);
    UintL id = LANE_LOAD(hit_ids, first);
    FloatL t = LANE_LOAD(hits + HIT_T * capacity, first);
    IntL left = r.active & !r.mirrored, listed = INTL(0);
    FloatL length = sqrt(dot3(r.direction, r.direction)), most = max_component3(r.weight);
    for (uint bits = lane_bits(r.mirrored); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits), answer = NEAR_LEFT, number = reflector_cube(reflectors, LANE_UINT(r.source, lane));
      float4 value;
      if (number != CUBE_NONE) {
        CubeRay ray = cube_ray(&cubes[number], lane_float3(r.origin, lane), lane_float3(r.unit, lane));
        float t_listed = LANE_UINT(id, lane) == HIT_NONE ? INFINITY : LANE_FLOAT(t, lane) * LANE_FLOAT(length, lane);
        answer = near_answer(&value, method, &maps, number, ray, t_listed, LANE_FLOAT(most, lane), invisible);
      }
      if (answer == NEAR_ANSWERED) {
        float4 throughput = lane_float4(r.weight, lane);
        radiance[LANE_UINT(r.slot, lane)] += throughput * value;
        continue;
      }
      if (answer == NEAR_LISTED)
        LANE_INT(listed, lane) = -1;
      else
        LANE_INT(left, lane) = -1;
      if (answer >= NEAR_FAILED_CUBE) atomic_inc(&counts[answer]);
    }
    reflected_append(&r, left, left_rays, capacity, left_slots, &counts[NEAR_LEFT]);
    uint to = reflected_append(&r, listed, listed_rays, capacity, listed_slots, &counts[NEAR_LISTED]);
    for (uint bits = lane_bits(listed); bits; bits &= bits - 1, to++) {
      uint from = first + lowest_bit(bits);
      for (uint field = 0; field < HIT_FIELD_COUNT; field++)
        listed_hits[field * capacity + to] = hits[field * capacity + from];
      listed_ids[to] = hit_ids[from];
    }
  }
}
