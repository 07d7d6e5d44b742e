// The scene model: what a glTF file's chosen scene draws, as plain arrays and resolved transforms.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/math3d.h"
#include "image/image.h"

enum { NONE = -1 };

typedef enum WrapMode { WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR } WrapMode;

typedef struct Texture {
  int image;  // index into Scene.images
  WrapMode wrap_u, wrap_v;
  bool nearest;  // magnification filter
} Texture;

// Where a material reads a texture: texture_uv = uv_from_uv * (u, v, 1), a 2 x 3 matrix in rows
// (KHR_texture_transform).
typedef struct TextureSlot {
  int texture;  // index into Scene.textures, or NONE
  uint32_t uv_set;
  float uv_from_uv[6];
} TextureSlot;

typedef enum AlphaMode { ALPHA_OPAQUE, ALPHA_MASK, ALPHA_BLEND } AlphaMode;

typedef struct Material {
  char *name;
  float base_color[4];  // linear
  float metallic, roughness;
  float emission[3];  // linear radiance, emissive strength included
  AlphaMode alpha_mode;
  float alpha_cutoff;
  bool double_sided, unlit;
  float normal_scale, occlusion_strength;
  TextureSlot base_color_slot, metallic_roughness_slot, emission_slot, normal_slot, occlusion_slot;
} Material;

// Triangles with one material, in object space. Arrays that the file lacks are NULL, save the normals: made when absent
// (flat, vertices then unshared).
typedef struct Primitive {
  uint32_t vertex_count, triangle_count;
  float (*positions)[3];
  float (*normals)[3];   // unit length
  float (*tangents)[4];  // xyz unit, w = sign of the bitangent
  float (*uvs[2])[2];
  float (*colors)[4];  // linear
  uint32_t (*triangles)[3];
  int material;  // index into Scene.materials; every primitive has one (glTF's default material is added when used)
} Primitive;

typedef struct Mesh {
  char *name;
  Primitive *primitives;
  uint32_t primitive_count;
} Mesh;

// A node that draws a mesh. Its index is the `object` AOV's number.
typedef struct Object {
  char *name;
  int mesh;
  Mat4 world_from_object;
  bool shadowless;  // blocks no shadow ray, and is seen and reflected all the same
} Object;

typedef enum CameraKind { CAMERA_PERSPECTIVE, CAMERA_ORTHOGRAPHIC } CameraKind;

// Looks along -Z of its own space, +Y up. world_from_camera is rotation and translation alone (scale removed).
typedef struct Camera {
  char *name;
  CameraKind kind;
  double yfov_rad;         // perspective: full vertical angle
  double ymag_m;           // orthographic: half the height
  double znear_m, zfar_m;  // zfar is INFINITY when the file gives none
  Mat4 world_from_camera;
} Camera;

typedef enum LightKind { LIGHT_POINT, LIGHT_SPOT, LIGHT_DIRECTIONAL } LightKind;

// KHR_lights_punctual: intensity in candela (point, spot) or lux (directional).
typedef struct Light {
  char *name;
  LightKind kind;
  float color[3];  // linear
  float intensity;
  double range_m;  // INFINITY when not given
  double inner_cone_rad, outer_cone_rad;
  Vec3 position_world;
  Vec3 direction_world;  // unit, the way the light shines
} Light;

typedef enum EnvironmentKind { ENVIRONMENT_CONSTANT, ENVIRONMENT_GRADIENT, ENVIRONMENT_IMAGE } EnvironmentKind;

// Radiance from infinitely far away. In an image, direction of point (u, v): (cos p sin t, cos t, sin p sin t) with
// p = 2 pi (u - 1/2), t = pi v. The gradient goes by y of the unit direction: zenith at 1, horizon at 0, ground below.
typedef struct Environment {
  EnvironmentKind kind;
  float constant[3];
  float zenith[3], horizon[3], ground[3];
  Image image;  // IMAGE_RADIANCE
  float intensity;
  double rotation_rad;  // about +Y
} Environment;

typedef struct Scene {
  char *path;
  Image *images;
  uint32_t image_count;
  Texture *textures;
  uint32_t texture_count;
  Material *materials;
  uint32_t material_count;
  Mesh *meshes;
  uint32_t mesh_count;
  Object *objects;
  uint32_t object_count;
  Camera *cameras;
  uint32_t camera_count;
  Light *lights;
  uint32_t light_count;
  Environment environment;
  bool incomplete;  // made in memory (scene_build.h), which ran out
} Scene;

void scene_free(Scene *scene);
void primitive_free(Primitive *primitive);

// glTF's default material: white, metallic 1, roughness 1, without textures. Its name is static, not to be freed.
Material material_default(void);

// Triangles drawn: the sum over objects.
uint64_t scene_triangle_count(const Scene *scene);

// Those of one object, at most UINT32_MAX.
uint32_t scene_object_triangles(const Scene *scene, uint32_t object);

// Bounds of one object, world space; false (and an untouched box) for one that draws nothing.
bool scene_object_bounds(const Scene *scene, uint32_t object, Vec3 *low_world, Vec3 *high_world);

// Bounds of everything drawn, world space; false (and an untouched box) for a scene that draws nothing.
bool scene_bounds(const Scene *scene, Vec3 *low_world, Vec3 *high_world);
