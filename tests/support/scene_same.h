// Are two scenes the same, as far as poses can change them?
#pragma once

#include "scene/scene.h"

// Bit for bit: objects, cameras and lights without names, and the arrays of all primitives.
bool scenes_same(const Scene *a, const Scene *b);
