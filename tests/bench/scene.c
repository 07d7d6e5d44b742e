#include "bench/scene.h"

#include <stdlib.h>

Status bench_scene_open(BenchScene *bench, const char *path, double aspect, const char *device, uint32_t threads)
{
  Status status = STATUS_OK;
  Log *log = &bench->log;
  GltfOptions options = {.scene = NONE, .max_memory_bytes = 1ull << 34};
  *bench = (BenchScene){0};
  TRY(image_helper_start(&bench->images, 1ull << 28, log));
  TRY(gltf_read(&bench->scene, path, &options, bench->images, log));
  for (uint32_t i = 0; i < bench->scene.material_count; i++) {
    bench->scene.materials[i].double_sided = true;
    bench->scene.materials[i].alpha_mode = ALPHA_OPAQUE;
  }
  TRY(scene_camera_choose(&bench->camera, &bench->scene, NULL, aspect, log));
  TRY(flat_scene_make(&bench->flat, &bench->scene, log));
  TRY(device_open(&bench->device, device, threads, &bench->timeline, log));
  TRY(device_scene_make(&bench->device_scene, bench->device, &bench->scene, &bench->timeline, log));

done:
  return status;
}

void bench_scene_close(BenchScene *bench)
{
  device_scene_free(&bench->device_scene);
  device_close(bench->device);
  flat_scene_free(&bench->flat);
  scene_free(&bench->scene);
  image_helper_stop(bench->images);
  timeline_free(&bench->timeline);
}

static int compare_doubles(const void *a, const void *b)
{
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

double bench_median(double *values, size_t count)
{
  qsort(values, count, sizeof *values, compare_doubles);
  return values[count / 2];
}
