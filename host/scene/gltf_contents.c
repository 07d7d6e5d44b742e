#include "scene/gltf_contents.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/gltf_animation.h"

static uint32_t length_of(const json_t *document, const char *key)
{
  return (uint32_t)json_array_size(json_object_get(document, key));
}

static bool names(const json_t *list, const char *name)
{
  size_t i;
  json_t *item;
  json_array_foreach(list, i, item)
  {
    if (json_is_string(item) && strcmp(json_string_value(item), name) == 0) return true;
  }
  return false;
}

static void extensions_read(GltfContents *out, const json_t *document)
{
  size_t i;
  json_t *name;
  const json_t *required = json_object_get(document, "extensionsRequired");
  json_array_foreach(json_object_get(document, "extensionsUsed"), i, name)
  {
    if (!json_is_string(name) || out->extension_count == GLTF_MAX_EXTENSIONS) continue;
    snprintf(out->extensions[out->extension_count].name, sizeof out->extensions[0].name, "%s", json_string_value(name));
    out->extensions[out->extension_count++].is_required = names(required, json_string_value(name));
  }
}

static void targets_count(GltfContents *out, const json_t *document)
{
  size_t m, p;
  json_t *mesh, *primitive;
  json_array_foreach(json_object_get(document, "meshes"), m, mesh)
  {
    json_array_foreach(json_object_get(mesh, "primitives"), p, primitive)
    {
      out->morph_targets += length_of(primitive, "targets");
    }
  }
}

static void text_copy(char *out, size_t size, const json_t *object, const char *key)
{
  const char *text = json_string_value(json_object_get(object, key));
  snprintf(out, size, "%s", text ? text : "");
}

static Status animation_count(GltfAnimationContents *out, Gltf *gltf, const GltfAnimation *animation)
{
  Status status = STATUS_OK;
  bool *moves = NULL;
  TRY(gltf_allocate(&moves, gltf, gltf->model->node_count, sizeof *moves));
  for (uint32_t i = 0; i < animation->track_count; i++) {
    const GltfTrack *track = &animation->tracks[i];
    out->morph_count += track->path == TRACK_WEIGHTS;
    out->node_count += track->path != TRACK_WEIGHTS && !moves[track->node];
    moves[track->node] |= track->path != TRACK_WEIGHTS;
  }
  out->is_fine = true;
  out->length_s = animation->length_s;

done:
  free(moves);
  return status;
}

// A bad animation is a warning to `log`: the file can be drawn without it.
static Status animations_read(GltfContents *out, Gltf *gltf, Log *log)
{
  Status status = STATUS_OK;
  Log *failures = gltf->log;
  TRY(gltf_allocate(&out->animation_list, gltf, out->animations, sizeof *out->animation_list));
  uint64_t used_bytes = gltf->used_bytes;
  for (uint32_t i = 0; i < out->animations; i++) {
    GltfAnimation animation = {0};
    GltfAnimationContents *contents = &out->animation_list[i];
    Log own = {.sink = log->sink, .context = log->context};
    gltf->log = &own;
    gltf->used_bytes = used_bytes;
    snprintf(contents->name, sizeof contents->name, "%s", gltf_animation_name(gltf, i));
    status = gltf_animation_read(&animation, gltf, i);
    if (!status) status = animation_count(contents, gltf, &animation);
    gltf_animation_free(&animation);
    if (status == STATUS_BAD_SCENE)
      log_warn(log, "%s", own.error);
    else if (status)
      return log_fail(failures, status, "%s", own.error);
  }
  status = STATUS_OK;

done:
  return status;
}

Status gltf_contents_read(GltfContents *out, const char *path, const GltfOptions *options, Log *log)
{
  Status status = STATUS_OK;
  Log quiet = {0};
  Gltf gltf = {.path = path, .options = options, .log = &quiet};
  GltfContents contents = {0};
  TRY(gltf_open(&gltf));
  const json_t *document = gltf.document, *asset = json_object_get(document, "asset");
  const json_t *extensions = json_object_get(document, "extensions");
  struct {
    uint32_t *count;
    const char *key;
  } lists[] = {
      {&contents.scenes, "scenes"},       {&contents.nodes, "nodes"},       {&contents.meshes, "meshes"},
      {&contents.materials, "materials"}, {&contents.textures, "textures"}, {&contents.images, "images"},
      {&contents.cameras, "cameras"},     {&contents.skins, "skins"},       {&contents.animations, "animations"},
  };
  for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) *lists[i].count = length_of(document, lists[i].key);
  contents.lights = length_of(json_object_get(extensions, "KHR_lights_punctual"), "lights");
  text_copy(contents.version, sizeof contents.version, asset, "version");
  text_copy(contents.generator, sizeof contents.generator, asset, "generator");
  for (uint32_t i = 0; i < gltf.buffer_count; i++) contents.buffer_bytes += gltf.buffers[i].size;
  extensions_read(&contents, document);
  targets_count(&contents, document);
  TRY(animations_read(&contents, &gltf, log));
  *out = contents;
  contents.animation_list = NULL;

done:
  if (status) log_fail(log, status, "%s", quiet.error);
  gltf_contents_free(&contents);
  gltf_close(&gltf);
  return status;
}

void gltf_contents_free(GltfContents *contents)
{
  free(contents->animation_list);
  *contents = (GltfContents){0};
}
