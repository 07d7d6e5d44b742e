// What cube maps may show wrong: cl/capture/cube_doubt.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/camera_rays.h"
#include "passes/ray_stream.h"
#include "shared/cube.h"

typedef struct CubeDoubt {
  Kernel turn, change, flag, keep, doubt;
  DeviceBuffer changes;     // float by slot of a wave
  DeviceBuffer seen_aside;  // Float4 by slot: radiance to another eye
  DeviceBuffer kept;        // float by texel of one cube: changes
} CubeDoubt;

// For waves of up to `capacity` rays and cubes of up to size_px.
Status cube_doubt_make(CubeDoubt *out, Device *device, uint32_t capacity, uint32_t size_px, Log *log);
void cube_doubt_free(CubeDoubt *doubt);

// The wave's hits as seen from aside_m metres beside the centre of the cube in `info`, at `turn_rad` about each ray:
// directions of `turned`, whose other fields are left alone.
Status cube_doubt_turn(const CubeDoubt *doubt, Device *device, const DeviceBuffer *info, float aside_m, double turn_rad,
                       const RayStream *rays, uint32_t count, const HitStream *hits, const RayStream *turned, Log *log);

// Compares the wave's radiance with doubt->seen_aside.
Status cube_doubt_change(const CubeDoubt *doubt, Device *device, uint32_t count, const DeviceBuffer *radiance,
                         Log *log);

// The slots of rays [0, count) may show anything.
Status cube_doubt_flag(const CubeDoubt *doubt, Device *device, const RayStream *spawned, uint32_t count, Log *log);

// Keeps the changes of a wave of one sample, and what it hit as the names of the cube's texels.
Status cube_doubt_keep(const CubeDoubt *doubt, Device *device, const DeviceBuffer *info, const Wave *wave,
                       const HitStream *hits, const DeviceBuffer *names, Log *log);

// Fills the doubts of the cube's texels once all changes are kept.
Status cube_doubt_fill(const CubeDoubt *doubt, Device *device, const DeviceBuffer *info, uint32_t size_px,
                       const DeviceBuffer *texels, const DeviceBuffer *doubts, Log *log);
