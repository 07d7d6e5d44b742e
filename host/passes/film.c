#include "passes/film.h"

#include "passes/scene_args.h"
#include "shared/aov.h"

// The pictures of the film before. False: there are none, or of another size.
static bool pictures_take(Film *film, Film *before, size_t bytes)
{
  if (!before || before->sums.bytes != bytes || before->picture.bytes != bytes) return false;
  film->sums = before->sums;
  film->picture = before->picture;
  before->sums = before->picture = (DeviceBuffer){0};
  return true;
}

static Status pictures_create(Film *film, Device *device, size_t bytes, Log *log)
{
  Status status = STATUS_OK;
  TRY(buffer_create_whole(&film->sums, device, bytes, "picture", log));
  TRY(buffer_create_whole(&film->picture, device, bytes, "picture", log));
  TRY(buffer_zero(device, &film->sums, log));

done:
  return status;
}

Status film_make(Film *out, Device *device, const DeviceScene *scene, const CameraInfo *camera, bool aovs, Film *before,
                 Log *log)
{
  Status status = STATUS_OK;
  Film film = {0};
  size_t pixels = (size_t)camera->width * camera->height;
  TRY(program_build(&film.program, device, "shade/film.cl", "", log));
  TRY(program_kernel(&film.accumulate, film.program, "accumulate", log));
  TRY(program_kernel(&film.resolve, film.program, "resolve", log));
  TRY(buffer_create(&film.info, device, sizeof(ResolveInfo), NULL, "output settings", log));
  if (!pictures_take(&film, before, pixels * sizeof(Float4)))
    TRY(pictures_create(&film, device, pixels * sizeof(Float4), log));
  if (aovs) {
    char options[128];
    device_scene_options(scene, READS_SURFACES, options, sizeof options);
    TRY(program_build(&film.aov_program, device, "shade/aov.cl", options, log));
    TRY(program_kernel(&film.aov, film.aov_program, "aov", log));
    TRY(buffer_create(&film.aov_values, device, pixels * AOV_VALUE_PLANES * sizeof(float), NULL, "AOVs", log));
    TRY(buffer_create(&film.aov_ids, device, pixels * AOV_ID_PLANES * sizeof(uint32_t), NULL, "AOVs", log));
  }
  *out = film;
  film = (Film){0};

done:
  film_free(&film);
  return status;
}

void film_free(Film *film)
{
  kernel_free(&film->accumulate);
  kernel_free(&film->resolve);
  kernel_free(&film->aov);
  buffer_free(&film->info);
  buffer_free(&film->sums);
  buffer_free(&film->picture);
  buffer_free(&film->aov_values);
  buffer_free(&film->aov_ids);
  *film = (Film){0};
}

Status film_accumulate(const Film *film, Device *device, const CameraRays *camera, const Wave *wave,
                       const DeviceBuffer *radiance, const DeviceBuffer *sums, bool begin, Log *log)
{
  uint32_t pixels = wave->tile_count * 64, begins = begin;
  return device_launch(device, &film->accumulate, work_items(device, pixels), pixels, "add samples to the picture",
                       ARGS(ARG_BUFFER(camera->cameras), ARG(wave->first_tile), ARG(wave->tile_count),
                            ARG(wave->sample_count), ARG(begins), ARG_BUFFER(*radiance), ARG_BUFFER(*sums)),
                       log);
}

Status film_aov(const Film *film, Device *device, const DeviceScene *scene, const CameraRays *camera, const Wave *wave,
                const RayStream *rays, const HitStream *hits, Log *log)
{
  uint32_t pixels = wave->tile_count * 64;
  return device_launch(
      device, &film->aov, work_items(device, pixels), pixels, "write AOVs",
      ARGS(ARG_BUFFER(camera->cameras), ARG(wave->first_tile), ARG(wave->tile_count), ARG(wave->first_sample),
           ARG(wave->sample_count), ARG_BUFFER(rays->rays), ARG(rays->capacity), ARG_BUFFER(hits->hits),
           ARG_BUFFER(hits->ids), ARG_BUFFER(scene->positions), ARG_BUFFER(scene->normals), ARG_BUFFER(scene->tangents),
           ATTRIBUTE_ARGS(scene), ARG_BUFFER(scene->object_starts), ARG(scene->object_count),
           ARG_BUFFER(film->aov_values), ARG_BUFFER(film->aov_ids)),
      log);
}

Status film_develop(const Film *film, Device *device, const DeviceBuffer *sums, const ResolveInfo *info, Log *log)
{
  Status status = STATUS_OK;
  DeviceBuffer settings = film->info;
  TRY(buffer_write(device, &settings, info, sizeof *info, log));
  TRY(device_launch(device, &film->resolve, work_items(device, info->pixel_count), info->pixel_count,
                    "resolve the picture", ARGS(ARG_BUFFER(film->info), ARG_BUFFER(*sums), ARG_BUFFER(film->picture)),
                    log));

done:
  return status;
}

Status film_resolve(const Film *film, Device *device, const DeviceBuffer *sums, const ResolveInfo *info, float *out,
                    Log *log)
{
  Status status = STATUS_OK;
  TRY(film_develop(film, device, sums, info, log));
  TRY(buffer_read(device, &film->picture, out, (size_t)info->pixel_count * sizeof(Float4), log));

done:
  return status;
}
