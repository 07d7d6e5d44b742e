// One animation of a glTF file: keys of what moves, and their values at a time. Source: glTF 2.0 specification, section
// 3.11 and appendix C.
#pragma once

#include "scene/gltf_context.h"

typedef enum TrackPath { TRACK_TRANSLATION, TRACK_ROTATION, TRACK_SCALE, TRACK_WEIGHTS, TRACK_PATH_COUNT } TrackPath;
typedef enum Interpolation { INTERPOLATION_LINEAR, INTERPOLATION_STEP, INTERPOLATION_CUBIC } Interpolation;

// One thing of one node that moves.
typedef struct GltfTrack {
  int node;
  TrackPath path;
  Interpolation interpolation;
  uint32_t key_count, width;  // `width` numbers make a value: 3, 4 for a rotation, as many as there are morph targets
  float *times_s;             // [key_count], from 0 or later, rising
  float *values;              // [key_count][width]; INTERPOLATION_CUBIC: [key_count][in tangent, value, out][width]
} GltfTrack;

typedef struct GltfAnimation {
  GltfTrack *tracks;
  uint32_t track_count;
  double length_s;  // time of the last key
} GltfAnimation;

// The file's name of an animation, "" where it has none; it belongs to gltf->document.
const char *gltf_animation_name(const Gltf *gltf, uint32_t index);

// Index of the animation that a name or an index means. Errors: STATUS_USAGE (none; the nearest name, or how many there
// are, named), STATUS_NO_MEMORY.
Status gltf_animation_find(uint32_t *out, Gltf *gltf, const char *choice);

// Reads the keys of an animation of an opened file. Warns of channels that are not followed: of unknown paths, on nodes
// with a matrix or without morph targets, and of the later ones of two for the same thing; ignores those without node.
// Free with gltf_animation_free.
//
// Errors: STATUS_BAD_SCENE (times that are negative, not finite or do not rise; another shape or number of values than
// they ask for), STATUS_TOO_LARGE, STATUS_NO_MEMORY.
Status gltf_animation_read(GltfAnimation *out, Gltf *gltf, uint32_t index);
void gltf_animation_free(GltfAnimation *animation);

// Morph targets of a node's mesh, the most that one of its primitives has.
uint32_t gltf_target_count(const GltfModel *model, const GltfNode *node);

// Value at a time, `track->width` numbers; that of the first or last key outside of them. Rotations are interpolated on
// the sphere, the shorter way, or by splines: of any length, as mat4_from_trs wants them. The time must be a number.
void gltf_track_sample(double *out, const GltfTrack *track, double time_s);
