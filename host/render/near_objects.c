#include "render/near_objects.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "device_scene/part_bvh.h"
#include "plan/cube_error.h"
#include "render/capture_waves.h"

// Texels of a snapshot for one of a cube's, along an axis.
enum { SNAPSHOT_FINER = 2, SNAPSHOT_LEAST_PX = 16, SNAPSHOT_MOST_PX = 512 };

// Of a list: BvhTriangle, and a node for every two of them.
static const uint64_t triangle_bytes = 80;
static const uint64_t snapshot_texel_bytes = sizeof(Float4) + sizeof(float) + 1;

static Vec3 wide(Float3 v) { return vec3((double)v.x, (double)v.y, (double)v.z); }

static Float3 narrow(Vec3 v) { return (Float3){(float)v.x, (float)v.y, (float)v.z}; }

void near_objects_free(NearObjects *near)
{
  for (uint32_t i = 0; i < near->cube_count; i++) near_list_free(&near->lists[i]);
  free(near->lists);
  free(near->reflectors);
  free(near->nears);
  free(near->snapshots);
  *near = (NearObjects){0};
}

void near_objects_mark(const NearObjects *near, uint32_t cube, uint32_t *left_out)
{
  if (cube >= near->cube_count) return;
  for (uint32_t i = 0; i < near->lists[cube].count; i++) left_out[near->lists[cube].objects[i].object] = 1;
}

// ---- who is near, and how it is found -------------------------------------------------------------------------------

// Half of what a reflector is wide: its surface is no farther from the centre of its bounds.
static double reflector_reach_m(const ObjectFacts *facts)
{
  return 0.5 * vec3_length(vec3_sub(facts->high, facts->low));
}

double near_objects_radius_m(const CubeOptions *options, const ObjectFacts *reflector)
{
  double radius_m = (double)options->near_radius_m;
  return radius_m > 0 ? radius_m : cube_near_radius_m(reflector_reach_m(reflector), CUBE_NEAR_PARALLAX_RAD);
}

uint32_t snapshot_size_px(double across, uint32_t cube_px)
{
  const double wanted = across * 0.5 * (cube_px - 1.0) * SNAPSHOT_FINER + 2 * SNAPSHOT_MARGIN_PX + 1;
  uint32_t size = (uint32_t)fmin(fmax(wanted, SNAPSHOT_LEAST_PX), SNAPSHOT_MOST_PX);
  return (size + CUBE_CELL - 1) / CUBE_CELL * CUBE_CELL;
}

static SnapshotInfo snapshot_fit(const SnapshotFrustum *frustum, const CubeInfo *cube, const ObjectFacts *facts,
                                 uint32_t object, double extent_m)
{
  const double across = frustum->width, center_x = frustum->left + across / 2, center_y = frustum->top + across / 2;
  const uint32_t size = snapshot_size_px(across, cube->size);
  const double texels = (size - 1.0 - 2 * SNAPSHOT_MARGIN_PX) / across, half = 0.5 * (size - 1.0) / texels;
  const double farthest = fmax(fabs(center_x), fabs(center_y)) + half, margin_m = 1e-5 * extent_m;
  const Vec3 center = wide(cube->center), wider = vec3(margin_m, margin_m, margin_m);
  return (SnapshotInfo){.center = cube->center,
                        .right = narrow(frustum->right),
                        .down = narrow(frustum->down),
                        .forward = narrow(frustum->forward),
                        .low = narrow(vec3_sub(vec3_sub(facts->low, wider), center)),
                        .high = narrow(vec3_sub(vec3_add(facts->high, wider), center)),
                        .left = (float)(center_x - half),
                        .top = (float)(center_y - half),
                        .texels = (float)texels,
                        .texels_rad = (float)(texels * (1 + farthest * farthest / 2)),
                        .beyond_m = (float)(1.001 * frustum->beyond_m + margin_m),
                        .size = size,
                        .object = object};
}

// Makes room for the snapshots of a list, as far as `bytes_left` goes.
static Status snapshots_fit(NearObjects *out, NearList *list, const CubeInfo *cube, const ObjectFacts *facts,
                            double extent_m, uint64_t bytes_left, Log *log)
{
  size_t most = (size_t)out->snapshot_count + SNAPSHOTS_MOST;
  SnapshotInfo *snapshots = realloc(out->snapshots, most * sizeof *snapshots);
  if (!snapshots) return log_no_memory(log, "snapshots");
  out->snapshots = snapshots;
  for (uint32_t i = 0; i < list->count; i++) {
    NearObject *near = &list->objects[i];
    SnapshotFrustum frustum;
    if (near->method != NEAR_BY_SNAPSHOT) continue;
    const ObjectFacts *object = &facts[near->object];
    snapshot_frustum_fit(&frustum, wide(cube->center), object->low, object->high);
    SnapshotInfo info = snapshot_fit(&frustum, cube, object, near->object, extent_m);
    uint64_t texels = (uint64_t)info.size * info.size;
    if (out->bytes + texels * snapshot_texel_bytes > bytes_left) {
      near->method = NEAR_BY_RAYS;
      near->reason = NEAR_CROWDED;
      continue;
    }
    info.first_texel = (uint32_t)out->snapshot_texels;
    out->snapshots[out->snapshot_count++] = info;
    out->snapshot_texels += texels;
    out->bytes += texels * snapshot_texel_bytes;
  }
  return STATUS_OK;
}

// Lists for one cube; false in *kept where not even the reflector fits.
static Status cube_list(NearObjects *out, bool *kept, const Frame *frame, const CubeInfo *cube,
                        const ObjectFacts *facts, uint64_t bytes_left, Log *log)
{
  Status status = STATUS_OK;
  const Plan *plan = &frame->request.plan;
  const CubeOptions *options = &plan->cubes;
  const ObjectFacts *reflector = &facts[cube->object];
  NearList *list = &out->lists[out->cube_count];
  NearInfo *near = &out->nears[out->cube_count];
  uint64_t left = out->bytes < bytes_left ? (bytes_left - out->bytes) / triangle_bytes : 0;
  *kept = reflector->triangles <= left;
  out->reflectors[out->cube_count] = cube->object;
  TRY(near_list_make(list, frame->scene->source, facts, cube->object, wide(cube->center),
                     near_objects_radius_m(options, reflector), *kept ? left - reflector->triangles : 0, log));
  out->cube_count++;
  out->left_out += list->left_out;
  if (*kept) out->bytes += reflector->triangles * triangle_bytes;
  for (uint32_t i = 0; i < list->count; i++) out->bytes += list->objects[i].triangles * triangle_bytes;
  ReflectionMethod method = reflections_use_lists(plan->reflections) ? plan->reflections : plan->deep_reflections;
  near_list_choose(list, facts, wide(cube->center), method,
                   options->complex_from ? options->complex_from : COMPLEX_FROM_TRIANGLES);
  near->first_snapshot = out->snapshot_count;
  TRY(snapshots_fit(out, list, cube, facts, frame->scene->extent_m, bytes_left, log));
  near->snapshot_count = out->snapshot_count - near->first_snapshot;

done:
  return status;
}

Status near_objects_list(NearObjects *out, const Frame *frame, const CubeInfo *cubes, uint32_t cube_count,
                         uint32_t *cube_of_object, uint64_t bytes_left, Log *log)
{
  Status status = STATUS_OK;
  ObjectFacts *facts = NULL;
  NearObjects near = {0};
  uint32_t lost = 0;
  near.lists = calloc((size_t)cube_count + 1, sizeof *near.lists);
  near.reflectors = calloc((size_t)cube_count + 1, sizeof *near.reflectors);
  near.nears = calloc((size_t)cube_count + 1, sizeof *near.nears);
  if (!near.lists || !near.reflectors || !near.nears) {
    status = log_no_memory(log, "objects near reflectors");
    goto done;
  }
  TRY(object_facts_make(&facts, frame->scene->source, log));
  for (uint32_t i = 0; i < cube_count; i++) {
    bool kept;
    TRY(cube_list(&near, &kept, frame, &cubes[i], facts, bytes_left, log));
    if (!kept) cube_of_object[cubes[i].object] = CUBE_NONE;
    lost += !kept;
  }
  if (lost || near.left_out)
    log_warn(
        log,
        "--reflections: lists of what is near reflectors are over %.0f MB: %u objects stay in cube maps though they "
        "are near, %u reflectors are traced",
        1e-6 * (double)bytes_left, near.left_out, lost);
  *out = near;
  near = (NearObjects){0};

done:
  free(facts);
  near_objects_free(&near);
  return status;
}

// ---- trees ----------------------------------------------------------------------------------------------------------

static int number_compare(const void *a, const void *b)
{
  const uint32_t *x = a, *y = b;
  return (*x > *y) - (*x < *y);
}

// The tree of a cube's reflector and of what is found by rays in its list.
static Status list_tree_make(Bvh2 *out, const NearObjects *near, uint32_t cube, const Scene *scene, Log *log)
{
  const NearList *list = &near->lists[cube];
  uint32_t *objects = malloc(((size_t)list->count + 1) * sizeof *objects), count = 0;
  if (!objects) return log_no_memory(log, "objects near reflectors");
  objects[count++] = near->reflectors[cube];
  for (uint32_t i = 0; i < list->count; i++)
    if (list->objects[i].method == NEAR_BY_RAYS) objects[count++] = list->objects[i].object;
  qsort(objects, count, sizeof *objects, number_compare);
  Status status = part_bvh_make(out, scene, objects, count, log);
  free(objects);
  return status;
}

Status near_objects_make(Frame *frame, const CubeInfo *cubes, Log *log)
{
  Status status = STATUS_OK;
  NearObjects *near = &frame->near_objects;
  Bvh2 *trees = calloc((size_t)near->cube_count + 1, sizeof *trees);
  if (!trees) return log_no_memory(log, "objects near reflectors");
  for (uint32_t i = 0; i < near->cube_count; i++) TRY(list_tree_make(&trees[i], near, i, frame->scene->source, log));
  const NearSources sources = {.nears = near->nears,
                               .trees = trees,
                               .snapshots = near->snapshots,
                               .cube_count = near->cube_count,
                               .snapshot_count = near->snapshot_count,
                               .snapshot_texels = near->snapshot_texels};
  TRY(near_reflect_make(&frame->near_reflect, frame->device, frame->scene, &sources, frame->capacity, log));

done:
  for (uint32_t i = 0; i < near->cube_count; i++) bvh2_free(&trees[i]);
  free(trees);
  return status;
}

// ---- snapshots ------------------------------------------------------------------------------------------------------

static Status snapshot_keep(Frame *frame, const Wave *wave, float share, Log *log)
{
  return snapshot_capture_keep(&frame->snapshot_capture, frame->device, wave, share, &frame->radiance,
                               &frame->near_reflect, log);
}

Status near_objects_draw(Frame *frame, const CubeInfo *cubes, uint32_t samples, Log *log)
{
  Status status = STATUS_OK;
  NearObjects *near = &frame->near_objects;
  SnapshotCapture *capture = &frame->snapshot_capture;
  TRY(snapshot_capture_make(capture, frame->device, frame->capacity, log));
  frame->photographing = true;
  for (uint32_t i = 0; i < near->snapshot_count; i++) {
    const SnapshotInfo *info = &near->snapshots[i];
    TRY(snapshot_capture_aim(capture, frame->device, frame->scene, info, log));
    TRY(capture_waves(frame, info->size, info->size, samples, snapshot_keep, log));
    TRY(snapshot_capture_cells(capture, frame->device, info->size, &frame->near_reflect, log));
    TRY(device_finish(frame->device, log));  // the object's trees are freed next
  }
  for (uint32_t i = 0; i < near->cube_count; i++)
    TRY(cube_change_measure(&near->nears[i], capture, frame->device, &cubes[i], &frame->cube_reflect, log));
  TRY(near_reflect_set(&frame->near_reflect, frame->device, near->nears, log));

done:
  frame->photographing = false;
  snapshot_capture_free(capture);
  return status;
}
