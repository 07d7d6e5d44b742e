// Ray generator: camera rays of one wave.
//
//   in    cameras   position and axes, world space, [view_count] (shared/camera.h)
//         offsets   sample positions in the pixel, [sample_count], 0..1 from the top left
//   out   rays      one ray a slot of the wave; slots beyond the picture's edge are inactive
//         slots     the identity
//
//   Cost  writes 44 bytes a ray.
//   Directions have a component of 1 along the view axis: t is the depth.

#include "lib/camera_ray.cl"
#include "lib/ray_stream.cl"

kernel void ray_generate(constant CameraInfo *cameras, uint view_count, constant Float2 *offsets, uint first_tile,
                         uint tile_count, uint first_sample, uint ray_count, global float *rays, uint capacity,
                         global uint *slots)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  Vec3L one = vec3l(FLOATL(1), FLOATL(1), FLOATL(1));
  CameraSources from = {cameras, view_count, offsets, first_tile, tile_count, first_sample};
  WaveTile tile = wave_tile(&from, begin);
  for (uint slot = begin; slot < end; slot += LANES) {
    FloatL t_max;
    CameraRay ray = wave_ray(&t_max, &tile, slot);
    stream_store3(ray.origin, rays, capacity, RAY_ORIGIN_X, slot);
    stream_store3(ray.direction, rays, capacity, RAY_DIRECTION_X, slot);
    LANE_STORE(t_max, rays + RAY_T_MAX * capacity, slot);
    stream_store3(one, rays, capacity, RAY_WEIGHT_R, slot);
    LANE_STORE(UINTL(slot) + LANE_AS_UINT(INTL(0) + LANE_INDEX), slots, slot);
  }
}
