// Arbitrary output variables of the primary hits of one wave.
//
//   in    rays, hits, hit_ids   camera rays and what they hit
//         object_starts         first triangle of each object, [object_count + 1]
//   out   values  planes [AOV_VALUE_PLANES][height * width]: of sample 0 depth (+inf on the background) and position;
//   sums
//                 over samples of the shading normal and the albedo
//         ids     planes [AOV_ID_PLANES][height * width], of sample 0: object, primitive within it, material; AOV_NONE
//                 on the background
//
//   Cost  a surface load a sample, 52 bytes written a pixel.

#include "lib/object.cl"
#include "lib/ray_stream.cl"
#include "lib/surface.cl"
#include "lib/tile.cl"
#include "shared/aov.h"

static inline void plane_add3(global float *values, uint plane, uint pixels, uint at, Vec3L v, uint lane, uint fresh)
{
  float x = LANE_FLOAT(v.x, lane), y = LANE_FLOAT(v.y, lane), z = LANE_FLOAT(v.z, lane);
  values[plane * pixels + at] = fresh ? x : values[plane * pixels + at] + x;
  values[(plane + 1) * pixels + at] = fresh ? y : values[(plane + 1) * pixels + at] + y;
  values[(plane + 2) * pixels + at] = fresh ? z : values[(plane + 2) * pixels + at] + z;
}

kernel void aov(constant CameraInfo *camera, uint first_tile, uint tile_count, uint first_sample, uint sample_count,
                global const float *rays, uint capacity, global const float *hits, global const uint *hit_ids,
                global const float *positions, global const float *normals, global const Float4 *tangents,
                global const TriangleCorners *corners, global const Float2 *uvs, global const Float4 *colors,
                uint vertex_count, global const MaterialInfo *materials, global const TextureInfo *textures,
                global const uchar4 *texels, constant float *linear_from_byte, global const uint *object_starts,
                uint object_count, global float *values, global uint *ids)
{
  AttributeSources attributes = {corners, uvs, colors, vertex_count, materials, textures, texels, linear_from_byte};
  GeometrySources geometry = {positions, normals, tangents};
  uint pixel_count = tile_count * TILE_PIXELS, picture_pixels = camera->width * camera->height;
  uint begin = get_global_id(0) * RAYS_PER_ITEM;
  uint end = min(begin + RAYS_PER_ITEM, pixel_count);
  for (uint first = begin; first < end; first += LANES) {
    for (uint sample = 0; sample < sample_count; sample++) {
      uint slot = sample * pixel_count + first;
      uint fresh = first_sample + sample == 0;
      IntL active = LANE_LOAD(rays + RAY_T_MAX * capacity, slot) > FLOATL(0);
      UintL id = LANE_LOAD(hit_ids, slot);
      IntL hit = active & (id != UINTL(HIT_NONE));
      FloatL t = LANE_LOAD(hits + HIT_T * capacity, slot);
      HitTriangles on;
      Surface s = surface_load(&on, &geometry, &attributes, id, LANE_LOAD(hits + HIT_U * capacity, slot),
                               LANE_LOAD(hits + HIT_V * capacity, slot),
                               stream_load3(rays, capacity, RAY_DIRECTION_X, slot), hit, false);
      uint hit_bits = lane_bits(hit);
      for (uint bits = lane_bits(active); bits; bits &= bits - 1) {
        uint lane = lowest_bit(bits), i = first + lane;
        bool on_surface = hit_bits >> lane & 1;
        uint2 pixel = tile_pixel(first_tile + i / TILE_PIXELS, i % TILE_PIXELS, camera_tiles(camera));
        uint at = pixel.y * camera->width + pixel.x;
        if (fresh) {
          uint triangle = LANE_UINT(id, lane);
          uint object = on_surface ? object_of_triangle(object_starts, object_count, triangle) : AOV_NONE;
          values[AOV_DEPTH * picture_pixels + at] = on_surface ? LANE_FLOAT(t, lane) : INFINITY;
          ids[AOV_OBJECT * picture_pixels + at] = object;
          ids[AOV_PRIMITIVE * picture_pixels + at] = on_surface ? triangle - object_starts[object] : AOV_NONE;
          ids[AOV_MATERIAL * picture_pixels + at] = on_surface ? corners[triangle].material : AOV_NONE;
        }
        if (fresh || on_surface) {
          Vec3L zero = vec3l(FLOATL(0), FLOATL(0), FLOATL(0));
          if (fresh) plane_add3(values, AOV_POSITION, picture_pixels, at, on_surface ? s.position : zero, lane, 1);
          plane_add3(values, AOV_NORMAL, picture_pixels, at, on_surface ? s.normal : zero, lane, fresh);
          plane_add3(values, AOV_ALBEDO, picture_pixels, at, on_surface ? s.base : zero, lane, fresh);
        }
      }
    }
  }
}
