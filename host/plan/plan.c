#include "plan/plan.h"

Plan plan_make(const RenderSettings *settings, const SceneFacts *facts)
{
  PrimaryFacts primary = {facts->triangle_count, facts->pixel_count, settings->samples, facts->gpu};
  PrimaryCost cost = primary_cost(&primary);
  bool reflect = settings->reflections == REFLECTIONS_RAYS && facts->has_mirrors && settings->max_depth > 0;
  return (Plan){
      .lighting = settings->lighting,
      .primary = primary_choose(settings->primary, &cost),
      .primary_cost = cost,
      .shadow_rays = settings->shadows == SHADOWS_RAYS && facts->light_count > 0,
      .reflected_rays = reflect,
      .transmitted_rays = facts->has_blends,
      .environment_light = settings->lighting == LIGHTING_PBR && facts->environment_lights,
      .max_depth = reflect ? settings->max_depth : 0,
      .ambient = settings->ambient,
  };
}
