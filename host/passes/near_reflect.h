// Reflected rays answered by cube maps and the lists of what is near them: cl/capture/near_trace.cl, near_reflect.cl.
#pragma once

#include "passes/cube_reflect.h"
#include "passes/known_hits.h"
#include "passes/near_trace.h"

// What lists hold, for near_reflect_make.
typedef struct NearSources {
  NearInfo *nears;    // [cube_count]
  const Bvh2 *trees;  // [cube_count], of what is found by rays
  const SnapshotInfo *snapshots;
  uint32_t cube_count, snapshot_count;
  size_t snapshot_texels;
} NearSources;

typedef struct NearReflect {
  Kernel reflect;
  NearTrace trace;
  DeviceBuffer snapshots;     // SnapshotInfo, [snapshot_count]
  DeviceBuffer photos;        // Float4 (shared/near.h), of all snapshots
  DeviceBuffer backs, cells;  // float
  DeviceBuffer counts;        // [NEAR_COUNTS]
  uint32_t cube_count;        // 0: no lists
  uint64_t looked_up;         // rays so far
  uint64_t totals[NEAR_COUNTS];
} NearReflect;

// For waves of up to `capacity` rays. The snapshots' texels are not set.
Status near_reflect_make(NearReflect *out, Device *device, const DeviceScene *scene, const NearSources *sources,
                         uint32_t capacity, Log *log);
void near_reflect_free(NearReflect *near);

// Sets what is known once cubes are drawn.
Status near_reflect_set(NearReflect *near, Device *device, const NearInfo *nears, Log *log);

// Rays that are answered by near_reflect; those that it leaves to be traced; those that have met something of a list.
typedef struct NearStreams {
  const RayStream *rays, *left;
  const KnownHits *known;
  const DeviceBuffer *radiance;
} NearStreams;

// Adds to radiance[slot] what maps show of rays [0, count). `method` says how far things are looked up: CUBE, BOX or
// another, which stands for IMPOSTOR; `invisible` as in the kernel.
Status near_reflect(NearReflect *near, const CubeReflect *cubes, Device *device, const DeviceScene *scene,
                    ReflectionMethod method, float invisible, const NearStreams *streams, uint32_t count, LeftRays *out,
                    Log *log);
