// Where a reflector's cube map is, and how large.
#pragma once

#include "render/frame.h"
#include "render/mirrors_seen.h"

enum { CUBE_LEAST_PX = 32, CUBE_MOST_PX = 512 };

// Texels a side of a face for a reflector that covers so many of the picture's pixels: a power of two, or the size that
// is asked for.
uint32_t cube_size_choose(const CubeOptions *options, double pixels);

// The same where rough surfaces alone ask: no more than its narrowest lobe needs. Each of its pixels is `factor` of the
// picture's wide.
uint32_t rough_cube_size_choose(const CubeOptions *options, const Reflector *reflector, uint32_t factor);

// The cube of an object; `sight` is how rough surfaces are seen, NULL for a mirror. first_texel is 0.
CubeInfo cube_fit(const DeviceScene *scene, uint32_t object, uint32_t size, const RoughSight *sight);

// The cube that a mirror has which covers so many of the picture's pixels.
CubeInfo reflector_cube(const Frame *frame, uint32_t object, double pixels);

// The same for an object of which rough surfaces alone are seen, of whose pixels each is `factor` of the picture's
// wide.
CubeInfo reflector_rough_cube(const Frame *frame, const Reflector *reflector, uint32_t factor);
