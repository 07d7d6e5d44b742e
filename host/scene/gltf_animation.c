#include "scene/gltf_animation.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/nearest.h"
#include "scene/gltf_accessors.h"
#include "scene/gltf_json.h"

static const char *const path_names[TRACK_PATH_COUNT] = {"translation", "rotation", "scale", "weights"};

static const json_t *animation_at(const Gltf *gltf, uint32_t index)
{
  return json_array_get(json_object_get(gltf->document, "animations"), index);
}

const char *gltf_animation_name(const Gltf *gltf, uint32_t index)
{
  const char *name = json_string_value(json_object_get(animation_at(gltf, index), "name"));
  return name ? name : "";
}

static Status fail_unknown(Gltf *gltf, const char *choice)
{
  Status status = STATUS_OK;
  uint32_t count = gltf->model->animation_count;
  const char **names = NULL;
  char hint[128];
  TRY(gltf_allocate(&names, gltf, count + 1ull, sizeof *names));
  for (uint32_t i = 0; i < count; i++) names[i] = gltf_animation_name(gltf, i);
  snprintf(hint, sizeof hint, "did you mean '%.64s'?", count ? nearest_name(choice, names) : "");
  if (count == 0) snprintf(hint, sizeof hint, "it has none: leave --animation out");
  status = gltf_fail(gltf, STATUS_USAGE, hint, "no animation '%.64s'", choice);

done:
  free(names);
  return status;
}

Status gltf_animation_find(uint32_t *out, Gltf *gltf, const char *choice)
{
  uint32_t count = gltf->model->animation_count;
  for (uint32_t i = 0; i < count; i++)
    if (strcmp(gltf_animation_name(gltf, i), choice) == 0) {
      *out = i;
      return STATUS_OK;
    }
  if (!name_is_index(choice)) return fail_unknown(gltf, choice);
  unsigned long index = strtoul(choice, NULL, 10);
  if (index >= count)
    return gltf_fail(gltf, STATUS_USAGE, "they are numbered from 0", "no animation %.20s: the file has %u", choice,
                     count);
  *out = (uint32_t)index;
  return STATUS_OK;
}

uint32_t gltf_target_count(const GltfModel *model, const GltfNode *node)
{
  uint32_t count = 0;
  for (uint32_t i = 0; node->mesh != NONE && i < model->meshes[node->mesh].primitive_count; i++) {
    uint32_t targets = model->meshes[node->mesh].primitives[i].target_count;
    if (targets > count) count = targets;
  }
  return count;
}

// What an animation's channels are read into, and which things of which nodes have a track already.
typedef struct ChannelWalk {
  GltfAnimation *animation;
  Gltf *gltf;
  const json_t *samplers;
  char name[96];                    // of the animation, for messages
  bool (*taken)[TRACK_PATH_COUNT];  // [node_count]
} ChannelWalk;

static Status times_read(GltfTrack *track, Gltf *gltf, int accessor)
{
  Status status = STATUS_OK;
  if (gltf->model->accessors[accessor].values.type != COMPONENT_FLOAT)
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s: accessors[%d], its times, holds no floats",
                     gltf->where, accessor);
  TRY(gltf_read_floats(&track->times_s, gltf, accessor, 1, 1, 0));
  track->key_count = (uint32_t)gltf->model->accessors[accessor].count;
  if (!(track->times_s[0] >= 0))
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s: its first key is at %g s", gltf->where,
                     (double)track->times_s[0]);
  for (uint32_t i = 1; i < track->key_count; i++)
    if (!(track->times_s[i] > track->times_s[i - 1]))
      return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s: key %u, at %g s, does not follow the one at %g s",
                       gltf->where, i, (double)track->times_s[i], (double)track->times_s[i - 1]);

done:
  return status;
}

static Status values_read(GltfTrack *track, Gltf *gltf, int accessor)
{
  const GltfAccessor *from = &gltf->model->accessors[accessor];
  uint32_t components = track->path == TRACK_WEIGHTS ? 1 : track->width;
  uint64_t count = (uint64_t)track->key_count * (track->width / components);
  if (track->interpolation == INTERPOLATION_CUBIC) count *= 3;
  if (from->values.type != COMPONENT_FLOAT && !from->normalized)
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR,
                     "%s: accessors[%d] holds integers that are not normalized", gltf->where, accessor);
  return gltf_read_floats(&track->values, gltf, accessor, components, components, count);
}

static Status track_read(GltfTrack *track, Gltf *gltf, const json_t *sampler)
{
  Status status = STATUS_OK;
  const char *interpolation = json_string_value(json_object_get(sampler, "interpolation"));
  if (interpolation && strcmp(interpolation, "STEP") == 0) track->interpolation = INTERPOLATION_STEP;
  if (interpolation && strcmp(interpolation, "CUBICSPLINE") == 0) track->interpolation = INTERPOLATION_CUBIC;
  TRY(times_read(track, gltf, (int)gltf_json_uint(sampler, "input", 0)));
  TRY(values_read(track, gltf, (int)gltf_json_uint(sampler, "output", 0)));

done:
  return status;
}

// Why a channel is not followed, or NULL.
static const char *channel_flaw(const ChannelWalk *walk, int node_index, TrackPath path)
{
  const GltfNode *node = &walk->gltf->model->nodes[node_index];
  if (path != TRACK_WEIGHTS && node->matrix) return "the node has a matrix: give it translation, rotation and scale";
  if (path == TRACK_WEIGHTS && gltf_target_count(walk->gltf->model, node) == 0) return "it draws no morph targets";
  if (walk->taken[node_index][path]) return "an earlier channel moves the same: the first counts";
  return NULL;
}

static Status channel_read(ChannelWalk *walk, size_t index, const json_t *channel)
{
  Gltf *gltf = walk->gltf;
  const json_t *target = json_object_get(channel, "target");
  const char *word = json_string_value(json_object_get(target, "path"));
  int path = 0, node = (int)gltf_json_uint(target, "node", (uint64_t)NONE);
  while (path < TRACK_PATH_COUNT && strcmp(path_names[path], word) != 0) path++;
  snprintf(gltf->where, sizeof gltf->where, "%s channels[%zu]", walk->name, index);
  if (path == TRACK_PATH_COUNT) {
    log_warn(gltf->log, "%s: %s is not followed: it moves '%.32s'", gltf->path, gltf->where, word);
    return STATUS_OK;
  }
  if (node == NONE) return STATUS_OK;
  const char *flaw = channel_flaw(walk, node, (TrackPath)path);
  if (flaw) {
    log_warn(gltf->log, "%s: %s, the %s of nodes[%d], is not followed: %s", gltf->path, gltf->where, word, node, flaw);
    return STATUS_OK;
  }
  walk->taken[node][path] = true;
  GltfTrack *track = &walk->animation->tracks[walk->animation->track_count++];
  *track = (GltfTrack){.node = node, .path = (TrackPath)path, .width = path == TRACK_ROTATION ? 4 : 3};
  if (path == TRACK_WEIGHTS) track->width = gltf_target_count(gltf->model, &gltf->model->nodes[node]);
  return track_read(track, gltf, json_array_get(walk->samplers, gltf_json_uint(channel, "sampler", 0)));
}

Status gltf_animation_read(GltfAnimation *out, Gltf *gltf, uint32_t index)
{
  Status status = STATUS_OK;
  GltfAnimation animation = {0};
  const json_t *from = animation_at(gltf, index), *channels = json_object_get(from, "channels");
  ChannelWalk walk = {.animation = &animation, .gltf = gltf, .samplers = json_object_get(from, "samplers")};
  size_t i;
  json_t *channel;
  snprintf(walk.name, sizeof walk.name, "animations[%u] '%.48s'", index, gltf_animation_name(gltf, index));
  TRY(gltf_allocate(&walk.taken, gltf, gltf->model->node_count, sizeof *walk.taken));
  TRY(gltf_allocate(&animation.tracks, gltf, json_array_size(channels), sizeof *animation.tracks));
  json_array_foreach(channels, i, channel) { TRY(channel_read(&walk, i, channel)); }
  for (uint32_t t = 0; t < animation.track_count; t++) {
    const GltfTrack *track = &animation.tracks[t];
    animation.length_s = fmax(animation.length_s, track->times_s[track->key_count - 1]);
  }
  *out = animation;
  animation = (GltfAnimation){0};

done:
  gltf->where[0] = 0;
  free(walk.taken);
  gltf_animation_free(&animation);
  return status;
}

void gltf_animation_free(GltfAnimation *animation)
{
  for (uint32_t i = 0; i < animation->track_count; i++) {
    free(animation->tracks[i].times_s);
    free(animation->tracks[i].values);
  }
  free(animation->tracks);
  *animation = (GltfAnimation){0};
}
