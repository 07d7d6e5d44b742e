#include "passes/cube_prefilter.h"

#include <math.h>

#include "device_scene/ggx_sample.h"
#include "passes/scene_args.h"

uint32_t cube_level_samples(uint32_t level) { return level < 2 ? 128 : 64; }

static uint32_t level_first_sample(uint32_t level)
{
  uint32_t first = 0;
  for (uint32_t k = 0; k < level; k++) first += cube_level_samples(k);
  return first;
}

void cube_level_samples_fill(PrefilterSample *out, uint32_t level)
{
  const uint32_t count = cube_level_samples(level);
  double sum = 0;
  for (uint32_t i = 0; i < count; i++) {
    GgxSample sample = ggx_sample((int)i, (int)count, exp2(-(double)level));
    // Solid angle of the sample over that of a texel of a cube of one texel a face.
    double share = 6 / (4 * M_PI) / (count * sample.density), weight = fmax(sample.up, 0);
    out[i] = (PrefilterSample){(float)sample.along, (float)sample.across, (float)sample.up, (float)weight,
                               (float)(0.5 * log2(share) + 0.5)};
    sum += weight;
  }
  for (uint32_t i = 0; i < count; i++) out[i].weight = (float)((double)out[i].weight / sum);
}

// Halved images of a cube, and the texels before one of them.
static uint32_t image_count(uint32_t size)
{
  uint32_t count = 1;
  while (size >> count >= CUBE_SMALLEST_IMAGE_PX) count++;
  return count;
}

static uint32_t image_first(uint32_t size, uint32_t image)
{
  uint32_t first = 0;
  for (uint32_t k = 1; k < image; k++) first += CUBE_TEXELS(size >> k);
  return first;
}

Status cube_prefilter_make(CubePrefilter *out, Device *device, uint32_t greatest_px, Log *log)
{
  Status status = STATUS_OK;
  CubePrefilter prefilter = {0};
  Program *program = NULL;
  enum { SAMPLES_MOST = CUBE_LEVELS * 128 };
  PrefilterSample samples[SAMPLES_MOST];
  for (uint32_t k = 0; k < CUBE_LEVELS; k++) cube_level_samples_fill(samples + level_first_sample(k), k);
  size_t images = image_first(greatest_px, image_count(greatest_px));
  TRY(program_build(&program, device, "capture/cube_prefilter.cl", "", log));
  TRY(program_kernel(&prefilter.halve, program, "cube_halve", log));
  TRY(program_kernel(&prefilter.level, program, "cube_prefilter", log));
  TRY(buffer_create(&prefilter.samples, device, level_first_sample(CUBE_LEVELS) * sizeof *samples, samples,
                    "cube map levels", log));
  TRY(buffer_create(&prefilter.images, device, images * sizeof(Float4), NULL, "cube map levels", log));
  *out = prefilter;
  prefilter = (CubePrefilter){0};

done:
  cube_prefilter_free(&prefilter);
  return status;
}

void cube_prefilter_free(CubePrefilter *prefilter)
{
  kernel_free(&prefilter->halve);
  kernel_free(&prefilter->level);
  buffer_free(&prefilter->samples);
  buffer_free(&prefilter->images);
  *prefilter = (CubePrefilter){0};
}

static Status image_halve(const CubePrefilter *prefilter, Device *device, const CubeInfo *cube, uint32_t image,
                          const DeviceBuffer *texels, Log *log)
{
  const uint32_t from_cube = image == 1, from_size = cube->size >> (image - 1), to_size = cube->size >> image;
  const uint32_t from_first = from_cube ? cube->first_texel : image_first(cube->size, image - 1);
  const uint32_t to_first = image_first(cube->size, image), count = CUBE_TEXELS(to_size);
  const DeviceBuffer *from = from_cube ? texels : &prefilter->images;
  return device_launch(device, &prefilter->halve, work_items(device, count), count, "halve a cube map",
                       ARGS(ARG(from_cube), ARG(from_size), ARG(from_first), ARG_BUFFER(*from), ARG(to_size),
                            ARG(to_first), ARG_BUFFER(prefilter->images)),
                       log);
}

Status cube_prefilter(const CubePrefilter *prefilter, Device *device, const CubeInfo *cube, const DeviceBuffer *texels,
                      const DeviceBuffer *levels, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t images = image_count(cube->size), level_count = cube_level_count(cube->size);
  const float size_log2 = log2f((float)cube->size);
  for (uint32_t image = 1; image < images; image++) TRY(image_halve(prefilter, device, cube, image, texels, log));
  for (uint32_t k = 0; k < level_count; k++) {
    const uint32_t size = cube_level_size(k, cube->size), count = CUBE_TEXELS(size);
    const uint32_t first = cube->first_level + cube_level_first(k, cube->size);
    const uint32_t first_sample = level_first_sample(k), samples = cube_level_samples(k);
    TRY(device_launch(device, &prefilter->level, work_items(device, count), count, "prefilter a cube map",
                      ARGS(ARG(cube->size), ARG(size_log2), ARG(images), ARG(cube->first_texel), ARG_BUFFER(*texels),
                           ARG_BUFFER(prefilter->images), ARG_BUFFER(prefilter->samples), ARG(first_sample),
                           ARG(samples), ARG(size), ARG(first), ARG_BUFFER(*levels)),
                      log));
  }

done:
  return status;
}
