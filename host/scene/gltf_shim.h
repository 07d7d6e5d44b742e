// tinygltf behind a C interface.
#pragma once

#include <stddef.h>

#include "base/log.h"
#include "scene/gltf_model.h"

// Parses a self-contained glTF JSON document (no buffers, no images: the guard keeps both) with tinygltf. `path` is for
// messages. Free with gltf_shim_free. Errors: STATUS_BAD_SCENE, STATUS_NO_MEMORY.
Status gltf_shim_load(GltfModel **out, const char *json, size_t size, const char *path, Log *log);
void gltf_shim_free(GltfModel *model);
