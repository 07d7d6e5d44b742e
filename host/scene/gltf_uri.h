// URIs of buffers and images: data held in the URI, or files that must lie in the glTF's own folder.
#pragma once

#include "scene/gltf_context.h"

bool gltf_uri_is_data(const char *uri);

// Decodes a data: URI (base64 or percent-encoded). The caller frees out->owned. Errors: STATUS_BAD_SCENE,
// STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_uri_decode_data(GltfBytes *out, Gltf *gltf, const char *uri);

// Turns a path relative to the folder of gltf->path into that of an existing file; the caller frees *out. Unless
// options->allow_outside, the file, symbolic links followed, must lie in that folder or below. Errors:
// STATUS_NOT_FOUND, STATUS_BAD_SCENE (outside), STATUS_NO_MEMORY.
Status gltf_path_resolve(char **out, Gltf *gltf, const char *path);

// The same for a relative URI. Errors: those, and STATUS_UNSUPPORTED (http: and the like).
Status gltf_uri_resolve(char **out, Gltf *gltf, const char *uri);

// Reads a regular file, its first `size` bytes or (size 0) all of it. `what` names it in messages. The caller frees
// out->owned. Errors: STATUS_NOT_FOUND, STATUS_BAD_SCENE (shorter than `size`), STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_file_read(GltfBytes *out, Gltf *gltf, const char *what, uint64_t size);
