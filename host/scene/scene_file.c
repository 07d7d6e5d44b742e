#include "scene/scene_file.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "base/nearest.h"
#include "scene/gltf_json.h"
#include "scene/gltf_uri.h"

enum { MOST_BYTES = 16 << 20 };

const char *const scene_file_keys[] = {"$schema", "scene", "nodes", NULL};

bool scene_file_is(const char *path)
{
  size_t length = strlen(path);
  return length > 5 && strcasecmp(path + length - 5, ".json") == 0;
}

static Status document_read(SceneFile *file, Gltf *gltf)
{
  static const JsonFile kind = {"a scene file", "give it an object with \"scene\" in it, or name a .gltf or .glb file",
                                "a scene file needs three", "mend it there", JSON_REJECT_DUPLICATES};
  struct stat found;
  if (stat(file->path, &found) == 0 && found.st_size > MOST_BYTES)
    return gltf_fail(gltf, STATUS_TOO_LARGE, "name a .gltf or .glb file",
                     "is %.1f MB long, where a scene file has at most %d", 1e-6 * (double)found.st_size,
                     MOST_BYTES / 1000000);
  Status status = gltf_file_read(&gltf->file, gltf, file->path, 0);
  return status ? status : gltf_json_object(&file->document, gltf, &gltf->file, &kind);
}

Status scene_file_resolve(char **out, const SceneFile *file, const char *named, bool allow_outside, Log *log)
{
  GltfOptions options = {.allow_outside = allow_outside};
  Gltf gltf = {.path = file->path, .options = &options, .log = log};
  return gltf_path_resolve(out, &gltf, named);
}

Status scene_file_read(SceneFile *out, const char *path, bool allow_outside, Log *log)
{
  Status status = STATUS_OK;
  GltfOptions options = {0};
  Gltf gltf = {.path = path, .options = &options, .log = log};
  SceneFile file = {0};
  TRY(gltf_copy_name(&file.path, &gltf, path));
  TRY(document_read(&file, &gltf));
  const char *scene = json_string_value(json_object_get(file.document, "scene"));
  if (!scene && json_object_get(file.document, "asset")) {
    status = gltf_fail(&gltf, STATUS_BAD_SCENE, "end its name in .gltf", "is glTF, and no scene file");
    goto done;
  }
  if (!scene || !*scene) {
    status =
        gltf_fail(&gltf, STATUS_BAD_SCENE, "add \"scene\": \"file.glb\", a path from its folder", "names no scene");
    goto done;
  }
  TRY(scene_file_resolve(&file.scene_path, &file, scene, allow_outside, log));
  *out = file;
  file = (SceneFile){0};

done:
  scene_file_free(&file);
  gltf_close(&gltf);
  return status;
}

void scene_file_free(SceneFile *file)
{
  json_decref(file->document);
  free(file->path);
  free(file->scene_path);
  *file = (SceneFile){0};
}

static Status object_unknown(const Scene *scene, const SceneFile *file, const char *name, Log *log)
{
  const char **names = calloc(scene->object_count + 1, sizeof *names);
  if (!names) return log_no_memory(log, file->path);
  for (uint32_t i = 0; i < scene->object_count; i++) names[i] = scene->objects[i].name;
  const char *nearest = nearest_name(name, names);
  Status status =
      log_fail(log, STATUS_BAD_SCENE, "%s: nodes: none that draws is named '%.100s': %s%.100s%s", file->path, name,
               nearest ? "did you mean '" : "leave it out", nearest ? nearest : "", nearest ? "'?" : "");
  free(names);
  return status;
}

// Whether the objects of one node cast shadows.
static Status node_read(bool *casts_shadow, const SceneFile *file, const char *name, json_t *node, Log *log)
{
  const char *key;
  json_t *value;
  if (!json_is_object(node))
    return log_fail(log, STATUS_BAD_SCENE, "%s: nodes: '%.100s': not valid: expected {\"casts_shadow\": false}",
                    file->path, name);
  json_object_foreach(node, key, value)
  {
    if (strcmp(key, "casts_shadow") != 0)
      return log_fail(log, STATUS_BAD_SCENE, "%s: nodes: '%.100s': %.100s: no such key: did you mean 'casts_shadow'?",
                      file->path, name, key);
    if (!json_is_boolean(value))
      return log_fail(log, STATUS_BAD_SCENE, "%s: nodes: '%.100s': casts_shadow: not valid: expected true or false",
                      file->path, name);
    *casts_shadow = json_is_true(value);
  }
  return STATUS_OK;
}

Status scene_file_change(Scene *scene, const SceneFile *file, Log *log)
{
  Status status = STATUS_OK;
  json_t *nodes = json_object_get(file->document, "nodes"), *node;
  const char *name;
  if (nodes && !json_is_object(nodes))
    return log_fail(log, STATUS_BAD_SCENE, "%s: nodes: not valid: expected an object of nodes by name", file->path);
  json_object_foreach(nodes, name, node)
  {
    bool casts_shadow = true, found = false;
    TRY(node_read(&casts_shadow, file, name, node, log));
    for (uint32_t i = 0; i < scene->object_count; i++) {
      Object *object = &scene->objects[i];
      if (strcmp(object->name, name) != 0) continue;
      object->shadowless = !casts_shadow;
      found = true;
    }
    if (!found) TRY(object_unknown(scene, file, name, log));
  }

done:
  return status;
}
