// What a glTF file holds, drawn or not: its own lists, counted.
#pragma once

#include "scene/gltf.h"

enum { GLTF_MAX_EXTENSIONS = 64 };

typedef struct GltfContents {
  char version[16], generator[128];
  uint32_t scenes, nodes, meshes, materials, textures, images, cameras, lights, skins, animations;
  uint32_t morph_targets;  // over all primitives
  uint64_t buffer_bytes;
  struct {
    char name[64];
    bool is_required;
  } extensions[GLTF_MAX_EXTENSIONS];  // extensionsUsed, in the file's order
  uint32_t extension_count;
} GltfContents;

// Reads it as gltf_read begins to: same checks, same errors; `log` gets failures and no warnings.
Status gltf_contents_read(GltfContents *out, const char *path, const GltfOptions *options, Log *log);
