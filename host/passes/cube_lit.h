// Which faces of cube maps lights shine on: cl/capture/cube_lit.cl.
#pragma once

#include "device/device.h"
#include "shared/cube.h"
#include "shared/scene.h"

typedef struct CubeLit {
  Kernel kernel;
  DeviceBuffer lights;  // LightInfo, [light_count]
  DeviceBuffer faces;
  uint32_t light_count;  // 0: it is not made
} CubeLit;

Status cube_lit_make(CubeLit *out, Device *device, const LightInfo *lights, uint32_t count, Log *log);
void cube_lit_free(CubeLit *lit);

// Bit f of *faces: does a light shine on something that face f of a cube of `texels` shows, if nothing stands before
// it? The scene has nothing that is BLEND. slack_m is what rounding may do to a place. Waits for the device.
Status cube_lit_find(uint32_t *faces, const CubeLit *lit, Device *device, const CubeInfo *cube,
                     const DeviceBuffer *texels, float slack_m, Log *log);
