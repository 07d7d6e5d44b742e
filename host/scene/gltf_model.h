// A glTF file as it stands, in plain C structs: what the C++ shim hands over and the importer turns into a Scene.
// Indices are the file's own, NONE where absent; the guard has checked that each one is in range. Pointers live as long
// as the model.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "scene/scene.h"

enum {
  COMPONENT_BYTE = 5120,
  COMPONENT_UBYTE,
  COMPONENT_SHORT,
  COMPONENT_USHORT,
  COMPONENT_UINT = 5125,
  COMPONENT_FLOAT
};
enum { MODE_TRIANGLES = 4, MODE_STRIP, MODE_FAN };
enum { FILTER_NEAREST = 9728, WRAP_GL_CLAMP = 33071, WRAP_GL_MIRROR = 33648 };

typedef enum Attribute {
  ATTRIBUTE_POSITION,
  ATTRIBUTE_NORMAL,
  ATTRIBUTE_TANGENT,
  ATTRIBUTE_TEXCOORD_0,
  ATTRIBUTE_TEXCOORD_1,
  ATTRIBUTE_COLOR_0,
  ATTRIBUTE_JOINTS_0,
  ATTRIBUTE_JOINTS_1,
  ATTRIBUTE_WEIGHTS_0,
  ATTRIBUTE_WEIGHTS_1,
  ATTRIBUTE_COUNT
} Attribute;

typedef struct GltfView {
  int buffer;
  uint64_t offset, size;
  uint32_t stride;  // 0: tightly packed
} GltfView;

// Elements from `offset` of a view on; all zero where view is NONE. `type` is a COMPONENT_ code.
typedef struct GltfSpan {
  int view;
  uint64_t offset;
  int type;
} GltfSpan;

typedef struct GltfAccessor {
  GltfSpan values;
  uint64_t count;
  uint32_t components;  // 1..4, 16 for MAT4; MAT2 is 4 and MAT3 9, read by nothing
  bool is_matrix, normalized;
  uint64_t sparse_count;  // elements that sparse_values replace, at sparse_indices
  GltfSpan sparse_indices, sparse_values;
} GltfAccessor;

typedef struct GltfPrimitive {
  int mode, material, indices;
  int attributes[ATTRIBUTE_COUNT];              // accessors
  const int (*targets)[ATTRIBUTE_TANGENT + 1];  // morph targets: accessors of position, normal and tangent deltas
  uint32_t target_count;
} GltfPrimitive;

typedef struct GltfMesh {
  const char *name;
  const GltfPrimitive *primitives;
  uint32_t primitive_count;
  const double *weights;  // of the morph targets
  uint32_t weight_count;
} GltfMesh;

typedef struct GltfNode {
  const char *name;
  int mesh, skin, camera, light;
  const int *children;
  uint32_t child_count;
  const double *matrix;  // NULL: translation, rotation and scale count
  double translation[3], rotation[4], scale[3];
  const double *weights;  // NULL: the mesh's own
  uint32_t weight_count;
  bool is_instanced;  // EXT_mesh_gpu_instancing, with the three accessors
  int instance_translation, instance_rotation, instance_scale;
} GltfNode;

typedef struct GltfSkin {
  const int *joints;
  uint32_t joint_count;
  int inverse_bind;  // accessor
} GltfSkin;

typedef struct GltfTexture {
  int image;
  WrapMode wrap_u, wrap_v;
  bool nearest;
} GltfTexture;

typedef struct GltfScene {
  const int *roots;
  uint32_t root_count;
} GltfScene;

// Materials, cameras and lights are the scene model's own structs, with the file's texture indices and without
// transforms.
typedef struct GltfModel {
  const GltfView *views;
  const GltfAccessor *accessors;
  const GltfMesh *meshes;
  const GltfNode *nodes;
  const GltfSkin *skins;
  const GltfTexture *textures;
  const GltfScene *scenes;
  const Material *materials;
  const Camera *cameras;
  const Light *lights;
  uint32_t accessor_count, mesh_count, node_count, texture_count, scene_count, material_count, animation_count;
  int default_scene;
} GltfModel;
