// Where a light's shadow maps look: their number, projection and size. No OpenCL.
#pragma once

#include "passes/camera_rays.h"
#include "passes/raster_view.h"
#include "plan/plan.h"
#include "shared/scene.h"
#include "shared/shadow.h"

enum { SHADOW_MAP_LEAST_PX = 256, SHADOW_MAP_MOST_PX = 4096 };

// What the maps are fitted to.
typedef struct ShadowScope {
  const CameraInfo *camera;
  Vec3 low, high;  // the scene's bounds, world space
} ShadowScope;

typedef struct ShadowFit {
  ShadowInfo info;
  ShadowView views[SHADOW_VIEWS_MOST];
} ShadowFit;

// Spot lights: one map about the outer cone; six faces where it is wider than 120 degrees, as for point lights.
// Directional lights: the scene as seen along the light, and before it up to three cascades, each a part of what the
// camera sees, wherever that is less than the whole (from Zhang, Sun, Xu, Lun, "Parallel-Split Shadow Maps for
// Large-scale Virtual Environments", 2006); maps move by whole texels. Casters before a map's near plane are drawn at
// depth 0, where the eye plane allows; receivers before it are lit, whatever stands before them: the near plane of a
// point or spot light's maps is at a small share of the way to the farthest point of the scene.
//
// With options->map_size_px 0 the size is the power of two, of SHADOW_MAP_LEAST_PX to SHADOW_MAP_MOST_PX, at which a
// texel is no larger on the picture than a pixel for half of the points of a grid over what the camera sees
// (magnification 1; a cascade takes its slice for what it sees). The texels of all views together stay under 2^24.
//
// False for a light without power, or whose position is not finite.
bool shadow_fit(ShadowFit *out, const LightInfo *light, ShadowMethod method, const ShadowOptions *options,
                const ShadowScope *scope);
