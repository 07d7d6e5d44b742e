// The JSON part of a glTF file: parsed with bounded nesting, stripped of what nothing here reads, and checked.
#pragma once

#include <jansson.h>

#include "scene/gltf_context.h"

// Deepest nesting of arrays and objects that is parsed; jansson, tinygltf and what follows recurse over it.
enum { GLTF_MAX_NESTING = 128 };

// What a file of JSON ought to be, and what to do where it is not.
typedef struct JsonFile {
  const char *name, *hint;  // of what does not even begin as an object
  const char *nesting_hint, *repair_hint;
  size_t flags;  // of json_loadb
} JsonFile;

// Parses an object of JSON, a byte order mark before it or not. Errors: STATUS_BAD_SCENE (not JSON, not an object,
// nested too deep), STATUS_TOO_LARGE.
Status gltf_json_object(json_t **out, Gltf *gltf, const GltfBytes *file, const JsonFile *kind);

// Parses gltf->document so.
Status gltf_json_parse(Gltf *gltf, const GltfBytes *text);

// Refuses versions other than 2.x and required extensions that are unknown, by name; warns of used ones that are.
// Errors: STATUS_BAD_SCENE, STATUS_UNSUPPORTED.
Status gltf_json_check_header(Gltf *gltf);

// Removes `extras` and unknown extensions, and writes numbers so that tinygltf reads them as meant: whole ones as
// integers, and within extensions those beyond 31 bits as reals.
void gltf_json_prune(json_t *node);

// Checks types, array lengths, names from closed lists, and that every index is in range. Errors: STATUS_BAD_SCENE.
Status gltf_json_check_rules(Gltf *gltf);

// Non-negative integer member, `fallback` where absent; what gltf_json_check_rules has seen needs no error path.
uint64_t gltf_json_uint(const json_t *object, const char *name, uint64_t fallback);
