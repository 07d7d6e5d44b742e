// What is rendered and by which methods. A plan is a pure function of the settings and of facts about the scene: an
// effect that the scene does not need gets no pass. No OpenCL here.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "plan/primary.h"
#include "plan/shadow_cost.h"
#include "plan/shadow_method.h"

typedef enum LightingModel { LIGHTING_PBR, LIGHTING_PHONG } LightingModel;

// Kinds of lights; maps differ between them, lights of a kind are alike to the plan.
enum { SHADOW_LIGHT_KINDS = 3 };  // LIGHT_KIND_* of shared/scene.h

// Details of them; a light's radius is there for PCSS and AREA alone.
typedef struct ShadowOptions {
  uint32_t map_size_px;    // texels a side; 0: by magnification (passes/shadow_fit.h)
  uint32_t kernel_px;      // PCF: texels a side, odd
  float light_radius_m;    // of point and spot lights
  double light_angle_rad;  // of directional ones: half of what they subtend
  uint64_t max_bytes;      // that maps of all lights may take; 0: a quarter of the device's memory, at most 2 GB
} ShadowOptions;

// What answers the rays that mirrors reflect; cl/capture/*_reflect.cl have the errors of each. What a method says
// itself that it cannot tell is traced, as are samples of rough surfaces' lobes.
typedef enum ReflectionMethod {
  REFLECTIONS_LIKE_FIRST,   // of deeper bounces: the method of the first
  REFLECTIONS_NONE,         // mirrors stay dark
  REFLECTIONS_ENVIRONMENT,  // the environment, as if the scene did not stand before it
  REFLECTIONS_CUBE,         // a cube map about each visible reflector, as if infinitely far away
  REFLECTIONS_BOX,          // the same as if on the walls of the scene's box
  REFLECTIONS_IMPOSTOR,     // the same at the distances that the cube map keeps
  // The same for what is far; what is near the reflector is left out of the cube map and kept in a list
  // (plan/near_list.h): photographed from the cube's centre, object by object, and found in these pictures;
  REFLECTIONS_SNAPSHOT,
  REFLECTIONS_PLANAR,      // flat mirrors: the scene drawn once more from behind the mirror (render/planar.h)
  REFLECTIONS_CANDIDATES,  // as SNAPSHOT, but what is listed is traced, it and the reflector alone;
  REFLECTIONS_MIXED,       // or photographed if it has many triangles, and traced if it has few: the 2007 system's
  REFLECTIONS_HYBRID,      // what lists and the cube map surely know, rays for the rest: the picture of rays
  REFLECTIONS_RAYS,
} ReflectionMethod;

static inline bool reflections_use_cubes(ReflectionMethod method)
{
  return method >= REFLECTIONS_CUBE && method <= REFLECTIONS_HYBRID && method != REFLECTIONS_PLANAR;
}

// Are there lists of what is near the cubes' centres?
static inline bool reflections_use_lists(ReflectionMethod method)
{
  return method == REFLECTIONS_SNAPSHOT || method == REFLECTIONS_CANDIDATES || method == REFLECTIONS_MIXED;
}

// Are there maps that answer reflected rays?
static inline bool reflections_use_maps(ReflectionMethod method)
{
  return method == REFLECTIONS_ENVIRONMENT || reflections_use_cubes(method);
}

// Do its maps show what rough surfaces reflect, without samples (cl/capture/cube_prefilter.cl)? Hybrid reflections are
// the picture of rays; flat mirrors have no cube.
static inline bool reflections_answer_lobes(ReflectionMethod method)
{
  return reflections_use_cubes(method) && method != REFLECTIONS_HYBRID;
}

// "none", "environment", ...
const char *reflections_name(ReflectionMethod method);

// Details of cube maps.
typedef struct CubeOptions {
  uint32_t size_px;    // texels a side of a face, a multiple of 8; 0: by what the reflector shows on screen
  uint64_t max_bytes;  // that all of them may take; 0: a quarter of the device's memory, at most 512 MB
  // What is so near a cube's centre is listed (plan/near_list.h); 0: by plan/cube_error.h.
  float near_radius_m;
  PrimaryMethod visibility;  // set by plan_make: how cubes see; AUTO: for each by cost
  uint32_t complex_from;     // triangles from which MIXED photographs an object; 0: COMPLEX_FROM_TRIANGLES
} CubeOptions;

// Who chooses a method that is not named: the plan, or it is always the most accurate one.
typedef enum MethodsChoice { METHODS_AUTO, METHODS_EXACT } MethodsChoice;

// How the environment lights surfaces, in pbr. Costs are a hit's on one core, rays included, on a plane with a ball.
// Errors are the mean absolute error against ENVIRONMENT_LIGHT_SAMPLED over the object's mean radiance, for a bottle, a
// radio and a lantern (WaterBottle, BoomBox and Lantern of the glTF sample assets) in a field under a bare sun, in a
// chapel and in a studio.
typedef enum EnvironmentLightMethod {
  ENVIRONMENT_LIGHT_AUTO,     // SAMPLED from SAMPLED_FROM samples a pixel on, else SH
  ENVIRONMENT_LIGHT_NONE,     // not at all; it is still seen, directly and in what reflects
  ENVIRONMENT_LIGHT_AMBIENT,  // its mean radiance from everywhere. 50 ns; 0.25 to 1.3
  // Irradiance in nine spherical harmonics, highlights from a prefiltered image: no shadows, no occlusion, a sun is
  // smeared over a hemisphere of diffuse light. 80 ns; 0.06 to 0.16.
  ENVIRONMENT_LIGHT_SH,
  // The same x the share of four rays by the cosine, a tenth of the scene long, that nothing stops: contacts darken, a
  // sun still casts no shadow. No quicker than SAMPLED, but a sample has less noise. 400 ns; 0.05 to 0.14.
  ENVIRONMENT_LIGHT_SH_AO,
  // The integral of BRDF x radiance x visibility by importance sampling: no error but noise, which falls at least as
  // the root of the samples, slower where a mirror-like surface throws a sun's light on a rough one. 400 ns.
  ENVIRONMENT_LIGHT_SAMPLED,
} EnvironmentLightMethod;

// The fewest samples a pixel at which noise is the lesser evil.
enum { SAMPLED_FROM = 16 };
#define MAX_ROUGHNESS_AUTO (-1.0f)

// What the user asks for.
typedef struct RenderSettings {
  uint32_t width, height;
  uint32_t samples;
  LightingModel lighting;
  PrimaryMethod primary;
  ShadowMethod shadows;
  const uint8_t *light_shadows;  // [light_count] of ShadowMethod, the caller's, for as long as plans; NULL: `shadows`
  uint32_t allowed_shadows;      // set of methods: a light gets no others (shadow_method_within); 0: all
  ShadowOptions shadow_options;
  ReflectionMethod reflections;       // REFLECTIONS_LIKE_FIRST: none
  ReflectionMethod deep_reflections;  // of bounces after the first
  CubeOptions cubes;
  MethodsChoice methods;
  EnvironmentLightMethod environment_light;
  uint32_t max_depth;  // reflected bounces
  // Surfaces up to it reflect, rougher ones see lights and the environment alone; pbr. MAX_ROUGHNESS_AUTO: 1 where the
  // environment's light is sampled or from SAMPLED_FROM samples on, else 0; 1 where cube maps answer for them, 0 where
  // the environment or flat mirrors' maps answer reflected rays.
  float max_roughness;
  float ambient;  // phong
} RenderSettings;

// What is known of a sequence before its first frame. A single picture's are zero.
typedef struct SequenceFacts {
  uint32_t frames;
  double kept[SHADOW_LIGHT_KINDS];  // share of views of such lights' maps that stay from frame to frame, in the mean
} SequenceFacts;

// What the scene has, and what the planner must know of picture and device.
typedef struct SceneFacts {
  uint64_t triangle_count;
  uint64_t pixel_count;  // of the part of the picture that is rendered
  bool gpu;
  uint32_t light_count;
  uint32_t lights_by_kind[SHADOW_LIGHT_KINDS];  // for SHADOWS_AUTO
  bool has_mirrors, has_blends;
  float least_roughness;  // of what is no mirror; INFINITY where there is nothing but mirrors
  bool environment_lights;
  SequenceFacts sequence;  // of all that is to have the same plan, whatever part of it is rendered
} SceneFacts;

// What is done.
typedef struct Plan {
  LightingModel lighting;
  PrimaryMethod primary;  // raster or rays
  PrimaryCost primary_cost;
  bool shadow_rays;              // a light is there and shadows are asked for
  ShadowMethod shadows;          // as asked for, but NONE without lights: of lights that have none of their own
  const uint8_t *light_shadows;  // as in the settings
  uint32_t shadow_methods;       // set of those that lights have; one taken away is replaced (shadow_method_within)
  ShadowOptions shadow_options;
  uint32_t hybrid_kinds;                           // bit k: for lights of kind k AUTO means HYBRID; for others RAYS
  ShadowCost shadow_costs[SHADOW_LIGHT_KINDS];     // of one light of the kind
  SequenceFacts sequence;                          // by which they are
  bool reflected_rays;                             // something that reflects is there and reflections are asked for
  ReflectionMethod reflections, deep_reflections;  // both NONE without reflected rays; none is ..._LIKE_FIRST
  CubeOptions cubes;
  bool lobes;             // surfaces send samples along their lobes: rough reflections, or sampled environment light
  bool receivers;         // shadow rays tell what triangle they start on
  bool transmitted_rays;  // a BLEND surface is there
  EnvironmentLightMethod environment_light;  // never AUTO
  float max_roughness;                       // 0: mirrors alone reflect
  bool rough_by_maps;                        // prefiltered cube maps show what rough surfaces reflect, not samples
  float exact_roughness;                     // up to which they would reflect in the most accurate picture
  bool lobes_alone;    // samples of lobes are not weighed against samples of the environment's image
  uint32_t max_depth;  // 0 without reflected rays
  float ambient;
} Plan;

// Do rough surfaces reflect by samples of their lobes?
static inline bool plan_samples_lobes(const Plan *plan) { return plan->max_roughness > 0 && !plan->rough_by_maps; }

// The method of a light of the scene: never AUTO. `kind` is LIGHT_KIND_* of shared/scene.h.
ShadowMethod plan_light_shadows(const Plan *plan, uint32_t light, uint32_t kind);

// Has any light a method of the set?
static inline bool plan_uses_shadows(const Plan *plan, uint32_t set) { return (plan->shadow_methods & set) != 0; }

static inline bool plan_uses_shadow_maps(const Plan *plan)
{
  return plan_uses_shadows(plan, SHADOW_SET_LOOKED_UP | SHADOW_SET(SHADOWS_HYBRID));
}

// Does about every hit send rays, to lights or to the environment?
static inline bool plan_sends_rays(const Plan *plan)
{
  return plan_uses_shadows(plan, SHADOW_SET_TRACED) || plan->environment_light == ENVIRONMENT_LIGHT_SAMPLED ||
         plan->environment_light == ENVIRONMENT_LIGHT_SH_AO || plan_samples_lobes(plan);
}

static inline bool plan_uses_reflections(const Plan *plan, ReflectionMethod method)
{
  return plan->reflections == method || plan->deep_reflections == method;
}

// Does a bounce ask cube maps?
static inline bool plan_uses_cubes(const Plan *plan)
{
  return reflections_use_cubes(plan->reflections) || reflections_use_cubes(plan->deep_reflections);
}

// Is what is near reflectors listed? It is then at every bounce that asks cube maps, for it is not in these.
static inline bool plan_uses_lists(const Plan *plan)
{
  return reflections_use_lists(plan->reflections) || reflections_use_lists(plan->deep_reflections);
}

// Have reflectors that others show cubes for it? Lists go with the cubes of what the camera sees alone, and hybrid
// reflections are the picture of rays.
static inline bool plan_uses_deep_cubes(const Plan *plan)
{
  const ReflectionMethod deep = plan->deep_reflections;
  return deep >= REFLECTIONS_CUBE && deep <= REFLECTIONS_IMPOSTOR && plan->max_depth > 1 && !plan_uses_lists(plan);
}

// Have reflectors that the camera sees?
static inline bool plan_uses_first_cubes(const Plan *plan)
{
  return reflections_use_cubes(plan->reflections) || (plan_uses_cubes(plan) && !plan_uses_deep_cubes(plan));
}

// Are there reflected rays of which maps know what they hit?
static inline bool plan_knows_hits(const Plan *plan)
{
  return plan_uses_reflections(plan, REFLECTIONS_HYBRID) || plan->reflections == REFLECTIONS_PLANAR ||
         plan_uses_lists(plan);
}

// What answers rays that have been reflected `depth` times, 1 being the first.
static inline ReflectionMethod plan_reflections(const Plan *plan, uint32_t depth)
{
  return depth > 1 ? plan->deep_reflections : plan->reflections;
}

Plan plan_make(const RenderSettings *settings, const SceneFacts *facts);

// The reference that these settings approximate: rays, sampled lobes and environment, lights of the size that the
// shadow options give them; where lights have methods of their own, those of PCSS and AREA alone. Scene, samples and
// bounces are as they were.
RenderSettings settings_exact(const RenderSettings *settings);
