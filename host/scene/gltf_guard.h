// The pass before tinygltf: nothing that it returns without an error can make tinygltf, or what reads the model after
// it, leave an array, recurse deep or open a file.
#pragma once

#include "scene/gltf_context.h"

// Reads gltf->path into gltf->document, buffers and images, and checks it all: JSON nesting, types, required
// extensions, every index, the bounds of buffers, views and accessors, that nodes form a forest. `*json` (freed by the
// caller) is the document for tinygltf: without buffers, images, extras and unknown extensions.
//
// Errors: STATUS_NOT_FOUND, STATUS_BAD_SCENE, STATUS_UNSUPPORTED, STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_guard(char **json, Gltf *gltf);

// Views lie in their buffers; accessors and their sparse parts in their views. Errors: STATUS_BAD_SCENE.
Status gltf_check_bounds(Gltf *gltf);

// No node has two parents or is its own ancestor; scenes list each of their roots once. Errors: STATUS_BAD_SCENE,
// STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_check_forest(Gltf *gltf);
