// The raster frame of one device by its own clock: what each stage takes between the first and the last event of it,
// and what its kernels take alone. A benchmark, not a test.
//
// Usage: bench_frame [-v] DEVICE SCENE.glb... ; stages: bench/raster_stages.h; the last line of a scene is the frame
// that a game would draw: the depth map of 2048, the cube of 256 and the shaded camera. -v: times by kernel.

#include <stdio.h>
#include <string.h>

#include "bench/raster_stages.h"

enum { ROUNDS = 9 };

// Milliseconds that kernels took since span `first`.
static double spans_ms(const Timeline *timeline, size_t first)
{
  double sum_ms = 0;
  for (size_t i = first; i < timeline->count; i++)
    if (timeline->spans[i].on_device) sum_ms += timeline->spans[i].end_ms - timeline->spans[i].begin_ms;
  return sum_ms;
}

static Status stage_time(RasterStages *stages, Stage stage, bool verbose)
{
  Status status = STATUS_OK;
  double ms[ROUNDS];
  const Timeline *timeline = &stages->base.timeline;
  TRY(raster_stage_run(stages, stage));
  size_t all = timeline->count;
  for (int round = 0; round < ROUNDS; round++) {
    size_t first = timeline->count;
    TRY(raster_stage_run(stages, stage));
    ms[round] = spans_ms(timeline, first);
  }
  printf("  %-18s %8.3f ms\n", stage_names[stage], bench_median(ms, ROUNDS));
  if (verbose) raster_kernels_print(timeline, all, ROUNDS);

done:
  return status;
}

static Status scene_time(const char *device, const char *path, bool verbose)
{
  Status status = STATUS_OK;
  RasterStages stages;
  TRY(raster_stages_open(&stages, path, device, 0));
  printf("%s: %u triangles; %s\n", path, stages.triangles.triangle_count, device_info(stages.base.device)->name);
  for (Stage stage = 0; stage < STAGES; stage++) TRY(stage_time(&stages, stage, verbose));

done:
  if (status) fprintf(stderr, "bench_frame: %s\n", stages.base.log.error);
  raster_stages_close(&stages);
  return status;
}

int main(int argc, char **argv)
{
  Status worst = STATUS_OK;
  bool verbose = argc > 1 && !strcmp(argv[1], "-v");
  if (argc < 3 + verbose) {
    fprintf(stderr, "usage: bench_frame [-v] DEVICE SCENE.glb...\n");
    return status_exit_code(STATUS_USAGE);
  }
  for (int i = 2 + verbose; i < argc; i++) {
    Status status = scene_time(argv[1 + verbose], argv[i], verbose);
    if (status) worst = status;
  }
  return status_exit_code(worst);
}
