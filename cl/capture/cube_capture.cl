// Cube-face capture: what is seen from a reflector's centre, without the reflector. The six faces are one tall picture,
// face under face, so that each stage of a wave is one launch for all of them; tracing and shading are those of every
// picture.
//
//   cube_rays   a ray a texel, from `inward_m` along the face's axis back to the centre: t is the distance along it.
//               Rays from the centre are those of six cameras (host/passes/cube_capture.c)
//   cube_peel   of rays that hit an object that is left out, sends on what goes past it, packed; of all others writes
//               hit and closeness by slot. Traced and peeled again until none is left, or as often as the host allows
//   cube_near   closeness by slot of hits that raster found, without what is left out
//   cube_keep   radiance and closeness of a wave into the cube's texels
//   cube_hull   closeness of a wave of inward rays, for which all but the reflector is left out: of its outermost
//               surface
//   cube_cells  the cells of a cube whose texels are all there
//
//   Cost  a sample of raster a texel, or a ray and one more for each surface that is left out; 44 bytes written a ray,
//         32 a texel moved.
//   Fails where something touches a surface that is left out (within 1e-6 of its distance): it is passed too. What a
//         BLEND surface lets through has the closeness of the surface.

#include "lib/capture.cl"
#include "lib/object.cl"

// Tiles across and down the tall picture.
static inline uint2 cube_tiles(constant CubeInfo *cube)
{
  return (uint2)(cube->size / TILE_SIZE, CUBE_FACES * (cube->size / TILE_SIZE));
}

kernel void cube_rays(constant CubeInfo *cube, uint first_tile, uint tile_count, uint ray_count, float inward_m,
                      global float *rays, uint capacity, global uint *slots)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint slot = begin; slot < end; slot++) {
    uint tile = first_tile + slot / TILE_PIXELS % tile_count;
    float3 direction = face_direction(cube->size, tile_pixel(tile, slot % TILE_PIXELS, cube_tiles(cube)));
    float3 origin = (float3)(cube->center.x, cube->center.y, cube->center.z) + direction * inward_m;
    capture_ray_store(origin, -direction, inward_m, rays, capacity, slots, slot);
  }
}

static inline float closeness_at(float distance) { return 1 / max(distance, 1 / CUBE_NO_HULL); }

// Rays [0, ray_count) and what they hit; `to_hits`, `to_ids` and `closeness` are by slot, in streams of `capacity` too.
kernel void cube_peel(constant CubeInfo *cube, uint inward, global const float *rays, global const uint *slots,
                      uint capacity, uint ray_count, global const float *hits, global const uint *ids,
                      global const uint *object_starts, uint object_count, global const uint *left_out,
                      global float *to_hits, global uint *to_ids, global float *closeness, global float *onward_rays,
                      global uint *onward_slots, global uint *count)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  float nothing = inward ? CUBE_NO_HULL : 0;
  for (uint first = begin; first < end; first += LANES) {
    UintL slot = LANE_LOAD(slots, first), id = LANE_LOAD(ids, first);
    Vec3L origin = stream_load3(rays, capacity, RAY_ORIGIN_X, first);
    Vec3L direction = stream_load3(rays, capacity, RAY_DIRECTION_X, first);
    FloatL t = LANE_LOAD(hits + HIT_T * capacity, first);
    Vec3L from = sub3(origin, vec3l(FLOATL(cube->center.x), FLOATL(cube->center.y), FLOATL(cube->center.z)));
    FloatL before = max_component3(vec3l(fabs(from.x), fabs(from.y), fabs(from.z)));
    FloatL distance = inward ? before - t : before + t;
    IntL passes = INTL(0);
    for (uint lane = 0; lane < LANES && first + lane < end; lane++) {
      uint at = LANE_UINT(slot, lane), triangle = LANE_UINT(id, lane);
      bool hit = triangle != HIT_NONE;
      bool past = hit && left_out[object_of_triangle(object_starts, object_count, triangle)];
      LANE_INT(passes, lane) = past ? -1 : 0;
      to_ids[at] = past ? HIT_NONE : triangle;
      closeness[at] = !hit || past ? nothing : closeness_at(LANE_FLOAT(distance, lane));
      for (uint field = 0; field < HIT_FIELD_COUNT; field++)
        to_hits[field * capacity + at] = hits[field * capacity + first + lane];
    }
    if (!any_lane(passes)) continue;
    FloatL t_max = LANE_LOAD(rays + RAY_T_MAX * capacity, first);
    FloatL beyond = t + FLOATL(1e-6f) * (t + before), one = FLOATL(1);
    stream_append(passes, add3(origin, scale3(direction, beyond)), direction, t_max - beyond, vec3l(one, one, one),
                  slot, onward_rays, capacity, onward_slots, count);
  }
}

kernel void cube_near(global const float *hits, global const uint *ids, uint capacity, uint ray_count,
                      global float *closeness)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, ray_count);
  for (uint i = begin; i < end; i++) closeness[i] = ids[i] == HIT_NONE ? 0 : closeness_at(hits[HIT_T * capacity + i]);
}

// Adds `share` of the samples of a wave; texels begin at 0.
kernel void cube_keep(constant CubeInfo *cube, uint first_tile, uint tile_count, uint sample_count, float share,
                      global const float4 *radiance, global const float *closeness, global float4 *texels)
{
  uint pixel_count = tile_count * TILE_PIXELS;
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, pixel_count);
  for (uint i = begin; i < end; i++) {
    uint2 pixel = tile_pixel(first_tile + i / TILE_PIXELS, i % TILE_PIXELS, cube_tiles(cube));
    global float4 *texel = texels + cube->first_texel + pixel.y * cube->size + pixel.x;
    float4 sum = *texel;
    for (uint sample = 0; sample < sample_count; sample++) sum += radiance[sample * pixel_count + i] * share;
    sum.w = closeness[i];
    *texel = sum;
  }
}

kernel void cube_hull(constant CubeInfo *cube, uint first_tile, uint pixel_count, global const float *closeness,
                      global float *hull)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, pixel_count);
  for (uint i = begin; i < end; i++) {
    uint2 pixel = tile_pixel(first_tile + i / TILE_PIXELS, i % TILE_PIXELS, cube_tiles(cube));
    hull[cube->first_texel + pixel.y * cube->size + pixel.x] = closeness[i];
  }
}

kernel void cube_cells(constant CubeInfo *cube, global const float4 *texels, global float *cells)
{
  cells_fill(cube->first_texel, (int)cube->size, CUBE_FACES, texels, cells);
}
