// What is rendered and by which methods. A plan is a pure function of the settings and of facts about the scene: an
// effect that the scene does not need gets no pass. No OpenCL here.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "plan/primary.h"

typedef enum LightingModel { LIGHTING_PBR, LIGHTING_PHONG } LightingModel;
typedef enum ShadowMethod { SHADOWS_NONE, SHADOWS_RAYS } ShadowMethod;
typedef enum ReflectionMethod { REFLECTIONS_NONE, REFLECTIONS_RAYS } ReflectionMethod;

// What the user asks for.
typedef struct RenderSettings {
  uint32_t width, height;
  uint32_t samples;
  LightingModel lighting;
  PrimaryMethod primary;
  ShadowMethod shadows;
  ReflectionMethod reflections;
  uint32_t max_depth;  // reflected bounces
  float ambient;       // phong
} RenderSettings;

// What the scene has, and what the planner must know of picture and device.
typedef struct SceneFacts {
  uint64_t triangle_count;
  uint64_t pixel_count;  // of the part of the picture that is rendered
  bool gpu;
  uint32_t light_count;
  bool has_mirrors, has_blends;
  bool environment_lights;
} SceneFacts;

// What is done.
typedef struct Plan {
  LightingModel lighting;
  PrimaryMethod primary;  // raster or rays
  PrimaryCost primary_cost;
  bool shadow_rays;       // a light is there and shadows are asked for
  bool reflected_rays;    // a mirror is there and reflections are asked for
  bool transmitted_rays;  // a BLEND surface is there
  bool environment_light;
  uint32_t max_depth;  // 0 without reflected rays
  float ambient;
} Plan;

Plan plan_make(const RenderSettings *settings, const SceneFacts *facts);
