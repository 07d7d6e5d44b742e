// Prefiltered levels of a cube map: what rough surfaces reflect of it (shared/cube.h).
//
//   cube_halve       an image of the cube half as large as another: four bilinear samples a texel, about its direction
//   cube_prefilter   a level: about each texel's direction n, the mean over reflections at GGX normals about n,
//                    weighted by n.l, the eye at n. Each sample reads an image as coarse as its neighbours are far
//
//   in    texels          the cube's; from_cube 1: images are halved from these
//         images          those halved so far: sizes size >> 1, size >> 2, ... one after the other
//         samples         of the level, [sample_count]
//   out   images, levels
//
//   Cost  four texels a sample: 64 bytes.
//   A texel's value is a function of its direction, so that faces that meet have the same texels on their edges (but
//   for rounding); samples are the same for all of them.
//   From  Karis, "Real Shading in Unreal Engine 4", 2013; Colbert, Krivanek, "GPU-Based Importance Sampling", GPU
//         Gems 3, 2007 (the coarser images).

#include "lib/cube.cl"
#include "lib/lanes.cl"

#define IMAGES_MOST 10

// Radiance, and 1 / distance, of an image in a direction of unit length.
static inline float4 image_value(global const float4 *texels, uint size, uint first, float3 direction, bool from_cube)
{
  CubePlace place = faces_place(size, first, direction);
  float4 value = cube_sample(texels, place);
  value.w *= from_cube ? place.major : 1;
  return value;
}

static inline void tangents(float3 n, float3 *across, float3 *down)
{
  float3 other = fabs(n.z) < 0.9f ? (float3)(0, 0, 1) : (float3)(1, 0, 0);
  *across = normalize(cross(other, n));
  *down = cross(n, *across);
}

kernel void cube_halve(uint from_cube, uint from_size, uint from_first, global const float4 *from, uint to_size,
                       uint to_first, global float4 *images)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM, end = min(begin + RAYS_PER_ITEM, CUBE_TEXELS(to_size));
  for (uint i = begin; i < end; i++) {
    float3 direction = face_direction(to_size, (uint2)(i % to_size, i / to_size)), across, down;
    float square = dot(direction, direction), texel = 2.0f / (float)(to_size - 1) / (square * rsqrt(sqrt(square)));
    float3 n = direction * rsqrt(square);
    tangents(n, &across, &down);
    float4 sum = 0;
    for (uint k = 0; k < 4; k++) {
      float3 aside = (k & 1 ? across : -across) + (k & 2 ? down : -down);
      sum += image_value(from, from_size, from_first, normalize(n + 0.25f * texel * aside), from_cube);
    }
    images[to_first + i] = 0.25f * sum;
  }
}

kernel void cube_prefilter(uint size, float size_log2, uint image_count, uint first_texel, global const float4 *texels,
                           global const float4 *images, global const PrefilterSample *samples, uint first_sample,
                           uint sample_count, uint level_size, uint first_level, global float4 *levels)
{
  uint begin = get_global_id(0) * RAYS_PER_ITEM, end = min(begin + RAYS_PER_ITEM, CUBE_TEXELS(level_size));
  uint firsts[IMAGES_MOST];
  firsts[0] = first_texel;
  firsts[1] = 0;
  for (uint k = 2; k < IMAGES_MOST; k++) firsts[k] = firsts[k - 1] + CUBE_TEXELS(size >> (k - 1));
  for (uint i = begin; i < end; i++) {
    float3 n = normalize(face_direction(level_size, (uint2)(i % level_size, i / level_size))), across, down;
    tangents(n, &across, &down);
    float4 sum = 0;
    for (uint k = first_sample; k < first_sample + sample_count; k++) {
      float image = rint(samples[k].halvings + size_log2);
      uint which = (uint)clamp(image, 0.0f, (float)(image_count - 1));
      float3 direction = across * samples[k].x + down * samples[k].y + n * samples[k].z;
      sum +=
          samples[k].weight * image_value(which ? images : texels, size >> which, firsts[which], direction, which == 0);
    }
    levels[first_level + i] = sum;
  }
}
