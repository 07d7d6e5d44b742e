#include "plan/plan.h"

Plan plan_make(const RenderSettings *settings, const SceneFacts *facts)
{
  bool reflect = settings->reflections == REFLECTIONS_RAYS && facts->has_mirrors && settings->max_depth > 0;
  return (Plan){
      .lighting = settings->lighting,
      .shadow_rays = settings->shadows == SHADOWS_RAYS && facts->light_count > 0,
      .reflected_rays = reflect,
      .transmitted_rays = facts->has_blends,
      .environment_light = settings->lighting == LIGHTING_PBR && facts->environment_lights,
      .max_depth = reflect ? settings->max_depth : 0,
      .ambient = settings->ambient,
  };
}
