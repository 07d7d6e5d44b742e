// A second, plain reading of glTF files in double precision, that shares nothing with the importer: for models that are
// fine, with one buffer, without sparse accessors.
#pragma once

#include <jansson.h>
#include <stddef.h>
#include <stdint.h>

typedef struct GltfRaw {
  json_t *json;
  uint8_t *file, *bin;  // `bin` lies in `file`
} GltfRaw;

GltfRaw gltf_raw_open(const char *path);
void gltf_raw_close(GltfRaw *raw);

// Numbers of an accessor, normalised where it says so; *count elements of *width. The caller frees them.
double *gltf_raw_numbers(const GltfRaw *raw, size_t accessor, size_t *count, size_t *width);

// Position of vertex `vertex` of the first primitive of the mesh of node `node`, in world space, when animation
// `animation` is at a time: by its skin, or by its morph targets and ancestors.
typedef struct GltfRawPose GltfRawPose;
GltfRawPose *gltf_raw_pose(const GltfRaw *raw, size_t animation, double time_s, size_t node);
size_t gltf_raw_vertex_count(const GltfRawPose *pose);
void gltf_raw_vertex(double out[3], const GltfRawPose *pose, size_t vertex);
void gltf_raw_pose_free(GltfRawPose *pose);
