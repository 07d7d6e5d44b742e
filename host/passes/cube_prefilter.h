// Prefiltered levels of cube maps: cl/capture/cube_prefilter.cl.
#pragma once

#include "device/device.h"
#include "shared/cube.h"

typedef struct CubePrefilter {
  Kernel halve, level;
  DeviceBuffer samples;  // PrefilterSample, level by level
  DeviceBuffer images;   // Float4, of one cube
} CubePrefilter;

enum { CUBE_SMALLEST_IMAGE_PX = 8 };

// Samples of a texel of a level: many where texels are few.
uint32_t cube_level_samples(uint32_t level);

// Those of a level, [cube_level_samples(level)]; their weights add up to 1.
void cube_level_samples_fill(PrefilterSample *out, uint32_t level);

// For cubes of up to greatest_px texels a side.
Status cube_prefilter_make(CubePrefilter *out, Device *device, uint32_t greatest_px, Log *log);
void cube_prefilter_free(CubePrefilter *prefilter);

// Fills the levels of a cube once all its texels are there; both are those of all cubes. 7 million samples for one of
// 128 texels a side and more, 2 million for one of 32, some 6 ns each on a core.
Status cube_prefilter(const CubePrefilter *prefilter, Device *device, const CubeInfo *cube, const DeviceBuffer *texels,
                      const DeviceBuffer *levels, Log *log);
