// Snapshots: what is seen of one object, alone, from a cube map's centre, in a frustum that holds the whole of it.
//
//   snapshot_rays     a ray a texel, from the centre through the texel's centre, with a component of 1 along the
//                     frustum's axis: t is the distance along it. With `inward_m` above 0 back to the centre, from that
//                     far along the axis
//   snapshot_depths   closeness of what rays see of the object, and of its farthest surface (shared/near.h), of a wave
//                     of one sample: `hits` are of rays outwards that see surfaces as the camera does, `any_` those of
//                     the same rays that see either side of all, `back_` those of rays inwards that do
//   snapshot_keep     adds the radiance of a wave to the texels
//   snapshot_cells    the cells of a snapshot whose texels are all there
//   cube_change       of a cube's rows of texels: how much the radiance changes from texel to texel, in the channel
//                     where it does most, along rows and columns together, the sum of 2 size - 1 differences (of the
//                     last row of a face size - 1); and the greatest closeness
//
//   Cost  three rays a texel, and what shading takes; 16 bytes read and 20 written a texel.
//   Fails where a thing is thinner than a texel: rays that pass between see nothing of it.

#include "lib/capture.cl"
#include "shared/near.h"

static inline uint2 snapshot_tiles(constant SnapshotInfo *info) { return (uint2)(info->size / TILE_SIZE); }

static inline uint snapshot_texel(constant SnapshotInfo *info, uint first_tile, uint slot)
{
  uint2 pixel = tile_pixel(first_tile + slot / TILE_PIXELS, slot % TILE_PIXELS, snapshot_tiles(info));
  return info->first_texel + pixel.y * info->size + pixel.x;
}

static inline float3 from_shared(constant Float3 *v) { return (float3)(v->x, v->y, v->z); }

kernel void snapshot_rays(constant SnapshotInfo *info, uint first_tile, uint tile_count, uint ray_count, float inward_m,
                          global float *rays, uint capacity, global uint *slots)
{
  float3 center = from_shared(&info->center);
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint slot = begin; slot < end; slot++) {
    uint tile = first_tile + slot / TILE_PIXELS % tile_count;
    uint2 pixel = tile_pixel(tile, slot % TILE_PIXELS, snapshot_tiles(info));
    float x = info->left + (float)pixel.x / info->texels, y = info->top + (float)pixel.y / info->texels;
    float3 direction = from_shared(&info->forward) + from_shared(&info->right) * x + from_shared(&info->down) * y;
    bool inward = inward_m > 0;
    capture_ray_store(center + direction * inward_m, inward ? -direction : direction, inward ? inward_m : INFINITY,
                      rays, capacity, slots, slot);
  }
}

kernel void snapshot_depths(constant SnapshotInfo *info, uint first_tile, uint pixel_count, uint capacity,
                            global const float *hits, global const uint *ids, global const float *any_hits,
                            global const uint *any_ids, global const float *back_hits, global const uint *back_ids,
                            global float4 *texels, global float *back)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, pixel_count);
  for (uint i = begin; i < end; i++) {
    uint texel = snapshot_texel(info, first_tile, i);
    float closeness = 0, behind = SNAPSHOT_NO_BACK;
    if (any_ids[i] != HIT_NONE) {
      closeness = 1 / any_hits[HIT_T * capacity + i];
      behind = closeness;
      if (back_ids[i] != HIT_NONE) behind = min(closeness, 1 / (info->beyond_m - back_hits[HIT_T * capacity + i]));
      if (ids[i] == HIT_NONE || hits[HIT_T * capacity + i] > any_hits[HIT_T * capacity + i]) behind = -behind;
    }
    texels[texel] = (float4)(0, 0, 0, closeness);
    back[texel] = behind;
  }
}

kernel void snapshot_keep(constant SnapshotInfo *info, uint first_tile, uint tile_count, uint sample_count, float share,
                          global const float4 *radiance, global float4 *texels)
{
  uint pixel_count = tile_count * TILE_PIXELS;
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, pixel_count);
  for (uint i = begin; i < end; i++) {
    global float4 *texel = texels + snapshot_texel(info, first_tile, i);
    float4 sum = *texel;
    for (uint sample = 0; sample < sample_count; sample++) sum.xyz += radiance[sample * pixel_count + i].xyz * share;
    *texel = sum;
  }
}

kernel void snapshot_cells(constant SnapshotInfo *info, global const float4 *texels, global float *cells)
{
  cells_fill(info->first_texel, (int)info->size, 1, texels, cells);
}

kernel void cube_change(constant CubeInfo *cube, global const float4 *texels, global float *changes)
{
  uint row = get_global_id(0), size = cube->size;
  if (row >= CUBE_FACES * size) return;
  global const float4 *texel = texels + cube->first_texel + row * size;
  float sum = 0, closeness = 0;
  for (uint x = 0; x < size; x++) {
    float4 right = x + 1 < size ? fabs(texel[x + 1] - texel[x]) : (float4)(0);
    float4 down = (row + 1) % size ? fabs(texel[x + size] - texel[x]) : (float4)(0);
    closeness = max(closeness, texel[x].w);
    sum += max(right.x, max(right.y, right.z)) + max(down.x, max(down.y, down.z));
  }
  changes[2 * row] = sum;
  changes[2 * row + 1] = closeness;
}
