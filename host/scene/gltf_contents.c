#include "scene/gltf_contents.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/gltf_context.h"
#include "scene/gltf_guard.h"

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

Status gltf_contents_read(GltfContents *out, const char *path, const GltfOptions *options, Log *log)
{
  Status status = STATUS_OK;
  Log quiet = {0};
  Gltf gltf = {.path = path, .options = options, .log = &quiet};
  GltfContents contents = {0};
  char *json = NULL;
  TRY(gltf_guard(&json, &gltf));
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
  *out = contents;

done:
  if (status) log_fail(log, status, "%s", quiet.error);
  free(json);
  gltf_close(&gltf);
  return status;
}
