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

#endif
