// Kernel arguments that several passes take, in the order in which the kernels of cl/ declare them.
#pragma once

#include "device/device.h"
#include "device_scene/device_scene.h"

// AttributeSources of cl/lib/texture.cl.
#define ATTRIBUTE_ARGS(scene)                                                                                      \
  ARG_BUFFER((scene)->corners), ARG_BUFFER((scene)->uvs), ARG_BUFFER((scene)->colors), ARG((scene)->vertex_count), \
      ARG_BUFFER((scene)->materials), ARG_BUFFER((scene)->textures), ARG_BUFFER((scene)->texels),                  \
      ARG_BUFFER((scene)->linear_from_byte)

// Work-items that cover `rays` rays or pixels.
static inline size_t work_items(const Device *device, size_t rays)
{
  size_t each = device_traits(device)->rays_per_item;
  return (rays + each - 1) / each;
}
