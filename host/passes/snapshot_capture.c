#include "passes/snapshot_capture.h"

#include <math.h>
#include <stdlib.h>

#include "device_scene/part_bvh.h"
#include "passes/scene_args.h"
#include "shared/stream.h"

Status snapshot_capture_make(SnapshotCapture *out, Device *device, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  SnapshotCapture capture = {0};
  Program *program = NULL;
  TRY(program_build(&program, device, "capture/snapshot_capture.cl", "", log));
  TRY(program_kernel(&capture.rays, program, "snapshot_rays", log));
  TRY(program_kernel(&capture.depths, program, "snapshot_depths", log));
  TRY(program_kernel(&capture.keep, program, "snapshot_keep", log));
  TRY(program_kernel(&capture.cells, program, "snapshot_cells", log));
  TRY(program_kernel(&capture.change, program, "cube_change", log));
  TRY(buffer_create(&capture.info, device, sizeof(SnapshotInfo), NULL, "snapshot", log));
  TRY(buffer_create(&capture.cube, device, sizeof(CubeInfo), NULL, "snapshot", log));
  TRY(hit_stream_make(&capture.any, device, capacity, log));
  TRY(hit_stream_make(&capture.back, device, capacity, log));
  *out = capture;
  capture = (SnapshotCapture){0};

done:
  snapshot_capture_free(&capture);
  return status;
}

// Frees what is the object's own.
static void trees_free(SnapshotCapture *capture)
{
  DeviceScene *scenes[] = {&capture->seen, &capture->either};
  for (int i = 0; i < 2; i++) {
    buffer_free(&scenes[i]->bvh2_nodes);
    buffer_free(&scenes[i]->bvh2_triangles);
    *scenes[i] = (DeviceScene){0};
  }
}

void snapshot_capture_free(SnapshotCapture *capture)
{
  kernel_free(&capture->rays);
  kernel_free(&capture->depths);
  kernel_free(&capture->keep);
  kernel_free(&capture->cells);
  kernel_free(&capture->change);
  buffer_free(&capture->info);
  buffer_free(&capture->cube);
  hit_stream_free(&capture->any);
  hit_stream_free(&capture->back);
  trees_free(capture);
  *capture = (SnapshotCapture){0};
}

static Status tree_make(DeviceScene *out, Device *device, const DeviceScene *scene, const Bvh2 *bvh, Log *log)
{
  Status status = STATUS_OK;
  DeviceBuffer nodes = {0}, triangles = {0};
  TRY(buffer_create(&nodes, device, bvh->node_count * sizeof *bvh->nodes, bvh->nodes, "snapshot", log));
  TRY(buffer_create(&triangles, device, bvh->triangle_count * sizeof *bvh->triangles, bvh->triangles, "snapshot", log));
  *out = *scene;
  out->bvh2_nodes = nodes;
  out->bvh2_triangles = triangles;
  return STATUS_OK;

done:
  buffer_free(&nodes);
  return status;
}

Status snapshot_capture_aim(SnapshotCapture *capture, Device *device, const DeviceScene *scene,
                            const SnapshotInfo *snapshot, Log *log)
{
  Status status = STATUS_OK;
  Bvh2 bvh = {0};
  trees_free(capture);
  capture->beyond_m = snapshot->beyond_m;
  TRY(buffer_write(device, &capture->info, snapshot, sizeof *snapshot, log));
  TRY(part_bvh_make(&bvh, scene->source, &snapshot->object, 1, log));
  TRY(tree_make(&capture->seen, device, scene, &bvh, log));
  for (uint32_t i = 0; i < bvh.triangle_count; i++) bvh.triangles[i].flags &= ~TRIANGLE_SINGLE_SIDED;
  TRY(tree_make(&capture->either, device, scene, &bvh, log));

done:
  bvh2_free(&bvh);
  return status;
}

static Status rays_make(const SnapshotCapture *capture, Device *device, const Wave *wave, float inward_m,
                        const RayStream *stream, Log *log)
{
  uint32_t rays = wave_rays(wave);
  return device_launch(device, &capture->rays, work_items(device, rays), rays, "generate rays of a snapshot",
                       ARGS(ARG_BUFFER(capture->info), ARG(wave->first_tile), ARG(wave->tile_count), ARG(rays),
                            ARG(inward_m), ARG_BUFFER(stream->rays), ARG(stream->capacity), ARG_BUFFER(stream->slots)),
                       log);
}

Status snapshot_capture_rays(const SnapshotCapture *capture, Device *device, const Wave *wave, const RayStream *stream,
                             Log *log)
{
  return rays_make(capture, device, wave, 0, stream, log);
}

Status snapshot_capture_trace(const SnapshotCapture *capture, const Tracer *tracer, Device *device, const Wave *wave,
                              const RayStream *rays, const HitStream *hits, const RayStream *spare,
                              const NearReflect *near, Log *log)
{
  static const char sentence[] = "trace rays of a snapshot";
  Status status = STATUS_OK;
  const Wave sample = {wave->first_tile, wave->tile_count, 0, 1};
  uint32_t pixels = wave_rays(&sample);
  TRY(trace_closest(tracer, device, &capture->seen, rays, wave_rays(wave), 0, hits, RAYS_COHERENT, sentence, log));
  if (wave->first_sample > 0) return STATUS_OK;
  TRY(trace_closest(tracer, device, &capture->either, rays, pixels, 0, &capture->any, RAYS_COHERENT, sentence, log));
  TRY(rays_make(capture, device, &sample, capture->beyond_m, spare, log));
  TRY(trace_closest(tracer, device, &capture->either, spare, pixels, 0, &capture->back, RAYS_COHERENT, sentence, log));
  TRY(device_launch(device, &capture->depths, work_items(device, pixels), pixels, "keep a snapshot's depths",
                    ARGS(ARG_BUFFER(capture->info), ARG(wave->first_tile), ARG(pixels), ARG(rays->capacity),
                         ARG_BUFFER(hits->hits), ARG_BUFFER(hits->ids), ARG_BUFFER(capture->any.hits),
                         ARG_BUFFER(capture->any.ids), ARG_BUFFER(capture->back.hits), ARG_BUFFER(capture->back.ids),
                         ARG_BUFFER(near->photos), ARG_BUFFER(near->backs)),
                    log));

done:
  return status;
}

Status snapshot_capture_keep(const SnapshotCapture *capture, Device *device, const Wave *wave, float share,
                             const DeviceBuffer *radiance, const NearReflect *near, Log *log)
{
  size_t pixels = (size_t)wave->tile_count * TILE_PIXELS;
  return device_launch(device, &capture->keep, work_items(device, pixels), pixels, "keep a snapshot",
                       ARGS(ARG_BUFFER(capture->info), ARG(wave->first_tile), ARG(wave->tile_count),
                            ARG(wave->sample_count), ARG(share), ARG_BUFFER(*radiance), ARG_BUFFER(near->photos)),
                       log);
}

Status snapshot_capture_cells(const SnapshotCapture *capture, Device *device, uint32_t size, const NearReflect *near,
                              Log *log)
{
  size_t count = (size_t)size * size / (CUBE_CELL * CUBE_CELL);
  return device_launch(device, &capture->cells, work_items(device, count), count, "find what is close in a snapshot",
                       ARGS(ARG_BUFFER(capture->info), ARG_BUFFER(near->photos), ARG_BUFFER(near->cells)), log);
}

Status cube_change_measure(NearInfo *near, const SnapshotCapture *capture, Device *device, const CubeInfo *cube,
                           const CubeReflect *cubes, Log *log)
{
  Status status = STATUS_OK;
  size_t rows = CUBE_FACES * (size_t)cube->size, bytes = 2 * rows * sizeof(float);
  double sum = 0, texel_rad = 0.5 * M_PI / (cube->size - 1.0), pairs = 2 * (double)rows * (cube->size - 1.0);
  float closest = 0;
  DeviceBuffer info = capture->cube, sums = {0};
  float *changes = malloc(bytes);
  if (!changes) return log_no_memory(log, "cube maps");
  TRY(buffer_create(&sums, device, bytes, NULL, "cube maps", log));
  TRY(buffer_write(device, &info, cube, sizeof *cube, log));
  TRY(device_launch(device, &capture->change, rows, rows, "measure how a cube map changes",
                    ARGS(ARG_BUFFER(capture->cube), ARG_BUFFER(cubes->texels), ARG_BUFFER(sums)), log));
  TRY(buffer_read(device, &sums, changes, bytes, log));
  for (size_t i = 0; i < rows; i++) {
    sum += (double)changes[2 * i];
    closest = fmaxf(closest, changes[2 * i + 1]);
  }
  near->change = (float)(sum / pairs / texel_rad);
  near->nearest_m = closest > 0 ? 0.9999f / closest : INFINITY;

done:
  buffer_free(&sums);
  free(changes);
  return status;
}
