// Marks the tiles of a light's maps that a picture's receivers are in, by probes: shadow rays of a few of its pixels.
//
//   in    camera         whose pixels are the probes
//         infos, views   the maps of all lights
//         rays           a stream of shadow rays to `light`, [ray_count] of segment `segment`
//   out   marks          of the tiles of all lights, from UINT_MAX down: the least closeness of a receiver in
//                        the tile, by mark_of
//
//   A probe marks what is as far from it on the map as the next probe may be, and is taken to be a little farther from
//   the light. What probes miss is not marked: maps are not drawn there, and rays from there are traced. That costs
//   time and changes no picture.
//   Cost  20 ns a probe on a core.

#include "lib/ray_stream.cl"
#include "lib/shadow_view.cl"
#include "shared/camera.h"
#include "shared/shadow.h"

// Distances on the map that a probe marks, in probes' distances on a plane across the ray; found by trial.
#define MARK_REACH 1.5f

// What a receiver near a probe may be less close than it: a share, or in parallel projection of the depth of the map.
#define MARK_BEYOND 0.02f
#define MARK_BEYOND_PARALLEL 0.01f

// Keeps the order of floats.
static inline uint mark_of(float least)
{
  uint bits = as_uint(least);
  return bits >> 31 ? ~bits : bits | 0x80000000u;
}

kernel void shadow_mark(constant CameraInfo *camera, global const ShadowInfo *infos, uint light,
                        global const ShadowView *views, global const float *rays, uint capacity, uint ray_count,
                        uint segment, volatile global uint *marks)
{
  global const ShadowInfo *info = &infos[light];
  uint tile_columns = TILE_COLUMNS(info->size_px);
  views += info->first_view;
  marks += info->first_texel;
  rays += segment * RAY_FIELD_COUNT * capacity;
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  Vec3L eye = vec3l(FLOATL(camera->position.x), FLOATL(camera->position.y), FLOATL(camera->position.z));
  for (uint first = begin; first < end; first += LANES) {
    Vec3L point = stream_load3(rays, capacity, RAY_ORIGIN_X, first), from_eye = sub3(point, eye);
    IntL active = stream_load_t_max(rays, capacity, first, ray_count) > FLOATL(0);
    FloatL apart_m = FLOATL(MARK_REACH * camera->scale);
    if (!camera->orthographic) apart_m = apart_m * sqrt(dot3(from_eye, from_eye));
    UintL chosen = shadow_view_choose(info, views, point);
    for (uint bits = lane_bits(active & (chosen != UINTL(SHADOW_VIEW_NONE))); bits; bits &= bits - 1) {
      uint lane = lowest_bit(bits), number = LANE_UINT(chosen, lane);
      global const ShadowView *view = &views[number];
      MapPoint at = shadow_project(view, shadow_relative(view, point));
      Float3 step = view->sight_x;
      bool parallel = view->raster.parallel;
      float w = LANE_FLOAT(at.w, lane), last = (float)(info->size_px - 1);
      float reach = LANE_FLOAT(apart_m, lane) / (w * sqrt(step.x * step.x + step.y * step.y + step.z * step.z));
      float least = parallel ? -LANE_FLOAT(at.depth, lane) - MARK_BEYOND_PARALLEL : (1 - MARK_BEYOND) / w;
      float2 middle = (float2)(LANE_FLOAT(at.x, lane), LANE_FLOAT(at.y, lane)), zero = (float2)(0, 0);
      if (!(least > -INFINITY && reach >= 0)) continue;
      uint2 low = convert_uint2(clamp(middle - reach, zero, zero + last)) / SHADOW_TILE_PX;
      uint2 high = convert_uint2(clamp(middle + reach, zero, zero + last)) / SHADOW_TILE_PX;
      uint mark = mark_of(least);
      for (uint y = low.y; y <= high.y; y++)
        for (uint x = low.x; x <= high.x; x++) {
          volatile global uint *to = &marks[(number * tile_columns + y) * tile_columns + x];
#ifndef WITHOUT_PEEKS  // races harmlessly, as depth_now of lib/boxes.cl
          if (mark >= *to) continue;
#endif
          atomic_min(to, mark);
        }
    }
  }
}
