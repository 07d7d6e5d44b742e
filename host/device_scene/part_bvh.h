// The BVH of a scene, or of some of its objects.
#pragma once

#include "accel/bvh.h"
#include "device_scene/flat_scene.h"

// How every tree of a scene is built.
extern const BvhOptions flat_bvh_options;

// Errors: those of bvh2_build.
Status flat_bvh_make(Bvh2 *out, const FlatScene *flat, Log *log);

// Triangles are as the whole scene's tree has them, bit for bit, with the scene's ids. `objects` rise, [object_count].
// Free it with bvh2_free. Errors: those of flat_geometry_make and
// bvh2_build.
Status part_bvh_make(Bvh2 *out, const Scene *scene, const uint32_t *objects, uint32_t object_count, Log *log);
