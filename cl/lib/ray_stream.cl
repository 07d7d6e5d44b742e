// Reading, writing and finishing rays of a stream (shared/stream.h).

#include "lib/lanes.cl"
#include "shared/stream.h"

static inline Vec3L stream_load3(global const float *fields, uint capacity, uint field, uint first)
{
  return vec3l(LANE_LOAD(fields + field * capacity, first), LANE_LOAD(fields + (field + 1) * capacity, first),
               LANE_LOAD(fields + (field + 2) * capacity, first));
}

// Where on its triangle a ray hits: t, and the weights of vertices 1 and 2.
typedef struct HitPlace {
  FloatL t, u, v;
} HitPlace;

static inline HitPlace hit_place_load(global const float *hits, uint capacity, uint first)
{
  HitPlace at = {LANE_LOAD(hits + HIT_T * capacity, first), LANE_LOAD(hits + HIT_U * capacity, first),
                 LANE_LOAD(hits + HIT_V * capacity, first)};
  return at;
}

static inline void stream_store3(Vec3L value, global float *fields, uint capacity, uint field, uint first)
{
  LANE_STORE(value.x, fields + field * capacity, first);
  LANE_STORE(value.y, fields + (field + 1) * capacity, first);
  LANE_STORE(value.z, fields + (field + 2) * capacity, first);
}

// t_max of the rays from `first` on; lanes past the end of the stream are inactive.
static inline FloatL stream_load_t_max(global const float *rays, uint capacity, uint first, uint ray_count)
{
  FloatL t_max = LANE_LOAD(rays + RAY_T_MAX * capacity, first);
  return LANE_INDEX < INTL((int)(ray_count - first)) ? t_max : FLOATL(-1);
}

// Adds `share` of a ray's weight to the radiance of its slot. A slot has at most one ray in a stream: no atomics are
// needed.
static inline void stream_add_weight(global const float *rays, uint capacity, uint ray, global const uint *slots,
                                     global float4 *radiance, float share)
{
  float4 weight = (float4)(rays[RAY_WEIGHT_R * capacity + ray], rays[RAY_WEIGHT_G * capacity + ray],
                           rays[RAY_WEIGHT_B * capacity + ray], 0);
  radiance[slots[ray]] += weight * share;
}

#if LANES == 1
// The place of one more ray in a stream. On NVIDIA work-items of a warp that come here together share one atomic: one
// each would take longer than all the rest of shading.
static inline uint place_take(global uint *count)
{
#ifdef __NV_CL_C_VERSION
  uint here, below, low, high, alike, place = 0;
  asm volatile("activemask.b32 %0;" : "=r"(here));
  asm volatile("mov.u32 %0, %%lanemask_lt;" : "=r"(below));
  uint first = 31 - clz(here & -here), own_low = (uint)(ulong)count, own_high = (uint)((ulong)count >> 32);
  asm volatile("shfl.sync.idx.b32 %0, %1, %2, 31, %3;" : "=r"(low) : "r"(own_low), "r"(first), "r"(here));
  asm volatile("shfl.sync.idx.b32 %0, %1, %2, 31, %3;" : "=r"(high) : "r"(own_high), "r"(first), "r"(here));
  uint is_alike = low == own_low && high == own_high;
  asm volatile("{ .reg .pred p; setp.ne.u32 p, %1, 0; vote.sync.ballot.b32 %0, p, %2; }"
               : "=r"(alike)
               : "r"(is_alike), "r"(here));
  if (!is_alike) return atomic_inc(count);
  below &= alike;
  if (below == 0) place = atomic_add(count, (uint)popcount(alike));
  asm volatile("shfl.sync.idx.b32 %0, %1, %2, 31, %3;" : "=r"(place) : "r"(place), "r"(first), "r"(alike));
  return place + (uint)popcount(below);
#else
  return atomic_inc(count);
#endif
}
#endif

// Appends the lanes of `mask` to a stream, packed, in lane order; `density` goes to RAY_DENSITY where `has_density`
// (or what else that field holds). Returns where the first of them went.
static inline uint stream_append_path(IntL mask, Vec3L origin, Vec3L direction, FloatL t_max, Vec3L weight, UintL slot,
                                      bool has_density, FloatL density, global float *rays, uint capacity,
                                      global uint *slots, global uint *count)
{
  uint bits = lane_bits(mask);
  if (!bits) return 0;
#if LANES == 1
  uint at = place_take(count), place = at;
#else
  uint at = atomic_add(count, (uint)popcount(bits)), place = at;
  if (popcount(bits) == LANES) {
    stream_store3(origin, rays, capacity, RAY_ORIGIN_X, at);
    stream_store3(direction, rays, capacity, RAY_DIRECTION_X, at);
    LANE_STORE(t_max, rays + RAY_T_MAX * capacity, at);
    stream_store3(weight, rays, capacity, RAY_WEIGHT_R, at);
    if (has_density) LANE_STORE(density, rays + RAY_DENSITY * capacity, at);
    LANE_STORE(slot, slots, at);
    return place;
  }
#endif
  for (; bits; bits &= bits - 1, at++) {
    uint lane = lowest_bit(bits);
    rays[RAY_ORIGIN_X * capacity + at] = LANE_FLOAT(origin.x, lane);
    rays[RAY_ORIGIN_Y * capacity + at] = LANE_FLOAT(origin.y, lane);
    rays[RAY_ORIGIN_Z * capacity + at] = LANE_FLOAT(origin.z, lane);
    rays[RAY_DIRECTION_X * capacity + at] = LANE_FLOAT(direction.x, lane);
    rays[RAY_DIRECTION_Y * capacity + at] = LANE_FLOAT(direction.y, lane);
    rays[RAY_DIRECTION_Z * capacity + at] = LANE_FLOAT(direction.z, lane);
    rays[RAY_T_MAX * capacity + at] = LANE_FLOAT(t_max, lane);
    rays[RAY_WEIGHT_R * capacity + at] = LANE_FLOAT(weight.x, lane);
    rays[RAY_WEIGHT_G * capacity + at] = LANE_FLOAT(weight.y, lane);
    rays[RAY_WEIGHT_B * capacity + at] = LANE_FLOAT(weight.z, lane);
    if (has_density) rays[RAY_DENSITY * capacity + at] = LANE_FLOAT(density, lane);
    slots[at] = LANE_UINT(slot, lane);
  }
  return place;
}

// The same without a density.
static inline void stream_append(IntL mask, Vec3L origin, Vec3L direction, FloatL t_max, Vec3L weight, UintL slot,
                                 global float *rays, uint capacity, global uint *slots, global uint *count)
{
  stream_append_path(mask, origin, direction, t_max, weight, slot, false, FLOATL(0), rays, capacity, slots, count);
}
