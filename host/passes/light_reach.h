// Where a light shines at all.
#pragma once

#include "device_scene/device_scene.h"
#include "plan/near_list.h"
#include "shared/view.h"

enum { LIGHT_RIM_POINTS = 8, LIGHT_REACH_POINTS = LIGHT_RIM_POINTS + 1 };

// What a light adds is zero, to the last bit, outside of the convex hull of points and of the box [low, high], world
// space, for all that lies in the scene's bounds: by its range, a spot light's cone, and that it gives off anything.
// Surfaces that face away and shadows do not count. Without points it shines nowhere.
typedef struct LightReach {
  Vec3 points[LIGHT_REACH_POINTS];
  uint32_t count;
  Vec3 low, high;
  double slack_m;  // of all of it and of places on surfaces
} LightReach;

// What rounding may do to a place in a scene's bounds.
double place_slack_m(Vec3 scene_low, Vec3 scene_high);

LightReach light_reach(const LightInfo *light, Vec3 scene_low, Vec3 scene_high);

// May something be seen in the view that the light shines on, of objects [0, count)?
bool light_reach_seen(const LightReach *reach, const RasterView *view, const ObjectFacts *objects, uint32_t count);
