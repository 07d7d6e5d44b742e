// Meshes of a glTF file made into triangles.
#pragma once

#include "scene/gltf_context.h"

// The pose a mesh is drawn in. With joints, vertices come out in world space.
typedef struct GltfPose {
  const double *weights;  // of the morph targets; those missing count as 0
  uint32_t weight_count;
  const Mat4 *world_from_bind;  // one a joint; NULL for a mesh without skin
  uint32_t joint_count;
} GltfPose;

// Reads a mesh in a pose. Points and lines, and primitives without positions, are left out with a warning; primitives
// without a material get index model->material_count. Normals are made where absent (flat) and unit length elsewhere.
// On failure *out may be partly filled: the caller frees it with its scene.
//
// Errors: STATUS_BAD_SCENE, STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_mesh_read(Mesh *out, Gltf *gltf, int mesh, const GltfPose *pose);

// Gives the vertices of a mesh, which gltf_mesh_read filled from the same, another pose; their arrays stay. After a
// failure some of them have it. Errors as above.
Status gltf_mesh_pose(Mesh *out, Gltf *gltf, int mesh, const GltfPose *pose);

// Moves a primitive's vertices by its morph targets and skin.
Status gltf_pose_apply(Primitive *primitive, Gltf *gltf, const GltfPrimitive *from, const GltfPose *pose);

// Normals and tangents as the scene model wants them: made flat where absent (vertices then unshared), else unit
// length; a zero normal becomes the mean of its triangles'.
Status gltf_normals_finish(Primitive *primitive, Gltf *gltf);
