// Which nodes of a glTF file the things of a scene came from, and putting the things where their nodes are.
#pragma once

#include "scene/gltf_mesh.h"

typedef struct GltfPlaces {
  int *objects, *cameras, *lights;  // a node for each of the scene's
  int *meshes;                      // the node in whose pose a mesh is; NONE for one in its own
  uint32_t light_count;             // of the file; those that a scene is given besides stay where they are
} GltfPlaces;

// The pose that a node's mesh is in, of world transforms of all nodes; the node's own does not count where it has a
// skin. The caller frees *joints, to which out->world_from_bind points, even after a failure. Errors: STATUS_BAD_SCENE,
// STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_node_pose(GltfPose *out, Mat4 **joints, Gltf *gltf, const GltfNode *node, const Mat4 *worlds);

// Does a light of this node stand at a place that floats can hold? `world`: the node's.
bool gltf_light_has_place(const Light *light, const Mat4 *world);

// Gives objects, cameras and lights their places of world transforms of all nodes. Errors: STATUS_BAD_SCENE (a light at
// infinity; instances that cannot be read), STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_places_apply(Scene *scene, Gltf *gltf, const GltfPlaces *places, const Mat4 *worlds);

// Frees the arrays.
void gltf_places_free(GltfPlaces *places);
