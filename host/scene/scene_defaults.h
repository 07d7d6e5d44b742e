// What a scene gets when nothing is said: a camera, light.
#pragma once

#include "scene/scene.h"

// Chooses a camera: by `choice` = "fit", an index (digits), or a name; NULL: the scene's first camera, else "fit".
//
// "fit" is scene_camera_fit of the scene's bounds. out->name belongs to the scene (NULL for a fitted view).
//
// Errors: STATUS_USAGE (no such camera; the message names the nearest one), STATUS_NO_MEMORY.
Status scene_camera_choose(Camera *out, const Scene *scene, const char *choice, double aspect, Log *log);

// A perspective view (yfov 45 degrees) from the front right, slightly above, at the centre of the bounds, as near as
// leaves their eight corners 5 % away from the edges of a picture of width / height = `aspect`; znear and zfar are a
// hundredth of the nearest and a hundred times the farthest corner's depth.
void scene_camera_fit(Camera *out, Vec3 low_world, Vec3 high_world, double aspect);

// The environment of a scene for which none was named. A scene with lights gets a black one. A scene without gets the
// built-in sky and (key_light) a sun that casts shadows, and a note in the log; a white diffuse surface then ends up
// below radiance 1 whichever way it faces. Errors: STATUS_NO_MEMORY.
Status scene_add_default_lighting(Scene *scene, bool key_light, Log *log);

// Makes the built-in gradient sky the scene's environment: irradiance about 1 from above.
void scene_set_sky(Scene *scene);
