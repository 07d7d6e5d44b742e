// The trees of a scene on a device.
#pragma once

#include "accel/bvh_refit.h"
#include "device_scene/device_scene.h"

typedef struct SceneTrees {
  Bvh2 two;
  Bvh8 eight;      // empty where device_traits() does without
  BvhRefit refit;  // empty before scene_trees_link
} SceneTrees;

// Builds those that the device walks. Errors: those of bvh2_build.
Status scene_trees_build(SceneTrees *out, const Device *device, const FlatScene *flat, Log *log);
void scene_trees_free(SceneTrees *trees);

// Writes them whole, into buffers of exactly their sizes, and the scene's bounds. Errors: those of buffer_create.
Status scene_trees_put(DeviceScene *scene, Device *device, const SceneTrees *trees, Log *log);

// The same of trees that nobody needs here any more: on a CPU device their arrays become the buffers' own.
Status scene_trees_give(DeviceScene *scene, Device *device, SceneTrees *trees, Log *log);

// Prepares built trees, which must then stay where they are, for refits. Errors: STATUS_NO_MEMORY.
Status scene_trees_link(SceneTrees *trees, uint32_t triangle_count, Log *log);

// Writes what the last refit changed, and the scene's bounds. Queued: the trees must stay as they are until
// device_finish. Errors: STATUS_DEVICE.
Status scene_trees_write_moved(DeviceScene *scene, Device *device, const SceneTrees *trees, Log *log);
