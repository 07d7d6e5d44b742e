// --light-shadows: methods of single lights by name.
#pragma once

#include "app/options.h"
#include "scene/scene.h"

// Fills *out, which the caller frees, with the method of every light of the scene ([light_count] of ShadowMethod) for
// RenderSettings.light_shadows: what the option says of it, last where it says more than one thing, or else --shadows.
// NULL where the option was not given. A name is of all lights that have it (Light.name), #N of the Nth light of the
// scene. Errors: STATUS_USAGE: a name that no light has (those there are, named); STATUS_NO_MEMORY.
Status light_shadows_resolve(uint8_t **out, const RenderOptions *options, const Scene *scene, Log *log);
