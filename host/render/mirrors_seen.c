#include "render/mirrors_seen.h"

#include <stdlib.h>

#include "render/mirrors_within.h"
#include "shared/stream.h"

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

const Side *reflector_side(const Reflector *reflector)
{
  const Side *best = reflector->sides;
  for (int i = 1; i < SIDES_MOST; i++)
    if (reflector->sides[i].pixels > best->pixels) best = &reflector->sides[i];
  return best;
}

static bool reflects_nothing(const Material *material)
{
  const float *base = material->base_color;
  return material->unlit || (material->metallic >= 1 && base[0] + base[1] + base[2] <= 0);
}

// What the rays of a wave see, read back; ways of rays up to RAY_T_MAX, [RAY_T_MAX][rays].
typedef struct SeenWave {
  uint32_t *ids;
  float *t, *ways;
  uint32_t rays;
} SeenWave;

static RoughSight seen_sight(const SeenWave *wave, uint32_t ray)
{
  double at[RAY_T_MAX];
  for (uint32_t field = 0; field < RAY_T_MAX; field++) at[field] = (double)wave->ways[field * wave->rays + ray];
  const Vec3 way =
      vec3_scale(vec3(at[RAY_DIRECTION_X], at[RAY_DIRECTION_Y], at[RAY_DIRECTION_Z]), (double)wave->t[ray]);
  return (RoughSight){vec3_add(vec3(at[RAY_ORIGIN_X], at[RAY_ORIGIN_Y], at[RAY_ORIGIN_Z]), way), way};
}

static Status wave_read(SeenWave *out, Frame *frame, uint32_t rays, Log *log)
{
  Status status = STATUS_OK;
  out->rays = rays;
  TRY(buffer_read(frame->device, &frame->hits.ids, out->ids, rays * sizeof *out->ids, log));
  if (!frame->request.plan.rough_by_maps) return STATUS_OK;
  TRY(buffer_read(frame->device, &frame->hits.hits, out->t, rays * sizeof *out->t, log));
  TRY(ray_stream_read(out->ways, frame->device, &frame->streams[0], RAY_T_MAX, rays, log));

done:
  return status;
}

static float roughness_of(const Material *material, const DeviceScene *scene)
{
  return material->metallic_roughness_slot.texture != NONE ? scene->least_roughness : material->roughness;
}

bool material_asks_levels(const Material *material, const Frame *frame)
{
  const Plan *plan = &frame->request.plan;
  return plan->rough_by_maps && !material_is_mirror(material) && !reflects_nothing(material) &&
         roughness_of(material, frame->scene) <= plan->max_roughness;
}

void reflector_see_rough(Reflector *reflector, uint32_t object, float roughness, const RoughSight *sight)
{
  reflector->object = object;
  if (reflector->rough_pixels == 0 || roughness < reflector->least_roughness) reflector->least_roughness = roughness;
  reflector->rough_pixels++;
  reflector->rough_sum_m = vec3_add(reflector->rough_sum_m, sight->place_m);
  const Vec3 middle = vec3_scale(reflector->rough_sum_m, 1.0 / reflector->rough_pixels);
  const double here = vec3_length(vec3_sub(sight->place_m, middle));
  if (reflector->rough_pixels == 1 || here < vec3_length(vec3_sub(reflector->sight.place_m, middle)))
    reflector->sight = *sight;
}

void reflector_see(Reflector *reflectors, const Frame *frame, const uint32_t *starts, uint32_t triangle,
                   const RoughSight *sight)
{
  const Scene *scene = frame->scene->source;
  uint32_t object = object_of_triangle(starts, scene->object_count, triangle);
  const Mesh *mesh = &scene->meshes[scene->objects[object].mesh];
  uint32_t within = triangle - starts[object], p = 0;
  while (p < mesh->primitive_count && within >= mesh->primitives[p].triangle_count)
    within -= mesh->primitives[p++].triangle_count;
  if (p == mesh->primitive_count) return;
  const Material *material = &scene->materials[mesh->primitives[p].material];
  Reflector *reflector = &reflectors[object];
  reflector->object = object;
  if (!material_is_mirror(material)) {
    if (sight && material_asks_levels(material, frame))
      reflector_see_rough(reflector, object, roughness_of(material, frame->scene), sight);
    return;
  }
  MirrorPlane plane;
  if (plane_of_triangle(&plane, scene, object, &mesh->primitives[p], within)) {
    Side *side = reflector->sides, *end = side + SIDES_MOST;
    while (side < end && side->pixels && !planes_are_one(&side->plane, &plane)) side++;
    if (side < end && side->pixels++ == 0) side->plane = plane;
  }
  reflector->pixels++;
}

static void wave_count(Reflector *reflectors, const Frame *frame, const uint32_t *starts, const SeenWave *wave)
{
  RoughSight sight = {0};
  for (uint32_t i = 0; i < wave->rays; i++) {
    if (wave->ids[i] == HIT_NONE) continue;
    if (frame->request.plan.rough_by_maps) sight = seen_sight(wave, i);
    reflector_see(reflectors, frame, starts, wave->ids[i], &sight);
  }
}

Status mirrors_see(Reflector *reflectors, Reflector *within, uint32_t *factor, Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const DeviceScene *scene = frame->scene;
  CameraRays camera = {0};
  const CameraInfo *whole = &frame->camera.info;
  *factor = ((whole->width > whole->height ? whole->width : whole->height) + SIGHT_PX - 1) / SIGHT_PX;
  CameraInfo info = camera_info_blocks(whole, *factor);
  uint32_t tiles = info.tiles_per_row * ((info.height + TILE_SIZE - 1) / TILE_SIZE);
  uint32_t wave_tiles = smaller(tiles, frame->capacity / TILE_PIXELS);
  const uint32_t wave_most = wave_tiles * TILE_PIXELS;
  SeenWave seen = {.ids = malloc(wave_most * sizeof *seen.ids),
                   .t = malloc(wave_most * sizeof *seen.t),
                   .ways = malloc((size_t)RAY_T_MAX * wave_most * sizeof *seen.ways)};
  uint32_t *starts = malloc(((size_t)scene->object_count + 1) * sizeof *starts);
  if (!seen.ids || !seen.t || !seen.ways || !starts) {
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
    TRY(wave_read(&seen, frame, rays, log));
    wave_count(reflectors, frame, starts, &seen);
    if (within) TRY(mirrors_within_see(within, frame, starts, &wave, &info, log));
  }

done:
  camera_rays_free(&camera);
  free(seen.ids);
  free(seen.t);
  free(seen.ways);
  free(starts);
  return status;
}
