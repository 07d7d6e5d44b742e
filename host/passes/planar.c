#include "passes/planar.h"

#include "passes/scene_args.h"
#include "shared/raster.h"
#include "shared/stream.h"

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

Status planar_make(Planar *out, Device *device, const DeviceScene *scene, const uint32_t *plane_of_object, Log *log)
{
  Status status = STATUS_OK;
  Planar planar = {0};
  Program *program = NULL;
  TRY(program_build(&program, device, "capture/planar.cl", "", log));
  TRY(program_kernel(&planar.clip, program, "planar_clip", log));
  TRY(program_kernel(&planar.keep, program, "planar_keep", log));
  TRY(program_kernel(&planar.reflect, program, "planar_reflect", log));
  TRY(buffer_create(&planar.plane_of_object, device, scene->object_count * sizeof *plane_of_object, plane_of_object,
                    "flat mirrors", log));
  TRY(buffer_create(&planar.counts, device, 2 * sizeof(uint32_t), NULL, "flat mirrors", log));
  *out = planar;
  planar = (Planar){0};

done:
  planar_free(&planar);
  return status;
}

void planar_free(Planar *planar)
{
  kernel_free(&planar->clip);
  kernel_free(&planar->keep);
  kernel_free(&planar->reflect);
  for (uint32_t i = 0; i < PLANES_MOST; i++) {
    buffer_free(&planar->views[i].info);
    buffer_free(&planar->views[i].names);
  }
  buffer_free(&planar->plane_of_object);
  buffer_free(&planar->counts);
  *planar = (Planar){0};
}

static Status names_draw(const Planar *planar, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                         RasterVisibility *raster, const CameraRays *mirrored, uint32_t samples,
                         const DeviceBuffer *names, const HitStream *hits, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  const CameraInfo *camera = &mirrored->info;
  uint32_t tiles = camera->tiles_per_row * ((camera->height + TILE_SIZE - 1) / TILE_SIZE);
  uint32_t wave_tiles = smaller(tiles, capacity / TILE_PIXELS);
  TRY(raster_visibility_aim(raster, device, triangles, mirrored, samples, capacity, log));
  for (uint32_t sample = 0; sample < samples; sample++)
    for (uint32_t tile = 0; tile < tiles; tile += wave_tiles) {
      Wave wave = {tile, smaller(wave_tiles, tiles - tile), sample, 1};
      uint32_t rays = wave_rays(&wave);
      TRY(raster_visibility(raster, device, scene, triangles, mirrored, &wave, hits, capacity, log));
      TRY(device_launch(device, &planar->keep, work_items(device, rays), rays, "keep what a flat mirror shows",
                        ARGS(ARG(wave.first_tile), ARG(wave.tile_count), ARG(wave.first_sample), ARG(rays), ARG(tiles),
                             ARG_BUFFER(hits->ids), ARG_BUFFER(*names)),
                        log));
    }
  TRY(device_finish(device, log));

done:
  return status;
}

Status planar_draw(Planar *planar, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                   RasterVisibility *raster, const PlanarInfo *info, const CameraRays *mirrored, uint32_t samples,
                   const HitStream *hits, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  RasterScene before = *triangles;
  PlanarView *view = &planar->views[planar->count];
  uint32_t blocks = triangles->chunk_count * RASTER_CHUNK_BLOCKS;
  size_t tiles = (size_t)info->tiles_per_row * info->tile_rows;
  size_t bytes = tiles * TILE_PIXELS * samples * sizeof(uint32_t);
  before.blocks = (DeviceBuffer){0};
  TRY(buffer_create(&view->info, device, sizeof *info, info, "flat mirrors", log));
  TRY(buffer_create(&view->names, device, bytes, NULL, "flat mirrors", log));
  TRY(buffer_create(&before.blocks, device, blocks * sizeof(RasterBlock), NULL, "flat mirrors", log));
  TRY(device_launch(device, &planar->clip, blocks, (uint64_t)blocks * RASTER_STEP, "clip at a flat mirror",
                    ARGS(ARG_BUFFER(view->info), ARG_BUFFER(triangles->blocks), ARG(blocks), ARG_BUFFER(before.blocks)),
                    log));
  TRY(names_draw(planar, device, scene, &before, raster, mirrored, samples, &view->names, hits, capacity, log));
  planar->count++;
  planar->bytes += bytes;

done:
  buffer_free(&before.blocks);
  return status;
}

Status planar_reflect(Planar *planar, Device *device, const DeviceScene *scene, const Wave *wave, const RayStream *rays,
                      uint32_t count, const RayStream *left, const KnownHits *known, LeftRays *out, Log *log)
{
  Status status = STATUS_OK;
  uint32_t counts[2];
  TRY(buffer_zero(device, &planar->counts, log));
  for (uint32_t i = 0; i < planar->count; i++) {
    const PlanarView *view = &planar->views[i];
    uint32_t others = i == 0;
    TRY(device_launch(device, &planar->reflect, work_items(device, count), count, "look up flat mirrors",
                      ARGS(ARG_BUFFER(view->info), ARG(i), ARG(others), ARG(wave->first_tile), ARG(wave->tile_count),
                           ARG(wave->first_sample), ARG_BUFFER(view->names), ARG_BUFFER(rays->rays),
                           ARG_BUFFER(rays->slots), ARG(rays->capacity), ARG(count), ARG_BUFFER(scene->object_starts),
                           ARG(scene->object_count), ARG_BUFFER(planar->plane_of_object), ARG_BUFFER(scene->positions),
                           ARG_BUFFER(scene->corners), ARG_BUFFER(scene->materials), ARG_BUFFER(left->rays),
                           ARG_BUFFER(left->slots), ARG_BUFFER(known->rays.rays), ARG_BUFFER(known->rays.slots),
                           ARG_BUFFER(known->hits.hits), ARG_BUFFER(known->hits.ids), ARG_BUFFER(planar->counts)),
                      log));
  }
  TRY(buffer_read(device, &planar->counts, counts, sizeof counts, log));
  *out = (LeftRays){counts[0], counts[1]};
  planar->looked_up += count;
  planar->left += counts[0];

done:
  return status;
}
