// Materials, textures and images of a glTF file.
#pragma once

#include "scene/gltf_context.h"

// Fills the materials of `scene` (the file's, in its order, then glTF's default one where a primitive uses it), and the
// textures and images that used materials read. Images are decoded by gltf->images_helper. Slots of unused materials
// hold no texture. A slot that asks for a third UV set reads the first, with a warning.
//
// Errors: STATUS_BAD_SCENE, STATUS_NOT_FOUND, STATUS_BAD_IMAGE, STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_materials_read(Scene *scene, Gltf *gltf);
