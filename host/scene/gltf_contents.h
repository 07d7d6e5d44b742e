// What a glTF file holds, drawn or not: its own lists, counted.
#pragma once

#include "scene/gltf.h"

enum { GLTF_MAX_EXTENSIONS = 64 };

typedef struct GltfAnimationContents {
  char name[64];
  bool is_fine;          // else a warning says why it cannot be followed, and the rest is 0
  double length_s;       // time of its last key
  uint32_t node_count;   // nodes that it moves, turns or scales
  uint32_t morph_count;  // nodes whose morph targets it weighs
} GltfAnimationContents;

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
  GltfAnimationContents *animation_list;  // [animations]
} GltfContents;

// Reads it as gltf_read begins to: same checks, same errors; of warnings, `log` gets those of animations. Free with
// gltf_contents_free.
Status gltf_contents_read(GltfContents *out, const char *path, const GltfOptions *options, Log *log);
void gltf_contents_free(GltfContents *contents);
