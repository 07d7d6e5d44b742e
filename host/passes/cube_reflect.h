// Reflected rays answered by maps: cl/capture/cube_reflect.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/ray_stream.h"
#include "plan/plan.h"
#include "shared/cube.h"

typedef struct CubeReflect {
  Kernel kernel;
  DeviceBuffer cubes;               // CubeInfo, [cube_count]
  DeviceBuffer cube_of_object;      // uint, [object_count]; CUBE_NONE
  DeviceBuffer deep_of_object;      // the same of mirrors in what mirrors show
  DeviceBuffer texels;              // Float4 (shared/cube.h), of all cubes
  DeviceBuffer hull, cells;         // float, the same; empty where no method reads them
  DeviceBuffer levels;              // Float4 (shared/cube.h), of those that rough surfaces ask
  DeviceBuffer environment_levels;  // the shader's own (shared/scene.h); set by the caller of cube_reflect_make
  DeviceBuffer count;               // of rays that are left
  uint32_t cube_count;
  uint64_t looked_up, left;  // rays so far: asked, and left to be traced
} CubeReflect;

// Cubes, and by object which is whose: where the camera sees it, and where it does in a mirror.
typedef struct CubeTable {
  const CubeInfo *cubes;
  const uint32_t *of_object, *deep_of_object;  // [object_count]
  uint32_t count;
  size_t level_texels;  // of all of them
} CubeTable;

// With `marched` there are hull and cells. The texels are zero.
Status cube_reflect_make(CubeReflect *out, Device *device, const DeviceScene *scene, const CubeTable *table,
                         bool marched, Log *log);
void cube_reflect_free(CubeReflect *reflect);

// Whose cubes mirrors' rays ask, and what becomes of those of which these cannot tell.
typedef enum CubeAsk {
  ASK_FIRST,   // what the camera sees; they are left
  ASK_DEEP,    // what it sees in mirrors; they are left
  ASK_CLOSED,  // the same; they see the cube as if infinitely far away, without one the environment
} CubeAsk;

// Adds to radiance[slot] what the method's map shows of rays [0, count) and copies the rays that it leaves to `left`;
// *left_count says how many. The method is one of those that use maps, but for hybrid (passes/hybrid_reflect.h); of
// those with lists it is the impostor for rough surfaces, and all other rays are left as they are.
Status cube_reflect(CubeReflect *reflect, Device *device, const DeviceScene *scene, ReflectionMethod method,
                    CubeAsk ask, const RayStream *rays, uint32_t count, const DeviceBuffer *radiance,
                    const RayStream *left, uint32_t *left_count, Log *log);
