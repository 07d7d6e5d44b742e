// Ray generator pass: cl/rays/ray_generate.cl; and the wave, the unit in which a picture is worked through.
#pragma once

#include "passes/ray_stream.h"
#include "scene/scene.h"
#include "shared/camera.h"

// Tiles [first_tile, first_tile + tile_count) times samples [first_sample, first_sample + sample_count).
typedef struct Wave {
  uint32_t first_tile, tile_count;
  uint32_t first_sample, sample_count;
} Wave;

static inline uint32_t wave_rays(const Wave *wave) { return wave->tile_count * wave->sample_count * 64; }

// Number of the tile in column x and row y of a picture's tiles (shared/stream.h).
uint32_t tile_number(const CameraInfo *camera, uint32_t x, uint32_t y);

typedef struct CameraRays {
  Program *program;
  Kernel kernel;
  CameraInfo info;    // of the first view
  CameraInfo *views;  // [view_count], one under the other in the picture
  uint32_t view_count;
  DeviceBuffer cameras;  // the same on the device
  DeviceBuffer offsets;  // sample positions, [samples][2]
} CameraRays;

// The part [crop_x, crop_x + width) x [crop_y, crop_y + height) of a whole picture of whole_width x whole_height.
typedef struct PictureArea {
  uint32_t whole_width, whole_height;
  uint32_t crop_x, crop_y, width, height;
} PictureArea;

CameraInfo camera_info(const Camera *camera, const PictureArea *area);

// The same camera with pixels that are block_px times as wide and high; those at the right and at the bottom may reach
// past the picture.
CameraInfo camera_info_blocks(const CameraInfo *camera, uint32_t block_px);

Status camera_rays_make(CameraRays *out, Device *device, const CameraInfo *info, uint32_t samples, Log *log);

// For a picture of several views (shared/camera.h) and positions of samples in their pixels, [samples].
Status camera_rays_make_views(CameraRays *out, Device *device, const CameraInfo *views, uint32_t view_count,
                              const float (*offsets)[2], uint32_t samples, Log *log);
void camera_rays_free(CameraRays *camera);

// Rows of tiles of all views.
uint32_t camera_tile_rows(const CameraRays *camera);

Status camera_rays_generate(const CameraRays *camera, Device *device, const Wave *wave, const RayStream *stream,
                            Log *log);
