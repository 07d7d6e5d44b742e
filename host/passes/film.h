// From a wave's radiance to the picture: cl/shade/film.cl, cl/shade/aov.cl.
#pragma once

#include "device_scene/device_scene.h"
#include "passes/camera_rays.h"
#include "shared/resolve.h"

typedef struct Film {
  Program *program, *aov_program;
  Kernel accumulate, resolve, aov;
  DeviceBuffer info;                 // ResolveInfo
  DeviceBuffer sums;                 // Float4 by pixel
  DeviceBuffer picture;              // Float4 by pixel
  DeviceBuffer aov_values, aov_ids;  // planes of shared/aov.h; empty without AOVs
} Film;

// Takes the pictures of the film before, as they are, where they are as large; NULL is none. New sums are zero: the
// first samples of a whole picture set them.
Status film_make(Film *out, Device *device, const DeviceScene *scene, const CameraInfo *camera, bool aovs, Film *before,
                 Log *log);
void film_free(Film *film);

// Adds the wave's samples to `sums` (film->sums, or a buffer like it); with `begin` they set them.
Status film_accumulate(const Film *film, Device *device, const CameraRays *camera, const Wave *wave,
                       const DeviceBuffer *radiance, const DeviceBuffer *sums, bool begin, Log *log);
Status film_aov(const Film *film, Device *device, const DeviceScene *scene, const CameraRays *camera, const Wave *wave,
                const RayStream *rays, const HitStream *hits, Log *log);

// Turns sums into values, [height][width][4]; film_develop leaves them in film->picture.
Status film_develop(const Film *film, Device *device, const DeviceBuffer *sums, const ResolveInfo *info, Log *log);
Status film_resolve(const Film *film, Device *device, const DeviceBuffer *sums, const ResolveInfo *info, float *out,
                    Log *log);
