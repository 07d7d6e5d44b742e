#include "passes/hybrid_reflect.h"

#include <stdlib.h>
#include <string.h>

#include "passes/scene_args.h"

// Six maps about the cube's centre.
static void lists_fit(ShadowFit *out, const DeviceScene *scene, const CameraInfo *camera, const CubeInfo *cube)
{
  const LightInfo eye = {.kind = LIGHT_KIND_POINT, .position = cube->center, .radiant = {1, 1, 1}, .range_m = INFINITY};
  const ShadowOptions options = {.map_size_px = cube->size};
  const ShadowScope scope = {camera, scene->low, scene->high};
  shadow_fit(out, &eye, SHADOWS_HYBRID, &options, &scope);
}

uint64_t hybrid_reflect_bytes(uint32_t size_px)
{
  const ShadowInfo info = {.view_count = CUBE_FACES, .size_px = size_px};
  return sure_maps_tiles(&info) * sure_tile_bytes + CUBE_TEXELS((uint64_t)size_px) * 3 * sizeof(float);
}

// One bit for each triangle of the scene: those of an object.
static void object_mark(uint32_t *words, size_t word_count, const uint32_t *starts, uint32_t object)
{
  memset(words, 0, word_count * sizeof *words);
  for (uint32_t i = starts[object]; i < starts[object + 1]; i++) words[i / 32] |= 1u << i % 32;
}

static Status lists_draw(HybridReflect *hybrid, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                         const CubeInfo *cubes, uint32_t cube_count, Log *log)
{
  Status status = STATUS_OK;
  const size_t word_count = scene->triangle_count / 32 + 1, starts_bytes = (scene->object_count + 1) * sizeof(uint32_t);
  SureRaster raster = {0};
  DeviceBuffer marks = {0};
  uint32_t *words = malloc(word_count * sizeof *words), *starts = malloc(starts_bytes);
  if (!words || !starts) {
    status = log_no_memory(log, "hybrid reflections");
    goto done;
  }
  TRY(buffer_read(device, &scene->object_starts, starts, starts_bytes, log));
  TRY(sure_raster_make(&raster, device, triangles, &(RasterOptions){0}, log));
  TRY(buffer_create(&marks, device, word_count * sizeof *words, NULL, "hybrid reflections", log));
  for (uint32_t i = 0; i < cube_count; i++) {
    object_mark(words, word_count, starts, cubes[i].object);
    TRY(buffer_write(device, &marks, words, word_count * sizeof *words, log));
    TRY(sure_maps_draw(&hybrid->lists, i, &raster, device, triangles, &marks, SURE_MARKED_LEFT_OUT, log));
  }
  TRY(device_finish(device, log));

done:
  sure_raster_free(&raster);
  buffer_free(&marks);
  free(words);
  free(starts);
  return status;
}

// The trees of reflectors that are not convex; empty ones of those that are.
static Status own_trees_make(NearTrace *out, Device *device, const DeviceScene *scene, const CubeInfo *cubes,
                             const bool *convex, uint32_t cube_count, uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  Bvh2 *trees = calloc((size_t)cube_count + 1, sizeof *trees);
  NearInfo *nears = calloc((size_t)cube_count + 1, sizeof *nears);
  if (!trees || !nears) {
    status = log_no_memory(log, "hybrid reflections");
    goto done;
  }
  for (uint32_t i = 0; i < cube_count; i++)
    TRY(part_bvh_make(&trees[i], scene->source, &cubes[i].object, convex[i] ? 0 : 1, log));
  TRY(near_trace_make(out, device, scene, trees, nears, cube_count, capacity, log));

done:
  for (uint32_t i = 0; trees && i < cube_count; i++) bvh2_free(&trees[i]);
  free(trees);
  free(nears);
  return status;
}

Status hybrid_reflect_make(HybridReflect *out, Device *device, const DeviceScene *scene, const RasterScene *triangles,
                           const CameraInfo *camera, const CubeInfo *cubes, const bool *convex, uint32_t cube_count,
                           uint32_t capacity, Log *log)
{
  Status status = STATUS_OK;
  Program *program = NULL;
  size_t texels = 0;
  ShadowFit *fits = calloc((size_t)cube_count + 1, sizeof *fits);
  if (!fits) return log_no_memory(log, "hybrid reflections");
  for (uint32_t i = 0; i < cube_count; i++) {
    lists_fit(&fits[i], scene, camera, &cubes[i]);
    texels += CUBE_TEXELS((size_t)cubes[i].size);
  }
  TRY(program_build(&program, device, "capture/hybrid_reflect.cl", "", log));
  TRY(program_kernel(&out->kernel, program, "hybrid_reflect", log));
  TRY(buffer_create(&out->doubts, device, texels * 2 * sizeof(float), NULL, "hybrid reflections", log));
  TRY(buffer_create(&out->names, device, texels * sizeof(uint32_t), NULL, "hybrid reflections", log));
  TRY(buffer_create(&out->counts, device, 2 * sizeof(uint32_t), NULL, "hybrid reflections", log));
  TRY(own_trees_make(&out->own, device, scene, cubes, convex, cube_count, capacity, log));
  TRY(sure_maps_aim(&out->lists, device, fits, cube_count, false, log));
  TRY(sure_maps_settle(&out->lists, device, scene, NULL, log));
  if (cube_count) TRY(lists_draw(out, device, scene, triangles, cubes, cube_count, log));

done:
  free(fits);
  return status;
}

void hybrid_reflect_free(HybridReflect *hybrid)
{
  kernel_free(&hybrid->kernel);
  near_trace_free(&hybrid->own);
  sure_maps_free(&hybrid->lists);
  buffer_free(&hybrid->doubts);
  buffer_free(&hybrid->names);
  buffer_free(&hybrid->counts);
  *hybrid = (HybridReflect){0};
}

Status hybrid_reflect(HybridReflect *hybrid, CubeReflect *maps, Device *device, const DeviceScene *scene,
                      const RayStream *rays, uint32_t count, const DeviceBuffer *radiance, const RayStream *left,
                      const KnownHits *known, LeftRays *out, Log *log)
{
  Status status = STATUS_OK;
  const SureMaps *lists = &hybrid->lists;
  uint32_t counts[2];
  TRY(near_trace(&hybrid->own, device, scene, &maps->cube_of_object, rays, count, log));
  TRY(buffer_zero(device, &hybrid->counts, log));
  TRY(device_launch(
      device, &hybrid->kernel, work_items(device, count), count, "look up lists and cube maps",
      ARGS(ARG_BUFFER(rays->rays), ARG_BUFFER(rays->slots), ARG(rays->capacity), ARG(count),
           ARG_BUFFER(hybrid->own.hits.hits), ARG_BUFFER(hybrid->own.hits.ids), ARG_BUFFER(scene->object_starts),
           ARG(scene->object_count), ARG_BUFFER(maps->cube_of_object), ARG_BUFFER(maps->cubes),
           ARG_BUFFER(maps->texels), ARG_BUFFER(hybrid->doubts), ARG_BUFFER(hybrid->names), ARG(hybrid->scale),
           ARG(hybrid->allowed), ARG_BUFFER(lists->infos), ARG_BUFFER(lists->views), ARG_BUFFER(lists->tiles),
           ARG_BUFFER(lists->blocks), ARG_BUFFER(lists->rows), ARG(lists->block_count),
           ARG_BUFFER(scene->bvh2_triangles), ARG_BUFFER(scene->environment), ARG_BUFFER(scene->environment_pixels),
           ARG_BUFFER(*radiance), ARG_BUFFER(left->rays), ARG_BUFFER(left->slots), ARG_BUFFER(known->rays.rays),
           ARG_BUFFER(known->rays.slots), ARG_BUFFER(known->hits.hits), ARG_BUFFER(known->hits.ids),
           ARG_BUFFER(hybrid->counts)),
      log));
  TRY(buffer_read(device, &hybrid->counts, counts, sizeof counts, log));
  *out = (LeftRays){counts[0], counts[1]};
  maps->looked_up += count;
  maps->left += out->traced;
  hybrid->shaded += out->known;

done:
  return status;
}
