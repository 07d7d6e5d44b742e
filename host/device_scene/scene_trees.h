// The trees of a scene on a device.
#pragma once

#include "accel/bvh.h"
#include "device_scene/device_scene.h"

// Builds those that the device walks: the wide one stays empty where device_traits() does without. The caller frees
// both. Errors: those of bvh2_build.
Status scene_trees_build(Bvh2 *bvh2, Bvh8 *bvh8, const Device *device, const FlatScene *flat, Log *log);

// Writes them whole, into buffers of exactly their sizes, and the scene's bounds. Errors: those of buffer_create.
Status scene_trees_put(DeviceScene *scene, Device *device, const Bvh2 *bvh2, const Bvh8 *bvh8, Log *log);

// Sets the scene's bounds by the root's box.
void scene_trees_bounds(DeviceScene *scene, const Bvh2 *bvh2);
