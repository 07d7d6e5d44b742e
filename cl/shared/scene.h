// The scene as arrays, as host/device_scene flattens it and the kernels read it. World space throughout.
#ifndef SHARED_SCENE_H
#define SHARED_SCENE_H

#include "shared/types.h"

#define TEXTURE_NONE 0xffffffffu

// Corners (indices into the vertex arrays) and material of triangle `id`.
typedef struct TriangleCorners {
  uint vertex[3];
  uint material;
} TriangleCorners;
SHARED_SIZE(TriangleCorners, 16);

#define WRAP_MODE_REPEAT 0u
#define WRAP_MODE_CLAMP 1u
#define WRAP_MODE_MIRROR 2u

// Texels are four bytes, RGBA, row-major from the top left, at [first_texel] of one array for all textures.
typedef struct TextureInfo {
  uint first_texel;
  uint width, height;
  uint wrap_u, wrap_v;  // WRAP_MODE_*
  uint nearest;
} TextureInfo;
SHARED_SIZE(TextureInfo, 24);

// texture uv = matrix (2 x 3, rows) times (u, v, 1) of the vertex's set.
typedef struct TextureUse {
  uint texture;  // TEXTURE_NONE
  uint uv_set;
  float matrix[6];
} TextureUse;
SHARED_SIZE(TextureUse, 32);

#define MATERIAL_UNLIT 1u
#define MATERIAL_MASKED 2u
#define MATERIAL_SINGLE_SIDED 4u
#define MATERIAL_BLENDED 8u

typedef struct MaterialInfo {
  float base_color[4];  // linear
  float emission[3];    // linear radiance
  float metallic, roughness;
  float alpha_cutoff;
  uint flags;  // MATERIAL_*
  float normal_scale, occlusion_strength;
  TextureUse base_color_use, metallic_roughness_use, emission_use, normal_use, occlusion_use;
} MaterialInfo;
SHARED_SIZE(MaterialInfo, 212);

#define LIGHT_KIND_POINT 0u
#define LIGHT_KIND_SPOT 1u
#define LIGHT_KIND_DIRECTIONAL 2u

// KHR_lights_punctual. radiant = colour x intensity: candela (point, spot) or lux (directional).
typedef struct LightInfo {
  uint kind;
  Float3 position;
  Float3 direction;  // unit, the way it shines
  Float3 radiant;
  float range_m;                  // INFINITY where none
  float spot_scale, spot_offset;  // attenuation = saturate(cos * scale + offset)^2
} LightInfo;
SHARED_SIZE(LightInfo, 52);

#define ENVIRONMENT_KIND_CONSTANT 0u
#define ENVIRONMENT_KIND_GRADIENT 1u
#define ENVIRONMENT_KIND_IMAGE 2u

// Radiance from far away; the colours have the intensity in them. `harmonics` are the nine real spherical harmonics of
// the radiance in the order of Ramamoorthi and Hanrahan 2001: 00, 1-1, 10, 11, 2-2, 2-1, 20, 21, 22, in world space.
typedef struct EnvironmentInfo {
  uint kind;
  uint width, height;  // of the image
  float cos_rotation, sin_rotation;
  float intensity;                 // of the image's pixels
  Float3 zenith, horizon, ground;  // constant: all three alike
  Float3 harmonics[9];
} EnvironmentInfo;
SHARED_SIZE(EnvironmentInfo, 168);

// The environment as seen in rough surfaces (host/device_scene/environment_levels.h): level k for roughness 2^(-k / 2),
// as equirectangular images like the environment's, ENVIRONMENT_LEVEL_WIDTH(k) wide and half as high, one after the
// other. Without intensity where the environment is an image.
#define ENVIRONMENT_LEVELS 7
#define ENVIRONMENT_LEVEL_WIDTH(k) ((k) < 3 ? 32 : 8 << (k))
#define ENVIRONMENT_LEVEL_FIRST(k) ((k) < 3 ? 512 * (k) : 1536 + ((1 << (2 * (k))) - 64) * 32 / 3)  // pixel

// Luminance, by which directions are chosen.
#define LUMINANCE_R 0.2126f
#define LUMINANCE_G 0.7152f
#define LUMINANCE_B 0.0722f

// Table that chooses directions of an environment image by its luminance: floats. A cell lies between four texel
// centres; row r of them, 0 <= r <= height, between rows r - 1 and r, the first and the last half as high as the
// others; column c between columns c and c + 1. With R = height + 1:
//   search tree        share of the rows before row r
//   [R]                density, 1 / sr, of a direction in row r over its luminance (without intensity) / sin(theta)
//   [R] search trees   share of the columns of the row before column c
//
// A search tree finds the last of `count` rising numbers that is not above x: the numbers themselves, padded by
// TABLE_END to whole blocks of TABLE_BLOCK; before them every TABLE_BLOCK-th of them, padded likewise; and so on up to
// one block, which comes first. A search reads a block a level.
#define TABLE_BLOCK 16
#define TABLE_END 2.0f
#define ENVIRONMENT_TABLE_ROWS(height) ((height) + 1)
#define TABLE_BLOCKS(count) (((count) + TABLE_BLOCK - 1) / TABLE_BLOCK)

// Floats in a search tree.
static inline uint search_tree_size(uint count)
{
  uint size = 0;
  do {
    count = TABLE_BLOCKS(count);
    size += count * TABLE_BLOCK;
  } while (count > 1);
  return size;
}

#endif
