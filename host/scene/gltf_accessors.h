// Accessors decoded: any component type, normalised or not, interleaved, sparse. Sources: glTF 2.0 specification,
// sections 3.6.2 and 3.11 (normalised integers).
#pragma once

#include "scene/gltf_context.h"

// Reads an accessor of `least` to `components` components (missing ones become 1) and of `count` elements, or of any
// number where that is 0. *out, a float (*)[components], is the caller's to free. Zeros where it has no buffer view.
//
// Errors: STATUS_BAD_SCENE (another shape; a value that is not finite), STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_read_floats(void *out, Gltf *gltf, int accessor, uint32_t components, uint32_t least, uint64_t count);

// Reads an accessor of unsigned integers below `limit`; else as gltf_read_floats. *out is a uint32_t (*)[components].
Status gltf_read_indices(void *out, Gltf *gltf, int accessor, uint32_t components, uint64_t count, uint64_t limit);
