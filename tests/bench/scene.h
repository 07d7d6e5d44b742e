// What both benchmarks begin with: a scene on a device, and its triangles on the host.
#pragma once

#include "device_scene/device_scene.h"
#include "scene/gltf.h"
#include "scene/scene_defaults.h"

typedef struct BenchScene {
  Log log;
  Timeline timeline;
  ImageHelper *images;
  Scene scene;
  Camera camera;  // the file's first, or one fitted
  FlatScene flat;
  Device *device;
  DeviceScene device_scene;
} BenchScene;

// Reads a glTF file and makes every triangle opaque and double-sided, which is how the others see it. The device is
// that of device_open. Errors: those of gltf_read, device_open, device_scene_make; bench_scene_close frees either
// way.
Status bench_scene_open(BenchScene *out, const char *path, double aspect, const char *device, uint32_t threads);
void bench_scene_close(BenchScene *bench);

// Sorts the values.
double bench_median(double *values, size_t count);
