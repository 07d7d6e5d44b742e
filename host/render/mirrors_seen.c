#include "render/mirrors_seen.h"

#include <stdlib.h>

#include "shared/stream.h"

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

const Side *reflector_side(const Reflector *reflector)
{
  const Side *best = reflector->sides;
  for (int i = 1; i < SIDES_MOST; i++)
    if (reflector->sides[i].pixels > best->pixels) best = &reflector->sides[i];
  return best;
}

// Counts one more pixel for the object of a triangle, if that is a mirror.
static void mirror_count(Reflector *reflectors, const Scene *scene, const uint32_t *starts, uint32_t triangle)
{
  uint32_t object = object_of_triangle(starts, scene->object_count, triangle);
  const Mesh *mesh = &scene->meshes[scene->objects[object].mesh];
  uint32_t within = triangle - starts[object], p = 0;
  while (p < mesh->primitive_count && within >= mesh->primitives[p].triangle_count)
    within -= mesh->primitives[p++].triangle_count;
  if (p == mesh->primitive_count || !material_is_mirror(&scene->materials[mesh->primitives[p].material])) return;
  Reflector *reflector = &reflectors[object];
  MirrorPlane plane;
  if (plane_of_triangle(&plane, scene, object, &mesh->primitives[p], within)) {
    Side *side = reflector->sides, *end = side + SIDES_MOST;
    while (side < end && side->pixels && !planes_are_one(&side->plane, &plane)) side++;
    if (side < end && side->pixels++ == 0) side->plane = plane;
  }
  reflector->object = object;
  reflector->pixels++;
}

Status mirrors_see(Reflector *reflectors, uint32_t *factor, Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const DeviceScene *scene = frame->scene;
  CameraRays camera = {0};
  const CameraInfo *whole = &frame->camera.info;
  *factor = ((whole->width > whole->height ? whole->width : whole->height) + SIGHT_PX - 1) / SIGHT_PX;
  CameraInfo info = camera_info_blocks(whole, *factor);
  uint32_t tiles = info.tiles_per_row * ((info.height + TILE_SIZE - 1) / TILE_SIZE);
  uint32_t wave_tiles = smaller(tiles, frame->capacity / TILE_PIXELS);
  uint32_t *ids = malloc((size_t)wave_tiles * TILE_PIXELS * sizeof *ids);
  uint32_t *starts = malloc(((size_t)scene->object_count + 1) * sizeof *starts);
  if (!ids || !starts) {
    status = log_no_memory(log, "reflectors");
    goto done;
  }
  TRY(buffer_read(frame->device, &scene->object_starts, starts, ((size_t)scene->object_count + 1) * sizeof *starts,
                  log));
  TRY(camera_rays_make(&camera, frame->device, &info, 1, log));
  for (uint32_t tile = 0; tile < tiles; tile += wave_tiles) {
    Wave wave = {tile, smaller(wave_tiles, tiles - tile), 0, 1};
    uint32_t rays = wave_rays(&wave);
    TRY(camera_rays_generate(&camera, frame->device, &wave, &frame->streams[0], log));
    TRY(trace_closest(&frame->tracer, frame->device, scene, &frame->streams[0], rays, info.near_m, &frame->hits,
                      RAYS_COHERENT, "look for reflectors", log));
    TRY(buffer_read(frame->device, &frame->hits.ids, ids, rays * sizeof *ids, log));
    for (uint32_t i = 0; i < rays; i++)
      if (ids[i] != HIT_NONE) mirror_count(reflectors, scene->source, starts, ids[i]);
  }

done:
  camera_rays_free(&camera);
  free(ids);
  free(starts);
  return status;
}
