// Adds the samples of a wave to the picture's sums, in the order of the samples: the same bits however many samples and
// tiles a wave holds.
//
//   in    radiance  [ray_count], slots of a wave (shared/stream.h)
//   out   sums      [height][width], linear radiance and coverage; with `begin` what they held does not count
//
//   Cost  16 bytes read a sample, 32 moved a pixel, with `begin` 16.

#include "lib/tile.cl"

// Neighbouring pixels that a step takes: a row of a block of 4 x 4, or one.
#if LANES == 1
#define ROW 1
#else
#define ROW 4
#endif

kernel void accumulate(constant CameraInfo *camera, uint first_tile, uint tile_count, uint sample_count, uint begin,
                       global const float4 *radiance, global float4 *sums)
{
  uint pixel_count = tile_count * TILE_PIXELS;
  uint first = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(first + RAYS_PER_ITEM, pixel_count);
  uint2 grid = camera_tiles(camera), corner = (uint2)(0);
  for (uint i = first; i < end; i += ROW) {
    if (i == first || i % TILE_PIXELS == 0) corner = tile_pixel(first_tile + i / TILE_PIXELS, 0, grid);
    uint2 pixel = corner + within_tile(i % TILE_PIXELS);
    if (pixel.x >= camera->width || pixel.y >= camera->height) continue;
    global float4 *to = &sums[pixel.y * camera->width + pixel.x];
    global const float4 *from = &radiance[i];
#if ROW == 4
    if (pixel.x + ROW <= camera->width) {
      float16 sum = begin ? (float16)0 : vload16(0, (global float *)to);
      for (uint sample = 0; sample < sample_count; sample++)
        sum += vload16(0, (global const float *)(from + sample * pixel_count));
      vstore16(sum, 0, (global float *)to);
      continue;
    }
#endif
    for (uint k = 0; k < min(camera->width - pixel.x, (uint)ROW); k++) {
      float4 sum = begin ? (float4)0 : to[k];
      for (uint sample = 0; sample < sample_count; sample++) sum += from[sample * pixel_count + k];
      to[k] = sum;
    }
  }
}
