// Nodes of a glTF file made into objects, cameras and lights in world space.
#pragma once

#include "scene/gltf_context.h"

// Fills the meshes, objects, cameras and lights of `scene`, of the scene that the options choose. Objects that would
// draw no triangle are left out; EXT_mesh_gpu_instancing gives an object an instance; cameras that make no image (yfov
// outside (0, pi), znear <= 0 in a perspective, ymag <= 0, zfar <= znear) are left out with a warning.
//
// Errors: STATUS_USAGE (no such scene), STATUS_BAD_SCENE, STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_nodes_read(Scene *scene, Gltf *gltf);

// World transform of every node of the file, in any scene; the caller frees *out. Errors as above.
Status gltf_world_transforms(Mat4 **out, Gltf *gltf);

// Places of the instances of an EXT_mesh_gpu_instancing node, relative to the node; *out is NULL and *count 1 for other
// nodes. The caller frees *out. Errors as above.
Status gltf_instances_read(Mat4 **out, uint32_t *count, Gltf *gltf, const GltfNode *node);
