// A scene on a device that has followed its source, against one made anew.
#pragma once

#include "device_scene/device_scene.h"

// What a buffer holds; the caller frees it.
void *buffer_copied(Device *device, const DeviceBuffer *buffer);

// Fails the test unless the trees on the device, of a scene made movable, are whole, tight trees of its source as it is
// now.
void moved_scene_assert_trees(Device *device, const DeviceScene *scene);

// Fails the test unless also every other buffer, the triangles whatever their order, the bounds and the host's lights
// are those of a scene made anew.
void moved_scene_assert_as_new(Device *device, const DeviceScene *scene);
