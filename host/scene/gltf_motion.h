// glTF 2.0 animations: a scene that is posed at times. Source: glTF 2.0 specification, sections 3.11 and appendix C.
#pragma once

#include "scene/gltf.h"

typedef struct GltfMotion GltfMotion;  // a glTF file kept open, with one of its animations chosen

// As gltf_read (scene/gltf.h), and keeps the file open: `scene` is in its pose at rest. `animation`: a name or an index
// of one of the file's animations; NULL: the first, or none where the file has none. A warning names what is animated
// but not followed (KHR_animation_pointer, a node with a matrix, a second channel for the same thing). `options` and
// `path` need not outlive the call; `images` is not kept.
//
// Errors: those of gltf_read, among them STATUS_BAD_SCENE where the keys of the animation are not as glTF wants them;
// STATUS_USAGE: no such animation (the nearest name, or those there are, named).
Status gltf_motion_open(GltfMotion **out, Scene *scene, const char *path, const GltfOptions *options,
                        const char *animation, ImageHelper *images, Log *log);

// When the animation's last key is; 0 without animation.
double gltf_motion_length_s(const GltfMotion *motion);

// Poses the objects, meshes (morph targets, skins), cameras and lights of `scene`, which gltf_motion_open filled, at a
// time in place: counts, order and addresses of vertices, triangles and objects stay. Before the first key and after
// the last the pose there holds. The same time gives the same bytes whatever was posed before.
//
// Cost: linear in the vertices of the meshes that have a skin or animated weights, and in nodes and keys' logarithms.
// Errors: STATUS_USAGE (the time is not a number), STATUS_BAD_SCENE (a transform or a vertex that is not finite then),
// STATUS_TOO_LARGE, STATUS_NO_MEMORY; the scene is then posed in part.
Status gltf_motion_pose(GltfMotion *motion, Scene *scene, double time_s, Log *log);

// Frees it all, and not the scene. NULL is fine.
void gltf_motion_close(GltfMotion *motion);
