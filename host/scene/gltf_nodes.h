// Nodes of a glTF file made into objects, cameras and lights in world space.
#pragma once

#include "scene/gltf_places.h"

// Fills the meshes, objects, cameras and lights of `scene`, of the scene that the options choose, and says in *places,
// to be freed by the caller even after a failure, which nodes they came from. Objects that would
// draw no triangle are left out; EXT_mesh_gpu_instancing gives an object an instance; cameras that make no image (yfov
// outside (0, pi), znear <= 0 in a perspective, ymag <= 0, zfar <= znear) are left out with a warning.
//
// Errors: STATUS_USAGE (no such scene), STATUS_BAD_SCENE, STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_nodes_read(Scene *scene, GltfPlaces *places, Gltf *gltf);

// All of the scene that the options choose: what gltf_nodes_read reads, materials and images. On failure *out is
// untouched. Errors: those of gltf_read.
Status gltf_scene_read(Scene *out, GltfPlaces *places, Gltf *gltf);

// World transform of every node of the file, in any scene; the caller frees *out. Errors as above.
Status gltf_world_transforms(Mat4 **out, Gltf *gltf);

// How many objects a node's mesh makes: the instances of EXT_mesh_gpu_instancing, else 1.
uint32_t gltf_instance_count(const Gltf *gltf, const GltfNode *node);

// Places of those instances, relative to the node; NULL for other nodes. The caller frees *out. Errors as above.
Status gltf_instances_read(Mat4 **out, Gltf *gltf, const GltfNode *node);
