#include "passes/movers.h"

#include "passes/raster_view.h"

static bool casts(const DeviceScene *scene, const Mover *mover)
{
  return !scene->source->objects[mover->object].shadowless;
}

static bool any_seen(const DeviceScene *scene, const RasterView *view, bool casters_alone)
{
  for (uint32_t i = 0; i < scene->mover_count; i++) {
    const Mover *mover = &scene->movers[i];
    if (casters_alone && !casts(scene, mover)) continue;
    if (raster_view_may_see_box(view, mover->low, mover->high)) return true;
  }
  return false;
}

bool movers_seen(const DeviceScene *scene, const RasterView *view) { return any_seen(scene, view, false); }

bool moved_casters_seen(const DeviceScene *scene, const RasterView *view) { return any_seen(scene, view, true); }

// Where a corner's shadow ends: beyond all of the scene. Box and ends hold the shadow, as light that is farther from
// the box than that is wide sees it under less than 60 degrees.
static Vec3 shadow_end(const LightInfo *light, Vec3 corner, double way_m)
{
  const Float3 d = light->direction, p = light->position;
  Vec3 along = light->kind == LIGHT_KIND_DIRECTIONAL ? vec3(d.x, d.y, d.z) : vec3_sub(corner, vec3(p.x, p.y, p.z));
  return vec3_add(corner, vec3_scale(vec3_unit_or(along, vec3(0, 0, 0)), way_m));
}

static bool shadow_seen(const DeviceScene *scene, const Mover *mover, const LightInfo *light, const RasterView *view)
{
  Vec3 points[2 * BOX_CORNERS];
  const Float3 p = light->position;
  const Vec3 at = vec3(p.x, p.y, p.z), nearest = vec3_min(vec3_max(at, mover->low), mover->high);
  const double wide_m = vec3_length(vec3_sub(mover->high, mover->low)), away_m = vec3_length(vec3_sub(at, nearest));
  if (light->kind != LIGHT_KIND_DIRECTIONAL && !(away_m > wide_m)) return true;
  box_corners(points, mover->low, mover->high);
  for (int i = 0; i < BOX_CORNERS; i++)
    points[BOX_CORNERS + i] = shadow_end(light, points[i], 4 * (scene->extent_m + wide_m));
  return raster_view_may_see(view, points, 2 * BOX_CORNERS);
}

bool mover_shadows_seen(const DeviceScene *scene, const LightInfo *light, const RasterView *view)
{
  for (uint32_t i = 0; i < scene->mover_count; i++)
    if (casts(scene, &scene->movers[i]) && shadow_seen(scene, &scene->movers[i], light, view)) return true;
  return false;
}
