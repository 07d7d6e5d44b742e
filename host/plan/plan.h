// What is rendered and by which methods. A plan is a pure function of the settings and of facts about the scene: an
// effect that the scene does not need gets no pass. No OpenCL here.
#pragma once

#include <stdbool.h>
#include <stdint.h>

typedef enum LightingModel { LIGHTING_PBR, LIGHTING_PHONG } LightingModel;
typedef enum ShadowMethod { SHADOWS_NONE, SHADOWS_RAYS } ShadowMethod;
typedef enum ReflectionMethod { REFLECTIONS_NONE, REFLECTIONS_RAYS } ReflectionMethod;

// How the environment lights surfaces, in pbr. Errors below are those of what surfaces send back, relative to
// ENVIRONMENT_LIGHT_SAMPLED.
typedef enum EnvironmentLightMethod {
  ENVIRONMENT_LIGHT_AUTO,     // SAMPLED from SAMPLED_FROM samples a pixel on, else SH
  ENVIRONMENT_LIGHT_NONE,     // not at all; it is still seen, directly and in what reflects
  ENVIRONMENT_LIGHT_AMBIENT,  // its mean radiance from everywhere
  ENVIRONMENT_LIGHT_SH,       // irradiance in nine spherical harmonics, prefiltered highlights; nothing casts a shadow
  ENVIRONMENT_LIGHT_SH_AO,    // the same, weakened by what stands near
  ENVIRONMENT_LIGHT_SAMPLED,  // the integral of BRDF x radiance x visibility, by samples: noise, but no other error
} EnvironmentLightMethod;

// The fewest samples a pixel at which noise is the lesser evil.
enum { SAMPLED_FROM = 16 };
#define MAX_ROUGHNESS_AUTO (-1.0f)

// What the user asks for.
typedef struct RenderSettings {
  uint32_t width, height;
  uint32_t samples;
  LightingModel lighting;
  ShadowMethod shadows;
  ReflectionMethod reflections;
  EnvironmentLightMethod environment_light;
  uint32_t max_depth;  // reflected bounces
  float
      max_roughness;  // surfaces up to it reflect; MAX_ROUGHNESS_AUTO: 1 from SAMPLED_FROM samples on, else 0; pbr alone
  float ambient;      // phong
} RenderSettings;

// What the scene has.
typedef struct SceneFacts {
  uint32_t light_count;
  bool has_mirrors, has_blends;
  float least_roughness;  // of what is no mirror; INFINITY where there is nothing but mirrors
  bool environment_lights;
} SceneFacts;

// What is done.
typedef struct Plan {
  LightingModel lighting;
  bool shadow_rays;       // a light is there and shadows are asked for
  bool reflected_rays;    // something that reflects is there and reflections are asked for
  bool lobes;             // surfaces send samples along their lobes: rough reflections, or sampled environment light
  bool transmitted_rays;  // a BLEND surface is there
  EnvironmentLightMethod environment_light;  // never AUTO
  float max_roughness;                       // 0: mirrors alone reflect
  uint32_t max_depth;                        // 0 without reflected rays
  float ambient;
} Plan;

Plan plan_make(const RenderSettings *settings, const SceneFacts *facts);
