// Reflected rays answered by cube maps and the lists of what is near them: cl/capture/near_trace.cl, near_reflect.cl.
#pragma once

#include "passes/cube_reflect.h"
#include "shared/bvh.h"
#include "shared/near.h"

// What lists hold, for near_reflect_make.
typedef struct NearSources {
  const NearInfo *nears;  // [cube_count]
  const SnapshotInfo *snapshots;
  const Bvh2Node *nodes;
  const BvhTriangle *triangles;
  uint32_t cube_count, snapshot_count;
  size_t node_count, triangle_count, snapshot_texels;
} NearSources;

typedef struct NearReflect {
  Kernel trace, reflect, join;
  DeviceBuffer nears;             // NearInfo, [cube_count]
  DeviceBuffer nodes, triangles;  // of all lists
  DeviceBuffer snapshots;         // SnapshotInfo, [snapshot_count]
  DeviceBuffer photos;            // Float4 (shared/near.h), of all snapshots
  DeviceBuffer backs, cells;      // float
  DeviceBuffer counts;            // [NEAR_COUNTS]
  HitStream hits, listed_hits;
  uint32_t cube_count;  // 0: no lists
  uint64_t looked_up;   // rays so far
  uint64_t totals[NEAR_COUNTS];
} NearReflect;

// For waves of up to `capacity` rays. The snapshots' texels are not set.
Status near_reflect_make(NearReflect *out, Device *device, const DeviceScene *scene, const NearSources *sources,
                         uint32_t capacity, Log *log);
void near_reflect_free(NearReflect *near);

// Sets what is known once cubes are drawn.
Status near_reflect_set(NearReflect *near, Device *device, const NearInfo *nears, Log *log);

// Rays that are answered by near_reflect: [0, left) of `left` are still to be traced, [0, listed) of `listed` have met
// what near_join appends.
typedef struct NearStreams {
  const RayStream *rays, *left, *listed;
  const DeviceBuffer *radiance;
} NearStreams;

// Adds to radiance[slot] what maps show of rays [0, count). `method` says how far things are looked up: CUBE, BOX or
// another, which stands for IMPOSTOR; `invisible` as in the kernel. counts: *left_count and *listed_count.
Status near_reflect(NearReflect *near, const CubeReflect *cubes, Device *device, const DeviceScene *scene,
                    ReflectionMethod method, float invisible, const NearStreams *streams, uint32_t count,
                    uint32_t *left_count, uint32_t *listed_count, Log *log);

// Appends the listed rays and their hits to `rays`, which are of the same capacity, and their hits.
Status near_join(const NearReflect *near, Device *device, const RayStream *listed, uint32_t listed_count,
                 const RayStream *rays, const HitStream *hits, uint32_t count, Log *log);
