// Ray generator: camera rays of one wave.
//
//   in    camera    position and axes, world space
//         offsets   sample positions in the pixel, [sample_count], 0..1 from the top left
//   out   rays      one ray a slot of the wave; slots beyond the picture's edge are inactive
//         slots     the identity
//
//   Cost  writes 44 bytes a ray.
//   Directions have a component of 1 along the view axis: t is the depth.

#include "lib/ray_stream.cl"
#include "lib/tile.cl"
#include "shared/camera.h"

kernel void ray_generate(constant CameraInfo *camera, constant Float2 *offsets, uint first_tile, uint tile_count,
                         uint first_sample, uint ray_count, global float *rays, uint capacity, global uint *slots)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  float3 position = vload3(0, &camera->position.x);
  float3 right = vload3(0, &camera->right.x), down = vload3(0, &camera->down.x),
         forward = vload3(0, &camera->forward.x);
  for (uint slot = begin; slot < end; slot++) {
    uint tile = slot / TILE_PIXELS;
    Float2 offset = offsets[first_sample + tile / tile_count];
    uint2 pixel = tile_pixel(first_tile + tile % tile_count, slot % TILE_PIXELS, camera->tiles_per_row);
    float x = ((float)(pixel.x + camera->crop_x) + offset.x) * camera->scale - camera->center_x;
    float y = ((float)(pixel.y + camera->crop_y) + offset.y) * camera->scale - camera->center_y;
    float3 across = right * x + down * y;
    float3 origin = camera->orthographic ? position + across : position;
    float3 direction = camera->orthographic ? forward : forward + across;
    bool visible = pixel.x < camera->width && pixel.y < camera->height;
    rays[RAY_ORIGIN_X * capacity + slot] = origin.x;
    rays[RAY_ORIGIN_Y * capacity + slot] = origin.y;
    rays[RAY_ORIGIN_Z * capacity + slot] = origin.z;
    rays[RAY_DIRECTION_X * capacity + slot] = direction.x;
    rays[RAY_DIRECTION_Y * capacity + slot] = direction.y;
    rays[RAY_DIRECTION_Z * capacity + slot] = direction.z;
    rays[RAY_T_MAX * capacity + slot] = visible ? camera->far_m : -1.0f;
    rays[RAY_WEIGHT_R * capacity + slot] = 1.0f;
    rays[RAY_WEIGHT_G * capacity + slot] = 1.0f;
    rays[RAY_WEIGHT_B * capacity + slot] = 1.0f;
    slots[slot] = slot;
  }
}
