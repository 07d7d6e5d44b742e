// How far off a picture may be that shows a cube map's texels, for hybrid reflections (cube_reflect.cl). Two things are
// looked at: how a surface looks from elsewhere than the cube's centre, and what texels beside each other show.
//
//   cube_turn    rays of a wave that hit something, as if they came from beside the centre: the same hits, seen from
//                there, are shaded once more
//   cube_change  by slot, the greatest change of the radiance that this makes
//   cube_flag    by slot, INFINITY for hits that sent rays on: mirrors, and what lets light through, show other things
//                from elsewhere
//   cube_change_keep   slots of a wave into the cube's texels, and the names of what they hit
//   cube_doubt   by texel: how far radiance may be off at a point between it and its neighbours to the right and below.
//                Between four texels it is off by no more than the greatest second difference of the rows and columns
//                through them: an eighth of it where radiance is smooth, half of it where a straight edge passes, all
//                of it where an edge cuts a corner off. Beside that the greatest change of the four.
//
//   Cost  a ray's hit shaded 1 + DOUBT_EYES times, without shadow rays; 60 bytes a texel read, 4 written.
//   Fails where something thinner than a texel lies between texels, and where a surface that is alike from all of the
//         eyes is not from between them: a narrow highlight.

#include "lib/lanes.cl"
#include "lib/ray_stream.cl"
#include "lib/tile.cl"
#include "shared/cube.h"

// Ray [0, ray_count) from the eye whose place beside the centre is `aside_m` metres across the ray, turned by (cos,
// sin).
kernel void cube_turn(constant CubeInfo *cube, float aside_m, float turn_cos, float turn_sin, global const float *rays,
                      uint capacity, uint ray_count, global const float *hits, global const uint *ids,
                      global float *turned)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint first = begin; first < end; first += LANES) {
    Vec3L direction = stream_load3(rays, capacity, RAY_DIRECTION_X, first), unit = unit3(direction);
    IntL steep = fabs(unit.y) > FLOATL(0.7f);
    Vec3L axis = vec3l(steep ? FLOATL(1) : FLOATL(0), steep ? FLOATL(0) : FLOATL(1), FLOATL(0));
    Vec3L across = unit3(cross3(unit, axis)), up = cross3(across, unit);
    Vec3L aside = add3(scale3(across, FLOATL(aside_m * turn_cos)), scale3(up, FLOATL(aside_m * turn_sin)));
    IntL hit = LANE_LOAD(ids, first) != UINTL(HIT_NONE);
    FloatL t = hit ? LANE_LOAD(hits + HIT_T * capacity, first) : LANE_LOAD(rays + RAY_T_MAX * capacity, first);
    Vec3L way = scale3(direction, t);
    stream_store3(sub3(way, aside), turned, capacity, RAY_DIRECTION_X, first);
  }
}

// Between the radiance of a wave as it is and as it is seen by another eye.
kernel void cube_change(uint ray_count, global const float4 *radiance, global const float4 *seen, global float *changes)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint slot = begin; slot < end; slot++) {
    float4 change = fabs(radiance[slot] - seen[slot]);
    changes[slot] = max(changes[slot], max(max(change.x, change.y), change.z));
  }
}

kernel void cube_flag(global const uint *slots, uint ray_count, global float *changes)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint i = begin; i < end; i++) changes[slots[i]] = INFINITY;
}

// `kept` begins with the cube's first texel; names are those of what the wave hit.
kernel void cube_change_keep(constant CubeInfo *cube, uint first_tile, uint pixel_count, global const float *changes,
                             global const uint *ids, global float *kept, global uint *names)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, pixel_count);
  uint2 grid = (uint2)(cube->size / TILE_SIZE, CUBE_FACES * (cube->size / TILE_SIZE));
  for (uint i = begin; i < end; i++) {
    uint2 pixel = tile_pixel(first_tile + i / TILE_PIXELS, i % TILE_PIXELS, grid);
    uint texel = pixel.y * cube->size + pixel.x;
    kept[texel] = changes[i];
    names[cube->first_texel + texel] = min(ids[i], CUBE_NAMELESS);
  }
}

static inline float4 second_difference(float4 a, float4 b, float4 c) { return fabs(a - 2 * b + c); }

kernel void cube_doubt(constant CubeInfo *cube, global const float4 *texels, global const float *changes,
                       global float2 *doubts)
{
  int size = (int)cube->size, count = CUBE_FACES * size * size;
  int begin = (int)(get_global_id(0) * RAYS_PER_ITEM), end = min(begin + RAYS_PER_ITEM, count);
  for (int i = begin; i < end; i++) {
    int x = i % size, y = i / size % size;
    float2 doubt = INFINITY;
    if (x + 1 < size && y + 1 < size) {
      global const float4 *at = texels + cube->first_texel + i;
      float4 second = 0;
      // Where a face ends the first difference stands for the second.
      for (int k = 0; k < 2; k++) {
        global const float4 *row = at + k * size, *column = at + k;
        float4 before = x > 0 ? row[-1] : row[0], after = x + 2 < size ? row[2] : row[1];
        float4 above = y > 0 ? column[-size] : column[0], below = y + 2 < size ? column[2 * size] : column[size];
        second = max(second, max(second_difference(before, row[0], row[1]), second_difference(row[0], row[1], after)));
        second = max(second, max(second_difference(above, column[0], column[size]),
                                 second_difference(column[0], column[size], below)));
      }
      doubt.x = max(max(second.x, second.y), second.z);
      doubt.y = max(max(changes[i], changes[i + 1]), max(changes[i + size], changes[i + size + 1]));
    }
    doubts[cube->first_texel + (uint)i] = doubt;
  }
}
