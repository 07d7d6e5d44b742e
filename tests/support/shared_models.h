// The shared glTF models, for tests that go through all of them.
#pragma once

#include <stdint.h>

#include "scene/scene.h"

// Called with each model's path and its scene, which may be changed.
typedef void (*ModelVisit)(void *context, const char *path, Scene *scene);

// Visits every model that the import takes; returns how many. Skips the test, with a word, where the folder is not
// there.
uint32_t shared_models_visit(ModelVisit visit, void *context);
