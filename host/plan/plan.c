#include "plan/plan.h"

#include <string.h>

// Noise is the price of samples.
static bool samples_pay(const RenderSettings *settings)
{
  return settings->methods == METHODS_EXACT || settings->samples >= SAMPLED_FROM;
}

static EnvironmentLightMethod environment_light_choose(const RenderSettings *settings, const SceneFacts *facts)
{
  if (settings->lighting != LIGHTING_PBR || !facts->environment_lights) return ENVIRONMENT_LIGHT_NONE;
  if (settings->environment_light != ENVIRONMENT_LIGHT_AUTO) return settings->environment_light;
  return samples_pay(settings) ? ENVIRONMENT_LIGHT_SAMPLED : ENVIRONMENT_LIGHT_SH;
}

const char *reflections_name(ReflectionMethod method)
{
  static const char *const names[] = {"like-first", "none",   "environment", "cube",  "box",    "impostor",
                                      "snapshot",   "planar", "candidates",  "mixed", "hybrid", "rays"};
  return names[method];
}

// Maps hold few samples: what is random would have noise in them that rays do not have.
static ReflectionMethod reflections_choose(ReflectionMethod asked, uint32_t shadow_methods, bool lobes,
                                           EnvironmentLightMethod environment_light)
{
  bool by_chance = lobes || shadow_methods & SHADOW_SET(SHADOWS_AREA) || environment_light == ENVIRONMENT_LIGHT_SH_AO;
  return asked == REFLECTIONS_HYBRID && by_chance ? REFLECTIONS_RAYS : asked;
}

static bool shows_less_than_rays(ReflectionMethod method)
{
  return reflections_use_maps(method) && method != REFLECTIONS_HYBRID;
}

static float max_roughness_choose(const RenderSettings *settings, const SceneFacts *facts)
{
  float most = settings->max_roughness;
  if (settings->lighting != LIGHTING_PBR) return 0;
  if (most < 0 && reflections_answer_lobes(settings->reflections)) most = 1;
  if (most < 0 && shows_less_than_rays(settings->reflections)) most = 0;
  if (most < 0) most = samples_pay(settings) || settings->environment_light == ENVIRONMENT_LIGHT_SAMPLED ? 1 : 0;
  return facts->least_roughness <= most ? most : 0;
}

static float exact_roughness_of(const RenderSettings *settings, const SceneFacts *facts)
{
  const float most = settings->max_roughness < 0 ? 1 : settings->max_roughness;
  return settings->lighting == LIGHTING_PBR && facts->least_roughness <= most ? most : 0;
}

typedef struct ShadowChoice {
  uint32_t methods;       // set of those that lights have
  uint32_t hybrid_kinds;  // as in the plan
  uint32_t kinds;         // of lights that are there
  ShadowCost costs[SHADOW_LIGHT_KINDS];
} ShadowChoice;

// The methods that one that is asked for means.
static uint32_t methods_of(ShadowMethod asked, const ShadowChoice *choice, const RenderSettings *settings)
{
  const uint32_t allowed = settings->allowed_shadows ? settings->allowed_shadows : ~0u;
  if (asked != SHADOWS_AUTO) return SHADOW_SET(shadow_method_within(allowed, asked));
  const bool is_hybrid = choice->hybrid_kinds && allowed & SHADOW_SET(SHADOWS_HYBRID);
  return (is_hybrid ? SHADOW_SET(SHADOWS_HYBRID) : 0) |
         (!is_hybrid || choice->kinds & ~choice->hybrid_kinds ? SHADOW_SET(SHADOWS_RAYS) : 0);
}

static ShadowChoice shadows_choose(const RenderSettings *settings, const SceneFacts *facts)
{
  static const uint32_t maps[SHADOW_LIGHT_KINDS] = {6, 1, 4};  // point, spot, directional
  ShadowChoice choice = {0};
  for (uint32_t kind = 0; kind < SHADOW_LIGHT_KINDS; kind++) {
    const SequenceFacts *sequence = &facts->sequence;
    ShadowCostFacts cost = {.triangles = facts->triangle_count,
                            .pixels = facts->pixel_count,
                            .samples = settings->samples,
                            .maps = maps[kind],
                            .gpu = facts->gpu,
                            .frames = sequence->frames,
                            .kept = sequence->kept[kind]};
    choice.costs[kind] = shadow_cost(&cost);
    if (facts->lights_by_kind[kind] == 0) continue;
    choice.kinds |= 1u << kind;
    if (shadow_hybrid_gains(&choice.costs[kind])) choice.hybrid_kinds |= 1u << kind;
  }
  if (facts->light_count == 0)
    choice.methods = SHADOW_SET(SHADOWS_NONE);
  else if (!settings->light_shadows)
    choice.methods = methods_of(settings->shadows, &choice, settings);
  else
    for (uint32_t i = 0; i < facts->light_count; i++)
      choice.methods |= methods_of(settings->light_shadows[i], &choice, settings);
  return choice;
}

ShadowMethod plan_light_shadows(const Plan *plan, uint32_t light, uint32_t kind)
{
  ShadowMethod method = plan->light_shadows ? (ShadowMethod)plan->light_shadows[light] : plan->shadows;
  if (method == SHADOWS_AUTO) method = plan->hybrid_kinds >> kind & 1 ? SHADOWS_HYBRID : SHADOWS_RAYS;
  return shadow_method_within(plan->shadow_methods, method);
}

Plan plan_make(const RenderSettings *settings, const SceneFacts *facts)
{
  PrimaryFacts primary = {facts->triangle_count, facts->pixel_count, settings->samples, facts->gpu};
  PrimaryCost cost = primary_cost(&primary);
  EnvironmentLightMethod environment_light = environment_light_choose(settings, facts);
  float max_roughness = max_roughness_choose(settings, facts);
  ShadowChoice shadows = shadows_choose(settings, facts);
  bool reflect =
      settings->reflections > REFLECTIONS_NONE && settings->max_depth > 0 && (facts->has_mirrors || max_roughness > 0);
  bool by_maps = reflect && max_roughness > 0 && reflections_answer_lobes(settings->reflections);
  bool lobes = environment_light == ENVIRONMENT_LIGHT_SAMPLED || (reflect && max_roughness > 0 && !by_maps);
  ReflectionMethod first = reflect ? settings->reflections : REFLECTIONS_NONE;
  ReflectionMethod deep = settings->deep_reflections == REFLECTIONS_LIKE_FIRST ? first : settings->deep_reflections;
  if (!reflect) deep = REFLECTIONS_NONE;
  // Cubes beside which something is listed do not show all.
  if (first == REFLECTIONS_HYBRID && reflections_use_lists(deep)) first = REFLECTIONS_RAYS;
  if (deep == REFLECTIONS_HYBRID && reflections_use_lists(first)) deep = REFLECTIONS_RAYS;
  first = reflections_choose(first, shadows.methods, lobes, environment_light);
  deep = reflections_choose(deep, shadows.methods, lobes, environment_light);
  uint32_t depths = reflect ? settings->max_depth : 0;
  if (deep == REFLECTIONS_NONE && depths > 1) depths = 1;
  CubeOptions cubes = settings->cubes;
  cubes.visibility = settings->primary;
  Plan plan = {
      .lighting = settings->lighting,
      .primary = primary_choose(settings->primary, &cost),
      .primary_cost = cost,
      .shadow_rays = shadows.methods != SHADOW_SET(SHADOWS_NONE),
      .shadows = facts->light_count > 0 ? settings->shadows : SHADOWS_NONE,
      .light_shadows = settings->light_shadows,
      .shadow_methods = shadows.methods,
      .hybrid_kinds = shadows.hybrid_kinds,
      .shadow_options = settings->shadow_options,
      .sequence = facts->sequence,
      .reflected_rays = reflect,
      .reflections = first,
      .deep_reflections = deep,
      .cubes = cubes,
      .lobes = lobes,
      .transmitted_rays = facts->has_blends,
      .environment_light = environment_light,
      .max_roughness = reflect ? max_roughness : 0,
      .rough_by_maps = by_maps,
      .exact_roughness = exact_roughness_of(settings, facts),
      .max_depth = depths,
      .ambient = settings->ambient,
  };
  memcpy(plan.shadow_costs, shadows.costs, sizeof plan.shadow_costs);
  return plan;
}

RenderSettings settings_exact(const RenderSettings *settings)
{
  RenderSettings exact = *settings;
  bool sized = settings->shadow_options.light_radius_m > 0 || settings->shadow_options.light_angle_rad > 0;
  exact.methods = METHODS_EXACT;
  exact.primary = PRIMARY_RAYS;
  exact.shadows = sized ? SHADOWS_AREA : SHADOWS_RAYS;
  exact.allowed_shadows = SHADOW_SET(SHADOWS_RAYS) | (sized ? SHADOW_SET(SHADOWS_AREA) : 0);
  exact.reflections = REFLECTIONS_RAYS;
  exact.deep_reflections = REFLECTIONS_LIKE_FIRST;
  exact.environment_light = ENVIRONMENT_LIGHT_SAMPLED;
  return exact;
}
