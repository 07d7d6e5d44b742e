// glTF 2.0 import.
#pragma once

#include "scene/scene.h"
#include "scene/scene_file.h"

typedef struct GltfOptions {
  int scene;                  // index, or NONE for the file's default scene
  bool allow_outside;         // URIs may leave the file's folder (--allow-outside)
  uint64_t max_memory_bytes;  // 0: no limit
  const SceneFile *changes;   // what a scene file says of the nodes; NULL: nothing
  // Called, where it is not NULL, when all but the images' pixels is there; what can be prepared meanwhile may be.
  void (*structure_known)(void *context, const Scene *scene);
  void *context;
} GltfOptions;

// Reads the scene of a .gltf or .glb file: nodes that draw, cameras and lights of the chosen scene with resolved world
// transforms, and the images its materials use, decoded by `images`.
//
// Before tinygltf sees a byte, a pass of our own parses the JSON to a limited depth, checks that buffers, views and
// accessors lie within their bounds and that nodes form a forest, and resolves URIs (data:, or files in the folder of
// `path`). A required extension that is unknown is STATUS_UNSUPPORTED by name; what is read but not rendered is a
// warning by name. On failure *out is untouched and `log` holds `path: cause: hint`.
//
// Skins and morph targets are applied in the pose at rest. Nothing is left in scene->environment (see
// scene_add_default_lighting).
//
// Errors: STATUS_USAGE (no such scene), STATUS_NOT_FOUND, STATUS_BAD_SCENE, STATUS_BAD_IMAGE, STATUS_UNSUPPORTED,
// STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_read(Scene *out, const char *path, const GltfOptions *options, ImageHelper *images, Log *log);
