// What a picture by shadow maps may get wrong: cl/shade/shadow_doubt.cl, summed over probes.
#pragma once

#include "passes/ray_stream.h"
#include "passes/shadow_maps.h"

// Sums of doubts. A wave's samples are, samples_a_probe after each other, those of one probe, which is wrong where one
// of them is.
typedef struct ShadowDoubt {
  const ShadowMaps *maps;
  const ShadowMaps *finer;  // of the same lights, asked as well: they show casters that `maps` lost; may be NULL
  float least_weight;       // radiance below which a light is not missed
  float scale;              // of radiance for display; INFINITY where that is not known
  bool showing;             // nothing is doubted yet, but what the maps let arrive is added up
  uint32_t samples_a_probe;
  Kernel kernel;
  DeviceBuffer by_slot;      // float [capacity], of one light
  DeviceBuffer shown;        // Float4 [capacity]: of all lights
  float *slots, *wave;       // [capacity]: of one light; that one of all so far is wrong
  uint32_t capacity;         // of a wave
  uint32_t pixels, samples;  // of the wave
  double *lights;            // [light_count], over probes: a light's doubts, at most 1 a probe and bounce
  double sum, sum_squared;   // over probes: all lights' doubts together, at most 1 a probe
} ShadowDoubt;

// `has_disc`: some of the maps are for PCSS. Errors: those of program_build and buffer_create.
Status shadow_doubt_make(ShadowDoubt *out, Device *device, const ShadowMaps *maps, bool has_disc, uint32_t capacity,
                         Log *log);
void shadow_doubt_free(ShadowDoubt *doubt);

// A wave whose slots are `pixels` times `samples`. It is rendered twice: first while `showing`, then for the doubts.
// Errors: STATUS_DEVICE.
Status shadow_doubt_begin_wave(ShadowDoubt *doubt, Device *device, uint32_t pixels, uint32_t samples, Log *log);

// Adds what the maps of `light` may get wrong of rays [0, count) of segment `segment`; nothing for a light without
// maps. Errors: STATUS_DEVICE.
Status shadow_doubt_add(ShadowDoubt *doubt, Device *device, const DeviceScene *scene, uint32_t light,
                        const RayStream *rays, uint32_t segment, uint32_t count, Log *log);

// All rays of the wave are added.
void shadow_doubt_end_wave(ShadowDoubt *doubt);
