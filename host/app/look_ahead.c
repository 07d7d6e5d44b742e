#include "app/look_ahead.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "passes/movers.h"
#include "passes/shadow_fit.h"

enum { STEPS = 8 };  // from a frame to the next, at equal distances in the sequence, that are looked at

// An object as it stands; without finite bounds low is higher than high.
typedef struct Placed {
  Mat4 world_from_object;
  Vec3 low, high;  // world space
} Placed;

// What the maps of a frame depend on.
typedef struct Pose {
  CameraInfo camera;
  uint64_t *shapes;  // [mesh_count], sums of positions
  Placed *objects;   // [object_count]
  ShadowFit *fits;   // [light_count]
} Pose;

// FNV-1a, by words.
static uint64_t mesh_sum(const Mesh *mesh)
{
  uint64_t sum = 0xcbf29ce484222325u;
  for (uint32_t p = 0; p < mesh->primitive_count; p++) {
    const Primitive *primitive = &mesh->primitives[p];
    for (uint32_t v = 0; v < primitive->vertex_count; v++) {
      uint32_t words[3];
      memcpy(words, primitive->positions[v], sizeof words);
      for (int i = 0; i < 3; i++) sum = (sum ^ words[i]) * 0x100000001b3u;
    }
  }
  return sum;
}

static Status pose_make(Pose *out, const Scene *scene, Log *log)
{
  *out = (Pose){.shapes = calloc(scene->mesh_count + 1ull, sizeof *out->shapes),
                .objects = calloc(scene->object_count + 1ull, sizeof *out->objects),
                .fits = calloc(scene->light_count + 1ull, sizeof *out->fits)};
  return out->shapes && out->objects && out->fits ? STATUS_OK : log_no_memory(log, scene->path);
}

static void pose_free(Pose *pose)
{
  free(pose->shapes);
  free(pose->objects);
  free(pose->fits);
}

static bool object_moved(const Pose *a, const Pose *b, const Scene *scene, uint32_t object)
{
  const int mesh = scene->objects[object].mesh;
  const Mat4 *m = &a->objects[object].world_from_object, *n = &b->objects[object].world_from_object;
  return memcmp(m, n, sizeof *m) != 0 || a->shapes[mesh] != b->shapes[mesh];
}

// Where all objects are, `last` of which have bounds already.
static ShadowScope objects_place(Pose *pose, const Pose *last, const Scene *scene)
{
  const Vec3 far = vec3(INFINITY, INFINITY, INFINITY);
  ShadowScope scope = {&pose->camera, far, vec3_neg(far)};
  for (uint32_t i = 0; i < scene->mesh_count; i++) pose->shapes[i] = mesh_sum(&scene->meshes[i]);
  for (uint32_t i = 0; i < scene->object_count; i++) {
    Placed *object = &pose->objects[i];
    *object = (Placed){scene->objects[i].world_from_object, far, vec3_neg(far)};
    if (last && !object_moved(pose, last, scene, i))
      *object = last->objects[i];
    else
      scene_object_bounds(scene, i, &object->low, &object->high);
    scope.low = vec3_min(scope.low, object->low);
    scope.high = vec3_max(scope.high, object->high);
  }
  return scope;
}

// Poses the scene at a frame.
static Status pose_take(Pose *pose, const Pose *last, Run *run, uint32_t frame, Log *log)
{
  Status status = STATUS_OK;
  const Scene *scene = &run->scene;
  const PictureArea area = render_area(&run->options);
  Camera camera;
  LightInfo *lights = calloc(scene->light_count + 1ull, sizeof *lights);
  if (!lights) return log_no_memory(log, scene->path);
  TRY(gltf_motion_pose(run->motion, &run->scene, frame / (double)run->options.fps, log));
  TRY(run_camera(&camera, run));
  pose->camera = camera_info(&camera, &area);
  const ShadowScope scope = objects_place(pose, last, scene);
  flat_lights_fill(lights, scene);
  for (uint32_t i = 0; i < scene->light_count; i++)
    if (!shadow_fit(&pose->fits[i], &lights[i], SHADOWS_HYBRID, &run->options.settings.shadow_options, &scope))
      pose->fits[i].info.view_count = 0;

done:
  free(lights);
  return status;
}

// Views of maps, by kind of light.
typedef struct Views {
  uint64_t all[SHADOW_LIGHT_KINDS], kept[SHADOW_LIGHT_KINDS];
} Views;

// Counts the views of a frame that see what they saw in the frame before: none from a camera that moved, as maps are
// drawn where receivers are seen.
static void views_count(Views *views, const Pose *before, const Pose *now, const DeviceScene *moved)
{
  const bool still = memcmp(&before->camera, &now->camera, sizeof now->camera) == 0;
  for (uint32_t i = 0; i < moved->source->light_count; i++) {
    const ShadowFit *fit = &now->fits[i], *then = &before->fits[i];
    const LightKind kind = moved->source->lights[i].kind;
    const bool same = still && memcmp(&fit->info, &then->info, sizeof fit->info) == 0;
    views->all[kind] += fit->info.view_count;
    for (uint32_t view = 0; same && view < fit->info.view_count; view++)
      views->kept[kind] += memcmp(&fit->views[view], &then->views[view], sizeof *fit->views) == 0 &&
                           !movers_seen(moved, &fit->views[view].raster);
  }
}

static void movers_find(DeviceScene *moved, const Pose *before, const Pose *now)
{
  moved->mover_count = 0;
  for (uint32_t i = 0; i < moved->source->object_count; i++) {
    const Placed *a = &before->objects[i], *b = &now->objects[i];
    if (object_moved(before, now, moved->source, i))
      moved->movers[moved->mover_count++] = (Mover){i, vec3_min(a->low, b->low), vec3_max(a->high, b->high)};
  }
}

static Status steps_look(Views *views, Run *run, uint32_t frames)
{
  Status status = STATUS_OK;
  const uint32_t steps = frames - 1 < STEPS ? frames - 1 : STEPS;
  Pose before = {0}, now = {0};
  DeviceScene moved = {.source = &run->scene};
  Log unheard = {0};  // who renders that frame is told
  moved.movers = calloc(run->scene.object_count + 1ull, sizeof *moved.movers);
  if (!moved.movers) return log_no_memory(run->log, run->scene.path);
  TRY(pose_make(&before, &run->scene, run->log));
  TRY(pose_make(&now, &run->scene, run->log));
  bool posed = true;
  for (uint32_t i = 0; i < steps; i++) {
    const uint32_t frame = (uint32_t)((uint64_t)i * (frames - 1) / steps);
    posed = !pose_take(&before, i ? &now : NULL, run, frame, &unheard) &&
            !pose_take(&now, &before, run, frame + 1, &unheard);
    if (!posed) break;
    movers_find(&moved, &before, &now);
    views_count(views, &before, &now, &moved);
  }
  if (!posed) memset(views->kept, 0, sizeof views->kept);

done:
  free(moved.movers);
  pose_free(&before);
  pose_free(&now);
  return status;
}

static bool chooses_itself(const RenderSettings *settings, uint32_t light_count)
{
  if (!settings->light_shadows) return settings->shadows == SHADOWS_AUTO;
  for (uint32_t i = 0; i < light_count; i++)
    if (settings->light_shadows[i] == SHADOWS_AUTO) return true;
  return false;
}

Status look_ahead(Run *run)
{
  Status status = STATUS_OK;
  SequenceFacts *sequence = &run->sequence;
  Views views = {0};
  const double begin_ms = clock_ms(), length_s = run->motion ? gltf_motion_length_s(run->motion) : 0;
  if (!run->motion || !chooses_itself(&run->options.settings, run->scene.light_count)) return STATUS_OK;
  sequence->frames =
      length_s > 0 ? 1 + frames_last(length_s, (double)run->options.fps) : (uint32_t)frames_count(&run->options.frames);
  if (length_s > 0 && sequence->frames > 1) TRY(steps_look(&views, run, sequence->frames));
  for (int kind = 0; kind < SHADOW_LIGHT_KINDS; kind++) {
    const double all = (double)views.all[kind];
    sequence->kept[kind] = length_s > 0 ? (double)views.kept[kind] / fmax(all, 1) : 1;
  }
  timeline_end(&run->timeline, "look ahead", begin_ms);

done:
  return status;
}
