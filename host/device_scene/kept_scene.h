// What the host keeps of a scene on a device, so that it can follow one that moves.
#pragma once

#include "accel/box.h"
#include "device_scene/scene_trees.h"

// What moved of a part, bit by bit.
enum { MOVED_SHADING = 1, MOVED_SHAPE = 2 };  // normals or tangents; positions or corners

struct KeptScene {
  FlatScene flat;          // the geometry that the device holds
  FlatScene before;        // of what may have moved last: its positions, normals, tangents and corners before that
  uint32_t (*triples)[3];  // [triangle_count], the corners' vertices

  FlatPart *parts;
  uint8_t *parts_moved;  // [part_count], MOVED_* in the last kept_scene_follow
  uint32_t *candidates;  // [candidate_count], parts of objects whose mesh or transform changed; then, of movers
  Box *boxes;            // [candidate_count], of a mover's part, before and after
  uint32_t part_count, candidate_count;

  Mat4 *transforms;     // [object_count], of the last pose
  float **meshes;       // [mesh_count], of the last pose: positions, normals and tangents, primitive by primitive
  uint8_t *mesh_moved;  // [mesh_count]
  uint32_t mesh_count;

  SceneTrees trees;
  BvhIds *moved;  // [object_count] at most, triangles of movers whose shape moved
};

// Takes the geometry of `flat` and the trees, which are then empty, and copies the pose of `scene`.
// Errors: STATUS_NO_MEMORY.
Status kept_scene_make(KeptScene **out, FlatScene *flat, SceneTrees *trees, const Scene *scene, Log *log);
void kept_scene_free(KeptScene *kept);

// Flattens anew what may have moved, on both cores, and finds what did: marks the parts and lists the movers, up to
// [object_count]. Returns how many there are. Where nothing moved it only reads each mesh and its copy.
uint32_t kept_scene_follow(KeptScene *kept, Mover *movers, const Scene *scene);

// Moves the trees to the movers' shapes of the last kept_scene_follow; false where they have to be built anew.
bool kept_scene_refit(KeptScene *kept);
