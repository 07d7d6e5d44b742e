#include "render/planar.h"

#include <math.h>
#include <stdlib.h>

#include "plan/samples.h"
#include "shared/stream.h"

static Vec3 wide(Float3 v) { return vec3((double)v.x, (double)v.y, (double)v.z); }

static Float3 narrow(Vec3 v) { return (Float3){(float)v.x, (float)v.y, (float)v.z}; }

static Vec3 direction_mirrored(const MirrorPlane *plane, Vec3 v)
{
  return vec3_sub(v, vec3_scale(plane->normal, 2 * vec3_dot(plane->normal, v)));
}

// Pixel x of the picture, in whole tiles, is pixel width - 1 - x of this one. Depths are as the camera has them, for
// what the mirror shows is farther along the ray than the mirror.
static CameraInfo camera_mirrored(const CameraInfo *camera, const MirrorPlane *plane)
{
  CameraInfo info = *camera;
  Vec3 at = wide(camera->position);
  double height = vec3_dot(plane->normal, at) - plane->offset_m;
  info.width = camera->tiles_per_row * TILE_SIZE;
  info.position = narrow(vec3_sub(at, vec3_scale(plane->normal, 2 * height)));
  info.right = narrow(vec3_neg(direction_mirrored(plane, wide(camera->right))));
  info.down = narrow(direction_mirrored(plane, wide(camera->down)));
  info.forward = narrow(direction_mirrored(plane, wide(camera->forward)));
  info.crop_x = 0;
  info.center_x = (float)(info.width + camera->crop_x) * camera->scale - camera->center_x;
  info.far_m = INFINITY;
  return info;
}

static PlanarInfo info_make(const CameraInfo *mirrored, const MirrorPlane *plane, double extent_m)
{
  return (PlanarInfo){.normal = narrow(plane->normal),
                      .offset_m = (float)plane->offset_m,
                      .eye = mirrored->position,
                      .forward = mirrored->forward,
                      .slack_m = (float)(2e-6 * (extent_m + fabs(plane->offset_m))),
                      .parallel = mirrored->orthographic,
                      .tiles_per_row = mirrored->tiles_per_row,
                      .tile_rows = (mirrored->height + TILE_SIZE - 1) / TILE_SIZE};
}

static Status plane_draw(Frame *frame, const MirrorPlane *plane, RasterVisibility *raster, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t samples = frame->request.samples;
  CameraRays mirrored = {0};
  CameraInfo camera = camera_mirrored(&frame->camera.info, plane);
  PlanarInfo info = info_make(&camera, plane, frame->scene->extent_m);
  float(*offsets)[2] = malloc(samples * sizeof *offsets);
  if (!offsets) return log_no_memory(log, "flat mirrors");
  sample_pattern(offsets, samples);
  for (uint32_t i = 0; i < samples; i++) offsets[i][0] = 1 - offsets[i][0];
  TRY(camera_rays_make(&mirrored, frame->device, &camera, samples, log));
  TRY(buffer_write(frame->device, &mirrored.offsets, offsets, samples * sizeof *offsets, log));
  TRY(planar_draw(&frame->planar, frame->device, frame->scene, &frame->raster_scene, raster, &info, &mirrored, samples,
                  &frame->hits, frame->capacity, log));

done:
  camera_rays_free(&mirrored);
  free(offsets);
  return status;
}

// Planes of the mirrors that fit; which of them each object has.
static uint32_t planes_choose(MirrorPlane planes[PLANES_MOST], uint32_t *plane_of_object, uint32_t *left_out,
                              const FlatMirror *mirrors, uint32_t count, uint32_t most)
{
  uint32_t kept = 0;
  *left_out = 0;
  for (uint32_t i = 0; i < count; i++) {
    uint32_t p = 0;
    while (p < kept && !planes_are_one(&planes[p], &mirrors[i].plane)) p++;
    if (p == most) {
      ++*left_out;
      continue;
    }
    if (p == kept) planes[kept++] = mirrors[i].plane;
    plane_of_object[mirrors[i].object] = p;
  }
  return kept;
}

Status planar_prepare(Frame *frame, const FlatMirror *mirrors, uint32_t count, Log *log)
{
  Status status = STATUS_OK;
  const CameraInfo *camera = &frame->camera.info;
  const uint32_t objects = frame->scene->object_count;
  const uint64_t tiles = (uint64_t)camera->tiles_per_row * ((camera->height + TILE_SIZE - 1) / TILE_SIZE);
  const uint64_t bytes = tiles * TILE_PIXELS * frame->request.samples * sizeof(uint32_t);
  const uint64_t most = device_budget(frame->device, frame->request.plan.cubes.max_bytes, 512000000) / bytes;
  RasterVisibility raster = {0};
  MirrorPlane planes[PLANES_MOST];
  uint32_t *plane_of_object = malloc((objects + 1) * sizeof *plane_of_object), left_out = 0;
  if (!plane_of_object) return log_no_memory(log, "flat mirrors");
  for (uint32_t i = 0; i < objects; i++) plane_of_object[i] = PLANE_NONE;
  uint32_t kept = planes_choose(planes, plane_of_object, &left_out, mirrors, count,
                                most < PLANES_MOST ? (uint32_t)most : PLANES_MOST);
  if (left_out)
    log_warn(log, "--reflections: %u of %u flat mirrors are over %d planes or %.0f MB: their reflections are traced",
             left_out, count, PLANES_MOST, 1e-6 * (double)(most * bytes));
  TRY(planar_make(&frame->planar, frame->device, frame->scene, plane_of_object, log));
  frame->planar.left_out = left_out;
  if (kept == 0) goto done;
  TRY(raster_visibility_make(&raster, frame->device, frame->scene, &(RasterOptions){0}, log));
  for (uint32_t i = 0; i < kept; i++) TRY(plane_draw(frame, &planes[i], &raster, log));

done:
  raster_visibility_free(&raster);
  free(plane_of_object);
  return status;
}
