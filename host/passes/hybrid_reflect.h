// Hybrid reflections: what lists about a cube map's centre know of what reflected rays meet, and where its texels are
// right: cl/capture/hybrid_reflect.cl.
#pragma once

#include "passes/cube_reflect.h"
#include "passes/known_hits.h"
#include "passes/near_trace.h"
#include "passes/sure_maps.h"

typedef struct HybridReflect {
  Kernel kernel;
  NearTrace own;               // by cube: the reflector itself, unless it is convex
  SureMaps lists;              // by cube, in place of lights: of what stands about it
  DeviceBuffer doubts, names;  // float2 and uint, as the cubes' texels (shared/cube.h)
  DeviceBuffer counts;         // of rays that are left and that are named
  float scale, allowed;        // of radiance for display, and how far off that may be
  uint64_t shaded;             // rays so far: their hits were known, and shaded
} HybridReflect;

// Bytes that a cube takes besides its texels and its reflector's tree.
uint64_t hybrid_reflect_bytes(uint32_t size_px);

// Makes room for [cube_count] cubes and waves of up to `capacity` rays, and draws the lists in maps of the cubes'
// sizes. convex[cube]: the reflector cannot meet itself. On failure *out is to be freed too. Errors: those of
// part_bvh_make, program_build and buffer_create.
Status hybrid_reflect_make(HybridReflect *out, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                           const CameraInfo *camera, const CubeInfo *cubes, const bool *convex, uint32_t cube_count,
                           uint32_t capacity, Log *log);
void hybrid_reflect_free(HybridReflect *hybrid);

// As cube_reflect; rays whose hits are known go to `known`. `maps` counts all of them.
Status hybrid_reflect(HybridReflect *hybrid, CubeReflect *maps, Device *device, const DeviceScene *scene,
                      const RayStream *rays, uint32_t count, const DeviceBuffer *radiance, const RayStream *left,
                      const KnownHits *known, LeftRays *out, Log *log);
