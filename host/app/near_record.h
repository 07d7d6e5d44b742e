// What is near reflectors, in the words of --stats.
#pragma once

#include <jansson.h>

#include "render/frame.h"

// By reflector with a cube map: each object of its list, with its triangles, the method that finds it and why that is
// not the one asked for; and what became of the rays. NULL where memory ran out.
json_t *near_objects_json(const Frame *frame);
