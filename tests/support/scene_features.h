// One small scene that goes through every path of the kernels: a stage with textures of all kinds, masks, glass,
// mirrors, normal maps with and without tangents, vertex colours, a mirrored object and six lights.
#pragma once

#include "scene/scene.h"

// The caller frees the scene and may change it before it renders. The camera looks at all of it.
Scene scene_features(void);
Camera scene_features_camera(void);
