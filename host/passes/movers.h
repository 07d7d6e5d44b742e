// What moved since the frame before (device_scene_move), as views see it.
#pragma once

#include "device_scene/device_scene.h"
#include "shared/view.h"

// May anything that moved be drawn in the view, where it was or where it is? For casters, of what casts shadows.
bool movers_seen(const DeviceScene *scene, const RasterView *view);
bool moved_casters_seen(const DeviceScene *scene, const RasterView *view);

// May anything be that is in the shadow of what moved, there or there? Of a point, or of parallel light.
bool mover_shadows_seen(const DeviceScene *scene, const LightInfo *light, const RasterView *view);
