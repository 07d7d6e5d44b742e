// Rays and cells of captured maps.

#include "lib/cube.cl"
#include "lib/ray_stream.cl"
#include "lib/tile.cl"

// Writes ray `slot` of a capture: weight 1, slots the identity.
static inline void capture_ray_store(float3 origin, float3 direction, float t_max, global float *rays, uint capacity,
                                     global uint *slots, uint slot)
{
  rays[RAY_ORIGIN_X * capacity + slot] = origin.x;
  rays[RAY_ORIGIN_Y * capacity + slot] = origin.y;
  rays[RAY_ORIGIN_Z * capacity + slot] = origin.z;
  rays[RAY_DIRECTION_X * capacity + slot] = direction.x;
  rays[RAY_DIRECTION_Y * capacity + slot] = direction.y;
  rays[RAY_DIRECTION_Z * capacity + slot] = direction.z;
  rays[RAY_T_MAX * capacity + slot] = t_max;
  rays[RAY_WEIGHT_R * capacity + slot] = 1;
  rays[RAY_WEIGHT_G * capacity + slot] = 1;
  rays[RAY_WEIGHT_B * capacity + slot] = 1;
  slots[slot] = slot;
}

// Fills the cells of faces of size x size texels (shared/cube.h), both from first_texel on.
static inline void cells_fill(uint first_texel, int size, int faces, global const float4 *texels, global float *cells)
{
  int across = size / CUBE_CELL, count = faces * across * across;
  int begin = (int)(get_global_id(0) * RAYS_PER_ITEM), end = min(begin + RAYS_PER_ITEM, count);
  for (int i = begin; i < end; i++) {
    int face = i / (across * across), x = i % across * CUBE_CELL, y = i / across % across * CUBE_CELL;
    float most = 0;
    for (int row = max(y - CUBE_STRIDE, 0); row < min(y + CUBE_CELL + CUBE_STRIDE, size); row++)
      for (int column = max(x - CUBE_STRIDE, 0); column < min(x + CUBE_CELL + CUBE_STRIDE, size); column++)
        most = max(most, texels[first_texel + (uint)((face * size + row) * size + column)].w);
    cells[first_texel / (CUBE_CELL * CUBE_CELL) + (uint)i] = most;
  }
}
