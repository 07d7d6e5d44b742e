// One glTF import under way: what its stages share.
#pragma once

#include <stddef.h>

#include "scene/gltf.h"
#include "scene/gltf_model.h"

#define GLTF_HINT_REPAIR "repair the file or export it again"

typedef struct GltfBytes {
  const uint8_t *bytes;
  uint64_t size;
  uint8_t *owned;  // what to free; NULL where `bytes` lies in the GLB file
} GltfBytes;

typedef struct GltfImageSource {
  int view;         // index of the buffer view that holds it, or NONE
  const char *uri;  // data: or a file; NULL where a view holds it
} GltfImageSource;

typedef struct Gltf {
  const char *path;
  const GltfOptions *options;
  ImageHelper *images_helper;
  Log *log;
  uint64_t used_bytes;

  // From the guard.
  GltfBytes file;
  GltfBytes *buffers;
  uint32_t buffer_count;
  GltfImageSource *images;
  uint32_t image_count;
  struct json_t *document;  // owns the strings of `images`

  // From tinygltf.
  GltfModel *model;

  char where[160];  // the part being read, for messages: "meshes[3] 'leg' primitives[0]"
} Gltf;

// Fills what comes from the guard and from tinygltf; the caller closes it, even after a failure. Errors: those of
// gltf_guard and gltf_shim_load.
Status gltf_open(Gltf *gltf);
void gltf_close(Gltf *gltf);

// Records `path: cause: hint`, the cause formatted.
Status gltf_fail(Gltf *gltf, Status status, const char *hint, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

// Zeroed memory for `count` elements (of at least one byte in all), counted against options->max_memory_bytes; what is
// freed is not given back to the count. *out is NULL on failure. Errors: STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_allocate(void *out, Gltf *gltf, uint64_t count, size_t element_bytes);

// A copy of a string, counted likewise.
Status gltf_copy_name(char **out, Gltf *gltf, const char *name);
