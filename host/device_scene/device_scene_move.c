#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "device_scene/kept_scene.h"

// Does every object still have the primitives, vertices and triangles that it had?
static Status counts_check(const DeviceScene *scene, Log *log)
{
  const Scene *source = scene->source;
  const KeptScene *kept = scene->kept;
  FlatPart *parts = NULL;
  uint32_t count;
  if (!kept) return log_fail(log, STATUS_FAILED, "%s: the scene was not made to be moved", source->path);
  if (flat_parts_make(&parts, &count, source, log)) return STATUS_NO_MEMORY;
  bool same = source->object_count == scene->object_count && source->light_count == scene->light_count &&
              source->mesh_count == kept->mesh_count && count == kept->part_count &&
              memcmp(parts, kept->parts, count * sizeof *parts) == 0;
  free(parts);
  if (same) return STATUS_OK;
  return log_fail(log, STATUS_FAILED, "%s: objects, triangles or lights came or went: only what is there can move",
                  source->path);
}

static Status lights_follow(DeviceScene *scene, Device *device, Log *log)
{
  Status status = STATUS_OK;
  const size_t bytes = scene->light_count * sizeof *scene->light_infos;
  LightInfo *lights = calloc((size_t)scene->light_count + 1, sizeof *lights);
  if (!lights) return log_no_memory(log, scene->source->path);
  flat_lights_fill(lights, scene->source);
  if (memcmp(lights, scene->light_infos, bytes)) {
    memcpy(scene->light_infos, lights, bytes);
    TRY(buffer_write(device, &scene->lights, lights, bytes, log));
  }

done:
  free(lights);
  return status;
}

// Queues the vertices and triangles of parts that moved, neighbours together.
static Status geometry_write(DeviceScene *scene, Device *device, Log *log)
{
  Status status = STATUS_OK;
  const KeptScene *kept = scene->kept;
  for (uint32_t begin = 0, end; begin < kept->part_count; begin = end) {
    const int moved = kept->parts_moved[begin];
    for (end = begin + 1; moved && end < kept->part_count && kept->parts_moved[end] == moved;) end++;
    const size_t v = kept->parts[begin].vertices.begin, vertices = kept->parts[end - 1].vertices.end - v;
    const size_t t = kept->parts[begin].triangles.begin, triangles = kept->parts[end - 1].triangles.end - t;
    const FlatScene *flat = &kept->flat;
    const struct {
      const DeviceBuffer *buffer;
      const void *from;
      size_t first, bytes, count;
      int when;
    } arrays[] = {
        {&scene->positions, flat->positions, v, sizeof *flat->positions, vertices, MOVED_SHAPE},
        {&scene->corners, flat->corners, t, sizeof *flat->corners, triangles, MOVED_SHAPE},
        {&scene->normals, flat->normals, v, sizeof *flat->normals, vertices, MOVED_SHADING},
        {&scene->tangents, flat->tangents, v, sizeof *flat->tangents, flat->tangents ? vertices : 0, MOVED_SHADING},
    };
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
      if (moved & arrays[i].when)
        TRY(buffer_write_part(device, arrays[i].buffer, arrays[i].first * arrays[i].bytes,
                              (const char *)arrays[i].from + arrays[i].first * arrays[i].bytes,
                              arrays[i].count * arrays[i].bytes, log));
  }

done:
  return status;
}

static bool shapes_moved(const KeptScene *kept)
{
  for (uint32_t i = 0; i < kept->candidate_count; i++)
    if (kept->parts_moved[kept->candidates[i]] & MOVED_SHAPE) return true;
  return false;
}

static Status trees_build_anew(DeviceScene *scene, Device *device, Timeline *timeline, Log *log)
{
  Status status = STATUS_OK;
  KeptScene *kept = scene->kept;
  double begin_ms = clock_ms();
  scene->trees_rebuilt = true;
  scene_trees_free(&kept->trees);
  TRY(scene_trees_build(&kept->trees, device, &kept->flat, log));
  TRY(scene_trees_link(&kept->trees, kept->flat.triangle_count, log));
  if (timeline) timeline_end(timeline, "build the BVH", begin_ms);
  begin_ms = clock_ms();
  TRY(scene_trees_put(scene, device, &kept->trees, log));
  if (timeline) timeline_end(timeline, "upload the BVH", begin_ms);

done:
  return status;
}

static Status trees_follow(DeviceScene *scene, Device *device, Timeline *timeline, Log *log)
{
  double begin_ms = clock_ms();
  bool refitted = kept_scene_refit(scene->kept);
  if (timeline) timeline_end(timeline, "refit the BVH", begin_ms);
  return refitted ? scene_trees_write_moved(scene, device, &scene->kept->trees, log)
                  : trees_build_anew(scene, device, timeline, log);
}

Status device_scene_move(DeviceScene *scene, Device *device, Timeline *timeline, Log *log)
{
  Status status = STATUS_OK;
  KeptScene *kept = scene->kept;
  double begin_ms = clock_ms();
  TRY(counts_check(scene, log));
  TRY(lights_follow(scene, device, log));
  scene->trees_rebuilt = false;
  scene->mover_count = kept_scene_follow(kept, scene->movers, scene->source);
  if (timeline) timeline_end(timeline, "flatten what moved", begin_ms);
  if (scene->mover_count == 0) goto done;
  status = geometry_write(scene, device, log);
  if (!status && shapes_moved(kept)) status = trees_follow(scene, device, timeline, log);
  begin_ms = clock_ms();
  Status finished = device_finish(device, log);  // the host's arrays are the next move's to change
  if (timeline) timeline_end(timeline, "upload what moved", begin_ms);
  if (!status) status = finished;

done:
  return status;
}
