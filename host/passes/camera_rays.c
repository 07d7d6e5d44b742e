#include "passes/camera_rays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/scene_args.h"
#include "plan/samples.h"
#include "shared/stream.h"

static Float3 axis_of(const Mat4 *m, int column, double sign)
{
  return (Float3){(float)(sign * m->m[4 * column]), (float)(sign * m->m[4 * column + 1]),
                  (float)(sign * m->m[4 * column + 2])};
}

CameraInfo camera_info(const Camera *camera, const PictureArea *area)
{
  const Mat4 *world_from_camera = &camera->world_from_camera;
  bool orthographic = camera->kind == CAMERA_ORTHOGRAPHIC;
  double half_height = orthographic ? camera->ymag_m : tan(0.5 * camera->yfov_rad);
  double scale = 2 * half_height / area->whole_height;
  return (CameraInfo){
      .position = axis_of(world_from_camera, 3, 1),
      .right = axis_of(world_from_camera, 0, 1),
      .down = axis_of(world_from_camera, 1, -1),
      .forward = axis_of(world_from_camera, 2, -1),
      .scale = (float)scale,
      .center_x = (float)(0.5 * scale * area->whole_width),
      .center_y = (float)half_height,
      .near_m = (float)camera->znear_m,
      .far_m = (float)camera->zfar_m,
      .width = area->width,
      .height = area->height,
      .crop_x = area->crop_x,
      .crop_y = area->crop_y,
      .tiles_per_row = (area->width + TILE_SIZE - 1) / TILE_SIZE,
      .orthographic = orthographic,
  };
}

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

uint32_t tile_number(const CameraInfo *camera, uint32_t x, uint32_t y)
{
  uint32_t columns = camera->tiles_per_row, rows = (camera->height + TILE_SIZE - 1) / TILE_SIZE;
  uint32_t left = x / BIN_TILES * BIN_TILES, top = y / BIN_TILES * BIN_TILES;
  uint32_t width = smaller(BIN_TILES, columns - left), height = smaller(BIN_TILES, rows - top);
  return top * columns + left * height + (y - top) * width + (x - left);
}

CameraInfo camera_info_blocks(const CameraInfo *camera, uint32_t block_px)
{
  CameraInfo blocks = *camera;
  blocks.center_x -= camera->scale * (float)camera->crop_x;
  blocks.center_y -= camera->scale * (float)camera->crop_y;
  blocks.crop_x = blocks.crop_y = 0;
  blocks.scale *= (float)block_px;
  blocks.width = (camera->width + block_px - 1) / block_px;
  blocks.height = (camera->height + block_px - 1) / block_px;
  blocks.tiles_per_row = (blocks.width + TILE_SIZE - 1) / TILE_SIZE;
  return blocks;
}

Status camera_rays_make(CameraRays *out, Device *device, const CameraInfo *info, uint32_t samples, Log *log)
{
  float(*offsets)[2] = malloc(samples * sizeof *offsets);
  if (!offsets) return log_no_memory(log, "samples");
  sample_pattern(offsets, samples);
  Status status = camera_rays_make_views(out, device, info, 1, (const float(*)[2])offsets, samples, log);
  free(offsets);
  return status;
}

Status camera_rays_make_views(CameraRays *out, Device *device, const CameraInfo *views, uint32_t view_count,
                              const float (*offsets)[2], uint32_t samples, Log *log)
{
  Status status = STATUS_OK;
  CameraRays camera = {.info = views[0], .view_count = view_count};
  camera.views = malloc(view_count * sizeof *views);
  if (!camera.views) return log_no_memory(log, "camera");
  memcpy(camera.views, views, view_count * sizeof *views);
  TRY(program_build(&camera.program, device, "rays/ray_generate.cl", "", log));
  TRY(program_kernel(&camera.kernel, camera.program, "ray_generate", log));
  TRY(buffer_create(&camera.cameras, device, view_count * sizeof *views, views, "camera", log));
  TRY(buffer_create(&camera.offsets, device, samples * sizeof *offsets, offsets, "samples", log));
  *out = camera;
  camera = (CameraRays){0};

done:
  camera_rays_free(&camera);
  return status;
}

void camera_rays_free(CameraRays *camera)
{
  kernel_free(&camera->kernel);
  free(camera->views);
  buffer_free(&camera->cameras);
  buffer_free(&camera->offsets);
  *camera = (CameraRays){0};
}

uint32_t camera_tile_rows(const CameraRays *camera)
{
  return camera->view_count * ((camera->info.height + TILE_SIZE - 1) / TILE_SIZE);
}

Status camera_rays_generate(const CameraRays *camera, Device *device, const Wave *wave, const RayStream *stream,
                            Log *log)
{
  uint32_t rays = wave_rays(wave);
  return device_launch(device, &camera->kernel, work_items(device, rays), rays, "generate camera rays",
                       ARGS(ARG_BUFFER(camera->cameras), ARG(camera->view_count), ARG_BUFFER(camera->offsets),
                            ARG(wave->first_tile), ARG(wave->tile_count), ARG(wave->first_sample), ARG(rays),
                            ARG_BUFFER(stream->rays), ARG(stream->capacity), ARG_BUFFER(stream->slots)),
                       log);
}
