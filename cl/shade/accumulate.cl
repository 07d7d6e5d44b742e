// Adds the samples of a wave to the picture's sums, in the order of the samples: the same bits however many samples and
// tiles a wave holds.
//
//   in    radiance  [ray_count], slots of a wave (shared/stream.h)
//   out   sums      [height][width], linear radiance and coverage
//
//   Cost  16 bytes read a sample, 32 moved a pixel.

#include "lib/tile.cl"
#include "shared/camera.h"

kernel void accumulate(constant CameraInfo *camera, uint first_tile, uint tile_count, uint sample_count,
                       global const float4 *radiance, global float4 *sums)
{
  uint pixel_count = tile_count * TILE_PIXELS;
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, pixel_count);
  for (uint i = begin; i < end; i++) {
    uint2 pixel = tile_pixel(first_tile + i / TILE_PIXELS, i % TILE_PIXELS, camera->tiles_per_row);
    if (pixel.x >= camera->width || pixel.y >= camera->height) continue;
    float4 sum = sums[pixel.y * camera->width + pixel.x];
    for (uint sample = 0; sample < sample_count; sample++) sum += radiance[sample * pixel_count + i];
    sums[pixel.y * camera->width + pixel.x] = sum;
  }
}
