#include "render/kept_cubes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "passes/movers.h"
#include "render/frame.h"
#include "shared/stream.h"

float cube_near_m(const DeviceScene *scene, const CubeInfo *cube)
{
  Vec3 low = {0}, high = {0};
  scene_object_bounds(scene->source, cube->object, &low, &high);
  Vec3 size = vec3_sub(high, low);
  return (float)fmin(4e-5 * scene->extent_m, 0.05 * fmin(size.x, fmin(size.y, size.z)));
}

Status cube_record_make(CubeRecord *out, const Frame *frame, const CubeInfo *cubes, const CubeOrder *order, Log *log)
{
  const DeviceScene *scene = frame->scene;
  const size_t count = order->count;
  CubeRecord record = {.order = *order, .light_count = scene->light_count, .camera = frame->camera.info};
  record.cubes = calloc(count + 1, sizeof *record.cubes);
  record.nears_m = calloc(count + 1, sizeof *record.nears_m);
  record.redrawn = calloc(count + 1, sizeof *record.redrawn);
  record.lights = calloc((size_t)scene->light_count + 1, sizeof *record.lights);
  if (!record.cubes || !record.nears_m || !record.redrawn || !record.lights) {
    cube_record_free(&record);
    return log_no_memory(log, "cube maps");
  }
  for (size_t i = 0; i < count; i++) {
    record.cubes[i] = cubes[i];
    record.nears_m[i] = cube_near_m(scene, &cubes[i]);
  }
  if (scene->light_count) memcpy(record.lights, scene->light_infos, scene->light_count * sizeof *record.lights);
  *out = record;
  return STATUS_OK;
}

void cube_record_free(CubeRecord *record)
{
  free(record->cubes);
  free(record->nears_m);
  free(record->redrawn);
  free(record->lights);
  *record = (CubeRecord){0};
}

// Are a light's shadows found by the same maps? Where these lie may differ.
static bool is_same_map(const ShadowMaps *now, const ShadowMaps *then, uint32_t light)
{
  if (light >= now->light_count || light >= then->light_count) return now->light_count == then->light_count;
  ShadowInfo a = now->lights[light], b = then->lights[light];
  const ShadowView *views = now->view_table + a.first_view, *views_then = then->view_table + b.first_view;
  a.first_view = b.first_view = a.first_texel = b.first_texel = 0;
  return memcmp(&a, &b, sizeof a) == 0 &&
         (a.view_count == 0 || memcmp(views, views_then, a.view_count * sizeof *views) == 0);
}

// Is a light as it was, and its shadows? Both frames have it.
static bool light_stayed(const Frame *frame, const Frame *before, uint32_t light)
{
  const CubeRecord *now = &frame->cubes_drawn, *then = &before->cubes_drawn;
  return memcmp(&now->lights[light], &then->lights[light], sizeof *now->lights) == 0 &&
         is_same_map(&frame->shadow_maps, &before->shadow_maps, light);
}

static bool lights_stayed(const Frame *frame, const Frame *before)
{
  const uint32_t count = frame->cubes_drawn.light_count;
  bool stayed = count == before->cubes_drawn.light_count;
  for (uint32_t i = 0; i < count && stayed; i++) stayed = light_stayed(frame, before, i);
  return stayed;
}

static bool is_same_cube(const CubeRecord *now, uint32_t cube, const CubeRecord *then, uint32_t index)
{
  CubeInfo a = now->cubes[cube], b = then->cubes[index];
  const bool levels = a.first_level != CUBE_NONE, levels_then = b.first_level != CUBE_NONE;
  a.first_texel = b.first_texel = a.first_level = b.first_level = 0;
  return memcmp(&a, &b, sizeof a) == 0 && levels == levels_then &&
         memcmp(&now->nears_m[cube], &then->nears_m[index], sizeof *now->nears_m) == 0;
}

// The same cube of another record, of those that the same see; CUBE_NONE.
static uint32_t same_cube(const CubeRecord *record, uint32_t cube, const CubeRecord *other)
{
  const CubeOrder *order = &record->order, *others = &other->order;
  const bool mirror = cube < order->mirrors, deep = cube >= order->first_deep;
  const uint32_t end = mirror ? others->mirrors : deep ? others->count : others->first_deep;
  uint32_t index = mirror ? 0 : deep ? others->first_deep : others->mirrors;
  while (index < end && !is_same_cube(record, cube, other, index)) index++;
  return index < end ? index : CUBE_NONE;
}

bool cubes_stayed(const Frame *frame)
{
  const Frame *before = frame->request.before;
  const CubeRecord *now = &frame->cubes_drawn;
  if (!before || frame->scene->mover_count || !lights_stayed(frame, before)) return false;
  const CubeRecord *then = &before->cubes_drawn;
  if (memcmp(&now->order, &then->order, sizeof now->order) != 0) return false;
  if (plan_uses_reflections(&frame->request.plan, REFLECTIONS_HYBRID) &&
      memcmp(&now->camera, &then->camera, sizeof now->camera) != 0)
    return false;
  for (uint32_t i = 0; i < now->order.count; i++)
    if (!is_same_cube(now, i, then, i)) return false;
  return true;
}

// Are other things seen on a face than those in its view? `plan` is that of captures.
static bool sees_beyond(const Plan *plan) { return plan->reflected_rays && !reflections_use_maps(plan->reflections); }

// Is what a face shows changed by what is seen on it, and shadows there, alone?
static bool is_local(const Plan *plan, const DeviceScene *scene)
{
  const bool sampled =
      plan->environment_light == ENVIRONMENT_LIGHT_SAMPLED || plan->environment_light == ENVIRONMENT_LIGHT_SH_AO;
  const bool sharp = !plan_uses_shadows(plan, ~SHADOW_SET_SHARP);
  return !(sampled && scene->environment_lights) && sharp;
}

// May a mirror be drawn in the view, or in any, whose deep cube shows on this one and is not as it was?
static bool changed_cubes_seen(const Frame *frame, uint32_t cube, const CubeChanges *changes, const RasterView *view)
{
  if (cube >= frame->cubes_drawn.order.mirrors) return false;
  const CubeRecord *records[] = {&frame->cubes_drawn, &frame->request.before->cubes_drawn};
  for (int k = 0; k < 2; k++)
    for (uint32_t i = records[k]->order.first_deep; i < records[k]->order.count; i++) {
      const bool changed = k == 0 ? records[0]->redrawn[i] : same_cube(records[1], i, records[0]) == CUBE_NONE;
      const ObjectFacts *object = &changes->objects[records[k]->cubes[i].object];
      if (changed && (!view || raster_view_may_see_box(view, object->low, object->high))) return true;
    }
  return false;
}

static bool face_moved(const Frame *frame, uint32_t cube, const CubeChanges *changes, const RasterView *view)
{
  const DeviceScene *scene = frame->scene;
  if (movers_seen(scene, view) || changed_cubes_seen(frame, cube, changes, view)) return true;
  for (uint32_t i = 0; i < scene->light_count && frame->request.plan.shadow_rays; i++)
    if (mover_shadows_seen(scene, &scene->light_infos[i], view)) return true;
  return false;
}

static bool face_reached(const Frame *frame, const CubeChanges *changes, const RasterView *view)
{
  for (uint32_t i = 0; i < changes->light_count; i++)
    if (light_reach_seen(&changes->lights[i], view, changes->objects, frame->scene->object_count)) return true;
  return false;
}

// Of faces on which nothing moved those that changed lights shine on. What they show tells more than hulls.
static Status faces_lit(uint32_t *lit, const Frame *frame, const CubeInfo *then, const CubeChanges *changes, Log *log)
{
  const DeviceScene *scene = frame->scene;
  uint32_t found = CUBE_ALL_FACES;
  Status status = STATUS_OK;
  if (*lit && changes->lit.light_count)
    status = cube_lit_find(&found, &changes->lit, frame->device, then, &frame->request.before->cube_reflect.texels,
                           (float)place_slack_m(scene->low, scene->high), log);
  *lit &= found;
  return status;
}

// Faces of a cube, which was there as `then`, that are to be drawn anew.
static Status faces_changed(uint32_t *changed, const Frame *frame, uint32_t cube, const CubeInfo *then,
                            const CubeChanges *changes, Log *log)
{
  Status status = STATUS_OK;
  const CubeInfo *info = &frame->cubes_drawn.cubes[cube];
  const Plan *plan = &frame->request.plan;
  const bool moved = frame->scene->mover_count > 0;
  CameraInfo cameras[CUBE_FACES];
  uint32_t lit = 0;
  *changed = 0;
  if (!moved && changes->light_count == 0 && !changed_cubes_seen(frame, cube, changes, NULL)) return STATUS_OK;
  *changed = CUBE_ALL_FACES;
  if (sees_beyond(plan) || (moved && !is_local(plan, frame->scene))) return STATUS_OK;
  *changed = 0;
  const Float3 at = info->center;
  cube_cameras(cameras, info->size, vec3(at.x, at.y, at.z), frame->cubes_drawn.nears_m[cube]);
  for (uint32_t face = 0; face < CUBE_FACES; face++) {
    const RasterView view = raster_view_of_camera(&cameras[face]);
    if (face_moved(frame, cube, changes, &view))
      *changed |= 1u << face;
    else if (face_reached(frame, changes, &view))
      lit |= 1u << face;
  }
  TRY(faces_lit(&lit, frame, then, changes, log));
  *changed |= lit;
  const bool whole_bins = info->size % (BIN_TILES * TILE_SIZE) == 0;  // a face's tiles are numbered in a row
  if (*changed && !whole_bins) *changed = CUBE_ALL_FACES;

done:
  return status;
}

// Of the lights that changed; `infos` holds them as they were and as they are.
static Status changed_lights_find(CubeChanges *out, LightInfo *infos, const Frame *frame, Log *log)
{
  const DeviceScene *scene = frame->scene;
  const CubeRecord *now = &frame->cubes_drawn, *then = &frame->request.before->cubes_drawn;
  for (uint32_t i = 0; i < now->light_count; i++) {
    if (light_stayed(frame, frame->request.before, i)) continue;
    infos[out->light_count++] = then->lights[i];
    infos[out->light_count++] = now->lights[i];
  }
  for (uint32_t i = 0; i < out->light_count; i++) out->lights[i] = light_reach(&infos[i], scene->low, scene->high);
  if (out->light_count == 0 || scene->has_blends) return STATUS_OK;
  return cube_lit_make(&out->lit, frame->device, infos, out->light_count, log);
}

Status cube_changes_make(CubeChanges *out, const Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const Frame *before = frame->request.before;
  const CubeOrder *order = &frame->cubes_drawn.order, *order_then = before ? &before->cubes_drawn.order : NULL;
  const uint32_t most = 2 * frame->scene->light_count;
  LightInfo *infos = calloc((size_t)most + 1, sizeof *infos);
  CubeChanges changes = {.lights_differ = !before || before->cubes_drawn.light_count != frame->scene->light_count,
                         .lights = calloc((size_t)most + 1, sizeof *changes.lights)};
  if (!infos || !changes.lights) {
    status = log_no_memory(log, "cube maps");
    goto done;
  }
  if (changes.lights_differ) goto done;
  TRY(changed_lights_find(&changes, infos, frame, log));
  if (changes.light_count || order->count > order->first_deep || order_then->count > order_then->first_deep)
    TRY(object_facts_make(&changes.objects, frame->scene->source, log));

done:
  free(infos);
  *out = changes;
  if (status) cube_changes_free(out);
  return status;
}

void cube_changes_free(CubeChanges *changes)
{
  free(changes->lights);
  free(changes->objects);
  cube_lit_free(&changes->lit);
  *changes = (CubeChanges){0};
}

typedef struct CubePart {
  const DeviceBuffer *from, *to;
  size_t from_first, to_first, count;  // words
} CubePart;

static Status cube_copy(Frame *frame, const CubeInfo *to, const CubeInfo *from, Log *log)
{
  Status status = STATUS_OK;
  const CubeReflect *now = &frame->cube_reflect, *then = &frame->request.before->cube_reflect;
  const size_t texels = CUBE_TEXELS((size_t)to->size), cell = CUBE_CELL * CUBE_CELL;
  const size_t levels = to->first_level == CUBE_NONE ? 0 : cube_level_first(cube_level_count(to->size), to->size);
  const size_t a = from->first_texel, b = to->first_texel;
  const bool marched = now->hull.bytes > sizeof(float);
  const CubePart parts[] = {
      {&then->texels, &now->texels, 4 * a, 4 * b, 4 * texels},
      {&then->levels, &now->levels, 4 * (size_t)from->first_level, 4 * (size_t)to->first_level, 4 * levels},
      {&then->hull, &now->hull, a, b, marched ? texels : 0},
      {&then->cells, &now->cells, a / cell, b / cell, marched ? texels / cell : 0},
  };
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
    TRY(buffer_copy_words(frame->device, parts[i].from, parts[i].from_first, parts[i].to, parts[i].to_first,
                          parts[i].count, log));

done:
  return status;
}

Status cube_take(uint32_t *faces, Frame *frame, uint32_t cube, const CubeChanges *changes, Log *log)
{
  Status status = STATUS_OK;
  const Frame *before = frame->request.before;
  const CubeRecord *now = &frame->cubes_drawn;
  const CubeInfo *info = &now->cubes[cube];
  const size_t face_words = 4 * (size_t)info->size * info->size;
  *faces = CUBE_ALL_FACES;
  frame->cubes_drawn.redrawn[cube] = true;
  if (!before || changes->lights_differ) return STATUS_OK;
  const CubeRecord *then = &before->cubes_drawn;
  const uint32_t index = same_cube(now, cube, then);
  if (index == CUBE_NONE) return STATUS_OK;
  uint32_t changed;
  TRY(faces_changed(&changed, frame, cube, &then->cubes[index], changes, log));
  if (changed == CUBE_ALL_FACES) return STATUS_OK;
  TRY(cube_copy(frame, info, &then->cubes[index], log));
  for (uint32_t face = 0; face < CUBE_FACES; face++)
    if (changed >> face & 1)
      TRY(buffer_fill_part(frame->device, &frame->cube_reflect.texels,
                           4 * (size_t)info->first_texel + face * face_words, face_words, 0, log));
  *faces = changed;
  frame->cubes_drawn.redrawn[cube] = changed != 0;

done:
  return status;
}
