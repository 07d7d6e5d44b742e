#include "render/reflectors.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plan/reflection_cost.h"
#include "render/cubes_draw.h"
#include "render/mirrors_seen.h"
#include "render/planar.h"
#include "render/reflector_cube.h"

// Of what hybrid reflections allow a texel to be off: half of what is seen.
#define HYBRID_ALLOWED (0.5f / 255)

// Texels for one pixel of a mirror that mirrors show: its images are small, and outlines are as wide as texels. By
// trial: with 1, 2 and 4 in turn .0012, .0008 and .0006 of the pixels of chrome are over 2/255 with rays before
// impostors, .0006 with the first cubes of 256 texels.
#define DEEP_FINER 2.0

static int reflector_compare(const void *a, const void *b)
{
  const Reflector *x = a, *y = b;
  if (x->pixels != y->pixels) return x->pixels < y->pixels ? 1 : -1;
  if (x->pixels == 0 && x->rough_pixels != y->rough_pixels) return x->rough_pixels < y->rough_pixels ? 1 : -1;
  return (x->object > y->object) - (x->object < y->object);
}

static uint32_t lights_traced(const Frame *frame)
{
  uint32_t count = 0;
  for (uint32_t i = 0; i < frame->scene->light_count; i++)
    count += (SHADOW_SET_TRACED & SHADOW_SET(frame_light_shadows(frame, i))) != 0;
  return count;
}

// Does a reflector gain nothing from hybrid reflections? What a flat mirror shows needs more texels than it has pixels:
// nearly all of it would be traced. A size that is asked for is a wish to have the map.
static bool rays_are_better(ReflectorSummary *summary, const Frame *frame, const Reflector *reflector, uint32_t size,
                            uint32_t factor)
{
  const FrameRequest *request = &frame->request;
  if (!plan_uses_reflections(&request->plan, REFLECTIONS_HYBRID)) return false;
  const bool flat = reflector_side(reflector)->pixels == reflector->pixels;
  summary->flat += flat;
  if (flat) return true;
  const ReflectionFacts facts = {.rays = (double)reflector->pixels * factor * factor * request->samples,
                                 .size_px = size,
                                 .triangles = frame->scene->triangle_count,
                                 .lights = lights_traced(frame),
                                 .gpu = device_info(frame->device)->is_gpu};
  ReflectionCost cost = reflection_cost(&facts);
  summary->rays_ms += cost.rays_ms;
  summary->hybrid_ms += cost.hybrid_ms;
  if (request->plan.cubes.size_px || cost.hybrid_ms < cost.rays_ms) return false;
  summary->without_gain++;
  return true;
}

// Cubes so far, and the texels of them and of their levels.
typedef struct CubeRoom {
  CubeInfo *cubes;
  uint32_t *of_object, *deep_of_object;
  CubeOrder order;
  uint64_t texels, level_texels;
} CubeRoom;

// Reflectors that ask for cubes, [count], by pixels of a small picture, each `factor` of the picture's wide.
typedef struct Wishes {
  Reflector *reflectors;
  uint32_t count, factor;
  bool deep;  // mirrors seen in others
} Wishes;

// Which of a reflector's surfaces ask its cube.
typedef struct CubeUse {
  bool mirror, rough;
  uint32_t size;
} CubeUse;

static CubeUse cube_use(ReflectorSummary *summary, const Frame *frame, const Reflector *reflector, const Wishes *wishes)
{
  const Plan *plan = &frame->request.plan;
  const uint32_t factor = wishes->factor;
  const double texels = factor * (wishes->deep ? DEEP_FINER : 1);
  CubeUse use = {reflector->pixels > 0, plan->rough_by_maps && reflector->rough_pixels > 0, 0};
  use.size = cube_size_choose(&plan->cubes, reflector->pixels * texels * texels);
  if (use.mirror && !wishes->deep && rays_are_better(summary, frame, reflector, use.size, factor)) use.mirror = false;
  if (!use.mirror && use.rough) use.size = rough_cube_size_choose(&plan->cubes, reflector, factor);
  return use;
}

// Adds a reflector's cube, if there is room.
static bool cube_add(CubeRoom *room, ReflectorSummary *summary, const Frame *frame, const Reflector *reflector,
                     CubeUse use, bool deep, uint64_t most)
{
  const uint32_t object = reflector->object;
  const uint64_t texel_bytes = sizeof(Float4) + (cubes_are_marched(&frame->request.plan) ? sizeof(float) : 0);
  const uint64_t texels = CUBE_TEXELS((uint64_t)use.size);
  const uint64_t levels = use.rough ? cube_level_first(cube_level_count(use.size), use.size) : 0;
  uint64_t bytes = texels * texel_bytes + levels * sizeof(Float4);
  if (!deep && plan_uses_reflections(&frame->request.plan, REFLECTIONS_HYBRID)) bytes += hybrid_reflect_bytes(use.size);
  if (room->order.count == CUBES_MOST || summary->bytes + bytes > most) return false;
  CubeInfo *cube = &room->cubes[room->order.count];
  *cube = cube_fit(frame->scene, object, use.size, use.mirror ? NULL : &reflector->sight);
  cube->first_texel = (uint32_t)room->texels;
  if (use.rough) cube->first_level = (uint32_t)room->level_texels;
  if (!use.mirror) cube->hull_least = INFINITY;
  (deep ? room->deep_of_object : room->of_object)[object] = room->order.count++ | (use.mirror ? 0 : CUBE_FOR_ROUGH);
  room->order.mirrors += use.mirror && !deep;
  room->texels += texels;
  room->level_texels += levels;
  summary->bytes += bytes;
  summary->levels += use.rough ? cube_level_count(use.size) : 0;
  if (summary->least_px == 0 || use.size < summary->least_px) summary->least_px = use.size;
  if (use.size > summary->greatest_px) summary->greatest_px = use.size;
  return true;
}

static void left_out_warn(const Wishes *wishes, uint32_t mirrors, uint32_t rough, uint64_t most, Log *log)
{
  const char *seen = wishes->deep ? " in mirrors" : "";
  uint32_t rough_count = 0;
  for (uint32_t i = 0; i < wishes->count; i++) rough_count += wishes->reflectors[i].pixels == 0;
  if (mirrors)
    log_warn(log, "--reflections: %u of %u reflectors%s are over %d cube maps or %.0f MB: their reflections are traced",
             mirrors, wishes->count - rough_count, seen, CUBES_MOST, 1e-6 * (double)most);
  if (rough)
    log_warn(log,
             "--reflections: %u of %u rough reflectors%s are over %d cube maps or %.0f MB: they show the environment: "
             "lower --max-roughness",
             rough, rough_count, seen, CUBES_MOST, 1e-6 * (double)most);
}

// Cubes of the reflectors that fit: mirrors first, largest first.
static void cubes_fit(CubeRoom *room, Frame *frame, const Wishes *wishes, Log *log)
{
  const uint64_t most = device_budget(frame->device, frame->request.plan.cubes.max_bytes, CUBES_MOST_BYTES);
  ReflectorSummary *summary = &frame->reflectors;
  uint32_t left_out = 0, rough_left_out = 0;
  for (uint32_t i = 0; i < wishes->count; i++) {
    const Reflector *reflector = &wishes->reflectors[i];
    const CubeUse use = cube_use(summary, frame, reflector, wishes);
    if (!use.mirror && !use.rough) continue;
    if (cube_add(room, summary, frame, reflector, use, wishes->deep, most)) continue;
    left_out++;
    rough_left_out += !use.mirror;
  }
  if (!wishes->deep) summary->left_out += left_out;
  left_out_warn(wishes, left_out - rough_left_out, rough_left_out, most, log);
}

static Status flat_mirrors_prepare(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const uint32_t objects = frame->scene->object_count;
  uint32_t count = 0, factor;
  Reflector *reflectors = calloc((size_t)objects + 1, sizeof *reflectors);
  FlatMirror *mirrors = calloc((size_t)objects + 1, sizeof *mirrors);
  if (!reflectors || !mirrors) {
    status = log_no_memory(log, "flat mirrors");
    goto done;
  }
  TRY(mirrors_see(reflectors, NULL, &factor, frame, log));
  qsort(reflectors, objects, sizeof *reflectors, reflector_compare);
  for (uint32_t i = 0; i < objects && reflectors[i].pixels; i++) {
    frame->reflectors.visible++;
    const Side *side = reflector_side(&reflectors[i]);
    bool flat = 2 * side->pixels > reflectors[i].pixels;
    frame->reflectors.flat += flat;
    if (flat) mirrors[count++] = (FlatMirror){reflectors[i].object, side->plane};
  }
  TRY(planar_prepare(frame, mirrors, count, log));

done:
  free(reflectors);
  free(mirrors);
  return status;
}

static Status hybrid_prepare(Frame *frame, const CubeInfo *cubes, uint32_t count, Log *log)
{
  HybridReflect *hybrid = &frame->hybrid_reflect;
  bool *convex = calloc(count, sizeof *convex);
  if (!convex) return log_no_memory(log, "cube maps");
  for (uint32_t i = 0; i < count; i++) convex[i] = isinf(cubes[i].hull_least);
  Status status = hybrid_reflect_make(hybrid, frame->device, frame->scene, &frame->raster_scene, &frame->camera.info,
                                      cubes, convex, count, frame->capacity, log);
  hybrid->allowed = HYBRID_ALLOWED;
  hybrid->scale = isinf(frame->request.exposure_ev) ? INFINITY : exp2f(frame->request.exposure_ev);
  free(convex);
  return status;
}

// Takes all that the frame before made about its cubes.
static void cubes_take_all(Frame *frame)
{
  Frame *before = frame->request.before;
  frame->near_objects = before->near_objects;
  frame->near_reflect = before->near_reflect;
  frame->cube_reflect = before->cube_reflect;
  frame->hybrid_reflect = before->hybrid_reflect;
  before->near_objects = (NearObjects){0};
  before->near_reflect = (NearReflect){0};
  before->cube_reflect = (CubeReflect){0};
  before->hybrid_reflect = (HybridReflect){0};
  frame->cube_reflect.environment_levels = frame->shader.environment_levels;
  frame->cube_reflect.looked_up = frame->cube_reflect.left = 0;
  frame->hybrid_reflect.shaded = 0;
  frame->near_reflect.looked_up = 0;
  memset(frame->near_reflect.totals, 0, sizeof frame->near_reflect.totals);
  frame->reflectors.faces_kept = CUBE_FACES * frame->cubes_drawn.order.count;
}

static bool reflector_is_seen(const Reflector *reflector) { return reflector->pixels || reflector->rough_pixels; }

// Of all objects' those that are seen, in the order in which they get cubes.
static void wishes_sort(Wishes *wishes, uint32_t objects)
{
  for (uint32_t i = 0; i < objects; i++)
    if (reflector_is_seen(&wishes->reflectors[i])) wishes->reflectors[wishes->count++] = wishes->reflectors[i];
  qsort(wishes->reflectors, wishes->count, sizeof *wishes->reflectors, reflector_compare);
}

static bool object_reflects(const Frame *frame, uint32_t object)
{
  const Scene *scene = frame->scene->source;
  const Mesh *mesh = &scene->meshes[scene->objects[object].mesh];
  for (uint32_t p = 0; p < mesh->primitive_count; p++) {
    const Material *material = &scene->materials[mesh->primitives[p].material];
    if (material_is_mirror(material) || material_asks_levels(material, frame)) return true;
  }
  return false;
}

// Looks for reflectors and fits cubes for them.
static Status cubes_choose(CubeRoom *room, Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const Plan *plan = &frame->request.plan;
  const uint32_t objects = frame->scene->object_count;
  const bool deeply = plan_uses_deep_cubes(plan);
  Wishes first = {.reflectors = calloc((size_t)objects + 1, sizeof *first.reflectors)};
  Wishes deep = {.reflectors = calloc((size_t)objects + 1, sizeof *deep.reflectors), .deep = true};
  ReflectorSummary *summary = &frame->reflectors;
  if (!first.reflectors || !deep.reflectors) {
    status = log_no_memory(log, "cube maps");
    goto done;
  }
  TRY(mirrors_see(first.reflectors, deeply ? deep.reflectors : NULL, &first.factor, frame, log));
  deep.factor = first.factor;
  for (uint32_t i = 0; i < objects; i++) {
    const bool seen = reflector_is_seen(&first.reflectors[i]), within = reflector_is_seen(&deep.reflectors[i]);
    summary->within += within;
    summary->within_alone += within && !seen;
    summary->unseen += !within && !seen && object_reflects(frame, i);
  }
  wishes_sort(&first, objects);
  wishes_sort(&deep, objects);
  summary->visible = first.count;
  for (uint32_t i = 0; i < first.count; i++) summary->rough += first.reflectors[i].pixels == 0;
  if (plan_uses_first_cubes(plan)) cubes_fit(room, frame, &first, log);
  room->order.first_deep = room->order.count;
  cubes_fit(room, frame, &deep, log);
  summary->deep_cubes = room->order.count - room->order.first_deep;

done:
  free(first.reflectors);
  free(deep.reflectors);
  return status;
}

static bool room_make(CubeRoom *room, uint32_t objects)
{
  const size_t table_bytes = ((size_t)objects + 1) * sizeof *room->of_object;
  *room = (CubeRoom){.cubes = calloc(CUBES_MOST, sizeof *room->cubes),
                     .of_object = malloc(table_bytes),
                     .deep_of_object = malloc(table_bytes)};
  if (!room->cubes || !room->of_object || !room->deep_of_object) return false;
  memset(room->of_object, 0xff, table_bytes);  // CUBE_NONE
  memset(room->deep_of_object, 0xff, table_bytes);
  return true;
}

static void room_free(CubeRoom *room)
{
  free(room->cubes);
  free(room->of_object);
  free(room->deep_of_object);
}

// Makes what is looked up, and fills it.
static Status cubes_make(Frame *frame, const CubeRoom *room, Log *log)
{
  Status status = STATUS_OK;
  const Plan *plan = &frame->request.plan;
  const CubeTable table = {room->cubes, room->of_object, room->deep_of_object, room->order.count, room->level_texels};
  if (room->order.mirrors && plan_uses_lists(plan)) {
    uint64_t most = device_budget(frame->device, plan->cubes.max_bytes, CUBES_MOST_BYTES);
    TRY(near_objects_list(&frame->near_objects, frame, room->cubes, room->order.mirrors, room->of_object,
                          most - frame->reflectors.bytes, log));
    TRY(near_objects_make(frame, room->cubes, log));
  }
  TRY(cube_reflect_make(&frame->cube_reflect, frame->device, frame->scene, &table, cubes_are_marched(plan), log));
  frame->cube_reflect.environment_levels = frame->shader.environment_levels;
  if (room->order.first_deep && plan_uses_reflections(plan, REFLECTIONS_HYBRID))
    TRY(hybrid_prepare(frame, room->cubes, room->order.first_deep, log));
  if (room->order.count) TRY(cubes_draw(frame, log));

done:
  return status;
}

Status reflectors_prepare(Frame *frame, Log *log)
{
  Status status = STATUS_OK;
  const Plan *plan = &frame->request.plan;
  CubeRoom room = {0};
  if (plan->reflections == REFLECTIONS_PLANAR) TRY(flat_mirrors_prepare(frame, log));
  if (!reflections_use_maps(plan->reflections) && !reflections_use_maps(plan->deep_reflections)) return STATUS_OK;
  if (!room_make(&room, frame->scene->object_count)) {
    status = log_no_memory(log, "cube maps");
    goto done;
  }
  if (plan_uses_cubes(plan)) TRY(cubes_choose(&room, frame, log));
  TRY(cube_record_make(&frame->cubes_drawn, frame, room.cubes, &room.order, log));
  if (room.order.count && cubes_stayed(frame))
    cubes_take_all(frame);
  else
    TRY(cubes_make(frame, &room, log));

done:
  room_free(&room);
  return status;
}
