#include "passes/cube_capture.h"

#include <math.h>
#include <stdlib.h>

#include "passes/scene_args.h"
#include "shared/stream.h"

Status cube_capture_make(CubeCapture *out, Device *device, const DeviceScene *scene, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  CubeCapture capture = {0};
  Program *program = NULL;
  TRY(program_build(&program, device, "capture/cube_capture.cl", "", log));
  TRY(program_kernel(&capture.rays, program, "cube_rays", log));
  TRY(program_kernel(&capture.peel, program, "cube_peel", log));
  TRY(program_kernel(&capture.near, program, "cube_near", log));
  TRY(program_kernel(&capture.keep, program, "cube_keep", log));
  TRY(program_kernel(&capture.hull, program, "cube_hull", log));
  TRY(program_kernel(&capture.cells, program, "cube_cells", log));
  TRY(buffer_create(&capture.info, device, sizeof(CubeInfo), NULL, "cube map", log));
  TRY(buffer_create(&capture.left_out, device, scene->object_count * sizeof(uint32_t), NULL, "cube map", log));
  TRY(buffer_create(&capture.closeness, device, capacity * sizeof(float), NULL, "cube map", log));
  TRY(buffer_create(&capture.count, device, sizeof(uint32_t), NULL, "cube map", log));
  TRY(hit_stream_make(&capture.hits, device, capacity, log));
  size_t bytes = ((size_t)scene->object_count + 1) * sizeof *capture.object_starts;
  capture.object_starts = malloc(bytes);
  if (!capture.object_starts) {
    status = log_no_memory(log, "cube map");
    goto done;
  }
  TRY(buffer_read(device, &scene->object_starts, capture.object_starts, bytes, log));
  *out = capture;
  capture = (CubeCapture){0};

done:
  cube_capture_free(&capture);
  return status;
}

void cube_capture_free(CubeCapture *capture)
{
  kernel_free(&capture->rays);
  kernel_free(&capture->peel);
  kernel_free(&capture->near);
  kernel_free(&capture->keep);
  kernel_free(&capture->hull);
  kernel_free(&capture->cells);
  buffer_free(&capture->info);
  buffer_free(&capture->left_out);
  buffer_free(&capture->closeness);
  buffer_free(&capture->count);
  hit_stream_free(&capture->hits);
  camera_rays_free(&capture->views);
  raster_visibility_free(&capture->raster);
  free(capture->object_starts);
  *capture = (CubeCapture){0};
}

void cube_cameras(CameraInfo out[CUBE_FACES], uint32_t size, Vec3 center_world, float near_m)
{
  const float edge = 1 - 1e-6f, scale = 2 * edge / (float)(size - 1);
  for (int face = 0; face < CUBE_FACES; face++) {
    const float sign = face % 2 ? -1 : 1;
    float axes[3][3] = {{0}};
    for (int i = 0; i < 3; i++) axes[i][(face / 2 + i) % 3] = 1;
    out[face] = (CameraInfo){.position = {(float)center_world.x, (float)center_world.y, (float)center_world.z},
                             .forward = {sign * axes[0][0], sign * axes[0][1], sign * axes[0][2]},
                             .right = {axes[1][0], axes[1][1], axes[1][2]},
                             .down = {axes[2][0], axes[2][1], axes[2][2]},
                             .scale = scale,
                             .center_x = edge + 0.5f * scale,
                             .center_y = edge + 0.5f * scale,
                             .near_m = near_m,
                             .far_m = INFINITY,
                             .width = size,
                             .height = size,
                             .tiles_per_row = size / TILE_SIZE};
  }
}

static Status faces_aim(CubeCapture *capture, Device *device, const CubeInfo *cube, float near_m, Log *log)
{
  CameraInfo views[CUBE_FACES];
  float offsets[CUBE_SAMPLES_MOST][2];
  for (int i = 0; i < CUBE_SAMPLES_MOST; i++) offsets[i][0] = offsets[i][1] = 0.5f;
  const Float3 at = cube->center;
  cube_cameras(views, cube->size, vec3((double)at.x, (double)at.y, (double)at.z), near_m);
  camera_rays_free(&capture->views);
  return camera_rays_make_views(&capture->views, device, views, CUBE_FACES, (const float(*)[2])offsets,
                                CUBE_SAMPLES_MOST, log);
}

Status cube_capture_aim(CubeCapture *capture, Device *device, const DeviceScene *scene, const CubeInfo *cube,
                        float near_m, const uint32_t *left_out, Log *log)
{
  Status status = STATUS_OK;
  TRY(buffer_write(device, &capture->info, cube, sizeof *cube, log));
  TRY(buffer_write(device, &capture->left_out, left_out, scene->object_count * sizeof *left_out, log));
  TRY(faces_aim(capture, device, cube, near_m, log));
  capture->by_raster = false;

done:
  return status;
}

// Triangles of objects that are left out, as ranges. Returns how many, or more than there is room for.
static uint32_t ranges_find(uint32_t ranges[CUBE_RANGES_MOST][2], const uint32_t *object_starts,
                            const uint32_t *left_out, uint32_t object_count)
{
  uint32_t count = 0;
  for (uint32_t i = 0; i < object_count; i++) {
    if (!left_out[i]) continue;
    bool goes_on = count && ranges[count - 1][1] == object_starts[i];
    if (!goes_on && count == CUBE_RANGES_MOST) return CUBE_RANGES_MOST + 1;
    if (!goes_on) ranges[count++][0] = object_starts[i];
    ranges[count - 1][1] = object_starts[i + 1];
  }
  return count;
}

Status cube_capture_raster(CubeCapture *capture, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                           const uint32_t *left_out, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  uint32_t ranges[CUBE_RANGES_MOST][2];
  uint32_t count = ranges_find(ranges, capture->object_starts, left_out, scene->object_count);
  if (count > CUBE_RANGES_MOST) return STATUS_OK;
  if (!capture->raster.views.memory && !capture->raster.hidden.memory)
    TRY(raster_visibility_make(&capture->raster, device, scene, &(RasterOptions){0}, log));
  TRY(raster_visibility_hide(&capture->raster, device, (const uint32_t(*)[2])ranges, count, log));
  TRY(raster_visibility_aim(&capture->raster, device, triangles, &capture->views, CUBE_SAMPLES_MOST, capacity, log));
  capture->by_raster = true;

done:
  return status;
}

Status cube_capture_rays(const CubeCapture *capture, Device *device, const Wave *wave, float inward_m,
                         const RayStream *stream, Log *log)
{
  uint32_t rays = wave_rays(wave);
  if (inward_m == 0) return camera_rays_generate(&capture->views, device, wave, stream, log);
  return device_launch(device, &capture->rays, work_items(device, rays), rays, "generate rays of a cube map",
                       ARGS(ARG_BUFFER(capture->info), ARG(wave->first_tile), ARG(wave->tile_count), ARG(rays),
                            ARG(inward_m), ARG_BUFFER(stream->rays), ARG(stream->capacity), ARG_BUFFER(stream->slots)),
                       log);
}

// Sends on what goes past objects that are left out; *count becomes its number.
static Status rays_peel(const CubeCapture *capture, Device *device, const DeviceScene *scene, bool inward,
                        const RayStream *rays, uint32_t *count, const HitStream *hits, const HitStream *to,
                        const RayStream *onward, Log *log)
{
  Status status = STATUS_OK;
  DeviceBuffer counter = capture->count;
  uint32_t back = inward;
  TRY(buffer_zero(device, &counter, log));
  TRY(device_launch(device, &capture->peel, work_items(device, *count), *count, "pass the reflector",
                    ARGS(ARG_BUFFER(capture->info), ARG(back), ARG_BUFFER(rays->rays), ARG_BUFFER(rays->slots),
                         ARG(rays->capacity), ARG(*count), ARG_BUFFER(hits->hits), ARG_BUFFER(hits->ids),
                         ARG_BUFFER(scene->object_starts), ARG(scene->object_count), ARG_BUFFER(capture->left_out),
                         ARG_BUFFER(to->hits), ARG_BUFFER(to->ids), ARG_BUFFER(capture->closeness),
                         ARG_BUFFER(onward->rays), ARG_BUFFER(onward->slots), ARG_BUFFER(capture->count)),
                    log));
  TRY(buffer_read(device, &capture->count, count, sizeof *count, log));

done:
  return status;
}

Status cube_capture_trace(const CubeCapture *capture, const Tracer *tracer, Device *device, const DeviceScene *scene,
                          bool inward, const RayStream *rays, uint32_t count, const HitStream *hits,
                          const RayStream spare[2], Log *log)
{
  Status status = STATUS_OK;
  const float near_m = inward ? 0 : capture->views.info.near_m;
  TRY(trace_closest(tracer, device, scene, rays, count, near_m, hits, RAYS_COHERENT, "trace rays of a cube map", log));
  TRY(rays_peel(capture, device, scene, inward, rays, &count, hits, hits, &spare[0], log));
  for (int layer = 0; layer < CUBE_LAYERS_MOST && count > 0; layer++) {
    const RayStream *from = &spare[layer % 2], *onward = &spare[1 - layer % 2];
    TRY(trace_closest(tracer, device, scene, from, count, 0, &capture->hits, RAYS_COHERENT, "trace rays of a cube map",
                      log));
    TRY(rays_peel(capture, device, scene, inward, from, &count, &capture->hits, hits, onward, log));
  }

done:
  return status;
}

Status cube_capture_see(CubeCapture *capture, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                        const Wave *wave, const HitStream *hits, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  uint32_t rays = wave_rays(wave);
  TRY(raster_visibility(&capture->raster, device, scene, triangles, &capture->views, wave, hits, capacity, log));
  TRY(device_launch(
      device, &capture->near, work_items(device, rays), rays, "keep how close a cube map's texels are",
      ARGS(ARG_BUFFER(hits->hits), ARG_BUFFER(hits->ids), ARG(capacity), ARG(rays), ARG_BUFFER(capture->closeness)),
      log));

done:
  return status;
}

Status cube_capture_keep(const CubeCapture *capture, Device *device, const Wave *wave, float share,
                         const DeviceBuffer *radiance, const DeviceBuffer *texels, Log *log)
{
  size_t pixels = (size_t)wave->tile_count * TILE_PIXELS;
  return device_launch(
      device, &capture->keep, work_items(device, pixels), pixels, "keep a cube map",
      ARGS(ARG_BUFFER(capture->info), ARG(wave->first_tile), ARG(wave->tile_count), ARG(wave->sample_count), ARG(share),
           ARG_BUFFER(*radiance), ARG_BUFFER(capture->closeness), ARG_BUFFER(*texels)),
      log);
}

Status cube_capture_keep_hull(const CubeCapture *capture, Device *device, const Wave *wave, const DeviceBuffer *hull,
                              Log *log)
{
  uint32_t pixels = wave->tile_count * TILE_PIXELS;
  return device_launch(device, &capture->hull, work_items(device, pixels), pixels, "keep a reflector's hull",
                       ARGS(ARG_BUFFER(capture->info), ARG(wave->first_tile), ARG(pixels),
                            ARG_BUFFER(capture->closeness), ARG_BUFFER(*hull)),
                       log);
}

Status cube_capture_cells(const CubeCapture *capture, Device *device, uint32_t size, const DeviceBuffer *texels,
                          const DeviceBuffer *cells, Log *log)
{
  size_t count = CUBE_TEXELS((size_t)size) / (CUBE_CELL * CUBE_CELL);
  return device_launch(device, &capture->cells, work_items(device, count), count, "find what is close in a cube map",
                       ARGS(ARG_BUFFER(capture->info), ARG_BUFFER(*texels), ARG_BUFFER(*cells)), log);
}
