// The radiance of a wave's slots (shared/stream.h), read and written LANES at a time.

#include "lib/lanes.cl"

// What slots hold so far, for the lanes of a mask.
typedef struct Sum {
  Vec3L rgb;
  FloatL coverage;
} Sum;

#if LANES == 16
// The slots of camera rays follow each other: four pixels a vector.
static inline bool slots_follow(UintL slot, IntL mask)
{
  return lane_bits(mask & (slot == UINTL(slot.s0) + LANE_AS_UINT(LANE_INDEX))) == 0xffff;
}
#else
static inline bool slots_follow(UintL slot, IntL mask) { return false; }
#endif

#if LANES == 16
// Four slots a vector.
static inline void sum_quads(FloatL quads[4], Sum sum)
{
  FloatL xz[2], yw[2];
  xz[0].even = sum.rgb.x.lo, xz[0].odd = sum.rgb.z.lo, xz[1].even = sum.rgb.x.hi, xz[1].odd = sum.rgb.z.hi;
  yw[0].even = sum.rgb.y.lo, yw[0].odd = sum.coverage.lo, yw[1].even = sum.rgb.y.hi, yw[1].odd = sum.coverage.hi;
#pragma unroll
  for (uint i = 0; i < 4; i++) {
    quads[i].even = i % 2 ? xz[i / 2].hi : xz[i / 2].lo;
    quads[i].odd = i % 2 ? yw[i / 2].hi : yw[i / 2].lo;
  }
}
#endif

static inline float4 sum_of_lane(Sum sum, uint lane)
{
  return (float4)(LANE_FLOAT(sum.rgb.x, lane), LANE_FLOAT(sum.rgb.y, lane), LANE_FLOAT(sum.rgb.z, lane),
                  LANE_FLOAT(sum.coverage, lane));
}

static inline Sum radiance_load(global const float4 *radiance, UintL slot, IntL mask)
{
  FloatL zero = FLOATL(0);
  Sum sum = {vec3l(zero, zero, zero), zero};
#if LANES == 16
  if (slots_follow(slot, mask)) {
    global const float *from = (global const float *)(radiance + slot.s0);
    FloatL xz[2], yw[2];
#pragma unroll
    for (uint i = 0; i < 2; i++) {
      FloatL first = vload16(2 * i, from), second = vload16(2 * i + 1, from);
      xz[i].lo = first.even, xz[i].hi = second.even;
      yw[i].lo = first.odd, yw[i].hi = second.odd;
    }
    sum.rgb.x.lo = xz[0].even, sum.rgb.x.hi = xz[1].even;
    sum.rgb.y.lo = yw[0].even, sum.rgb.y.hi = yw[1].even;
    sum.rgb.z.lo = xz[0].odd, sum.rgb.z.hi = xz[1].odd;
    sum.coverage.lo = yw[0].odd, sum.coverage.hi = yw[1].odd;
    return sum;
  }
#endif
  for (uint bits = lane_bits(mask); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    float4 now = radiance[LANE_UINT(slot, lane)];
    LANE_FLOAT(sum.rgb.x, lane) = now.x;
    LANE_FLOAT(sum.rgb.y, lane) = now.y;
    LANE_FLOAT(sum.rgb.z, lane) = now.z;
    LANE_FLOAT(sum.coverage, lane) = now.w;
  }
  return sum;
}

static inline void radiance_store(global float4 *radiance, UintL slot, IntL mask, Sum sum)
{
#if LANES == 16
  if (slots_follow(slot, mask)) {
    FloatL quads[4];
    sum_quads(quads, sum);
#pragma unroll
    for (uint i = 0; i < 4; i++) vstore16(quads[i], i, (global float *)(radiance + slot.s0));
    return;
  }
#endif
  for (uint bits = lane_bits(mask); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    radiance[LANE_UINT(slot, lane)] = sum_of_lane(sum, lane);
  }
}

#if LANES > 1
// Sets the pixels (x, y) of a picture's sums, or adds to them as shade/accumulate.cl does.
static inline void picture_store(global float4 *sums, uint width, uint height, UintL x, UintL y, bool adds, Sum sum)
{
  UintL pixel = y * UINTL(width) + x;
  IntL within = (x < UINTL(width)) & (y < UINTL(height));
#if LANES == 16
  if (lane_bits(within) == 0xffff) {
    FloatL rows[4];
    sum_quads(rows, sum);
#pragma unroll
    for (uint i = 0; i < 4; i++) {
      global float *to = (global float *)(sums + pixel.s0 + i * width);
      vstore16(adds ? vload16(0, to) + rows[i] : rows[i], 0, to);
    }
    return;
  }
#endif
  for (uint bits = lane_bits(within); bits; bits &= bits - 1) {
    uint lane = lowest_bit(bits);
    global float4 *to = &sums[LANE_UINT(pixel, lane)];
    *to = adds ? *to + sum_of_lane(sum, lane) : sum_of_lane(sum, lane);
  }
}
#endif

static inline void radiance_add(global float4 *radiance, UintL slot, IntL mask, Vec3L value)
{
  Sum sum = radiance_load(radiance, slot, mask);
  sum.rgb = add3(sum.rgb, value);
  radiance_store(radiance, slot, mask, sum);
}
