#include "passes/light_reach.h"

#include <math.h>

#include "passes/raster_view.h"

// What rounding in shaders may do to a cosine and, as a share, to a distance.
static const double cosine_slack = 1e-5, distance_slack = 1e-4;

// Cones that are wider are taken for all directions.
static const double least_cosine = 0.1;

static Vec3 wide(Float3 v) { return vec3(v.x, v.y, v.z); }

static bool shines(const LightInfo *light)
{
  return light->radiant.x > 0 || light->radiant.y > 0 || light->radiant.z > 0;
}

double place_slack_m(Vec3 low, Vec3 high)
{
  return 1e-5 * vec3_length(vec3_sub(high, low)) + 4e-7 * fmax(vec3_length(low), vec3_length(high));
}

static LightReach reach_of_box(Vec3 low, Vec3 high, double slack_m)
{
  const Vec3 slack = vec3(slack_m, slack_m, slack_m);
  LightReach reach = {
      .count = BOX_CORNERS, .low = vec3_sub(low, slack), .high = vec3_add(high, slack), .slack_m = slack_m};
  box_corners(reach.points, reach.low, reach.high);
  return reach;
}

// A place behind the light, from where the cone holds the light's own with slack, and a polygon about its end.
static LightReach reach_of_cone(Vec3 light, Vec3 along, double cosine, double way_m, double slack_m)
{
  const double sine = sqrt(1 - cosine * cosine), back_m = slack_m * (1 + 1 / sine), length_m = way_m + back_m + slack_m;
  const Vec3 at = vec3_sub(light, vec3_scale(along, back_m));
  LightReach reach = {.points = {at}, .count = 1, .low = at, .high = at, .slack_m = slack_m};
  const Vec3 other = fabs(along.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0);
  const Vec3 across = vec3_unit_or(vec3_cross(other, along), other), down = vec3_cross(along, across);
  const double rim_m = length_m * sine / cosine / cos(M_PI / LIGHT_RIM_POINTS);
  for (int i = 0; i < LIGHT_RIM_POINTS; i++) {
    const double turn = 2 * M_PI * i / LIGHT_RIM_POINTS;
    const Vec3 aside = vec3_add(vec3_scale(across, cos(turn) * rim_m), vec3_scale(down, sin(turn) * rim_m));
    const Vec3 point = vec3_add(at, vec3_add(vec3_scale(along, length_m), aside));
    reach.points[reach.count++] = point;
    reach.low = vec3_min(reach.low, point);
    reach.high = vec3_max(reach.high, point);
  }
  return reach;
}

LightReach light_reach(const LightInfo *light, Vec3 scene_low, Vec3 scene_high)
{
  const double slack_m = place_slack_m(scene_low, scene_high);
  const LightReach nowhere = {0}, everywhere = reach_of_box(scene_low, scene_high, slack_m);
  const Vec3 at = wide(light->position), along = wide(light->direction);
  if (!shines(light)) return nowhere;
  if (light->kind == LIGHT_KIND_DIRECTIONAL || !vec3_is_finite(at) || !vec3_is_finite(along)) return everywhere;
  const double range_m = (double)light->range_m * (1 + distance_slack);
  const Vec3 ranged = vec3(range_m, range_m, range_m);
  const double cosine = -(double)light->spot_offset / (double)light->spot_scale - cosine_slack;
  if (light->kind == LIGHT_KIND_SPOT && cosine > least_cosine) {
    double length_m = 0;
    for (int i = 0; i < BOX_CORNERS; i++)
      length_m = fmax(length_m, vec3_dot(vec3_sub(everywhere.points[i], at), along));
    return length_m > 0 ? reach_of_cone(at, along, cosine, fmin(length_m, range_m), slack_m) : nowhere;
  }
  return isfinite(range_m) ? reach_of_box(vec3_sub(at, ranged), vec3_add(at, ranged), slack_m) : everywhere;
}

bool light_reach_seen(const LightReach *reach, const RasterView *view, const ObjectFacts *objects, uint32_t count)
{
  if (reach->count == 0 || !raster_view_may_see(view, reach->points, reach->count)) return false;
  const Vec3 slack = vec3(reach->slack_m, reach->slack_m, reach->slack_m);
  for (uint32_t i = 0; i < count; i++) {
    const Vec3 low = vec3_max(vec3_sub(objects[i].low, slack), reach->low);
    const Vec3 high = vec3_min(vec3_add(objects[i].high, slack), reach->high);
    const bool meets = objects[i].drawn && low.x <= high.x && low.y <= high.y && low.z <= high.z;
    if (meets && raster_view_may_see_box(view, low, high)) return true;
  }
  return false;
}
