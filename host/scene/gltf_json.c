#include "scene/gltf_json.h"

#include <math.h>
#include <string.h>

static const char *const known_extensions[] = {
    "EXT_mesh_gpu_instancing", "KHR_lights_punctual",   "KHR_materials_emissive_strength",
    "KHR_materials_unlit",     "KHR_mesh_quantization", "KHR_texture_transform",
};

static bool extension_is_known(const char *name)
{
  for (size_t i = 0; i < sizeof known_extensions / sizeof *known_extensions; i++)
    if (strcmp(name, known_extensions[i]) == 0) return true;
  return false;
}

// Deepest nesting of brackets outside strings; never more than one above the limit.
static int nesting_of(const char *text, size_t size)
{
  int depth = 0, deepest = 0;
  bool in_string = false;
  for (size_t i = 0; i < size && deepest <= GLTF_MAX_NESTING; i++) {
    char c = text[i];
    if (in_string) {
      if (c == '\\') i++;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > deepest) deepest = depth;
    } else if (c == '}' || c == ']') {
      depth--;
    }
  }
  return deepest;
}

Status gltf_json_object(json_t **out, Gltf *gltf, const GltfBytes *file, const JsonFile *kind)
{
  const char *text = (const char *)file->bytes;
  size_t size = file->size, blank = 0;
  json_error_t error;
  if (size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0) {
    text += 3;
    size -= 3;
  }
  while (blank < size && strchr(" \t\r\n", text[blank])) blank++;
  if (blank == size || text[blank] != '{')
    return gltf_fail(gltf, STATUS_BAD_SCENE, kind->hint, "is not %s", kind->name);
  if (size > INT32_MAX)
    return gltf_fail(gltf, STATUS_TOO_LARGE, "store its buffers in files of their own", "has over 2 GiB of JSON");
  if (nesting_of(text, size) > GLTF_MAX_NESTING)
    return gltf_fail(gltf, STATUS_BAD_SCENE, kind->nesting_hint, "JSON nested deeper than %d levels", GLTF_MAX_NESTING);
  *out = json_loadb(text, size, kind->flags, &error);
  if (!*out)
    return gltf_fail(gltf, STATUS_BAD_SCENE, kind->repair_hint, "is not valid JSON (line %d, column %d: %s)",
                     error.line, error.column, error.text);
  return STATUS_OK;
}

Status gltf_json_parse(Gltf *gltf, const GltfBytes *text)
{
  static const JsonFile kind = {"glTF", "name a .gltf or .glb file", "flatten its extras and extensions",
                                GLTF_HINT_REPAIR, 0};
  return gltf_json_object(&gltf->document, gltf, text, &kind);
}

static Status version_check(Gltf *gltf)
{
  const json_t *asset = json_object_get(gltf->document, "asset");
  const char *version = json_string_value(json_object_get(asset, "version"));
  const char *least = json_string_value(json_object_get(asset, "minVersion"));
  if (!version)
    return gltf_fail(gltf, STATUS_BAD_SCENE, "name a glTF 2.0 file", "is JSON, but not glTF (no asset.version)");
  if (strncmp(version, "2.", 2) != 0 || (least && strcmp(least, "2.0") != 0))
    return gltf_fail(gltf, STATUS_UNSUPPORTED, "convert it to glTF 2.0", "is glTF %.16s", least ? least : version);
  return STATUS_OK;
}

Status gltf_json_check_header(Gltf *gltf)
{
  size_t i;
  json_t *entry;
  Status status = version_check(gltf);
  if (status) return status;
  const json_t *required = json_object_get(gltf->document, "extensionsRequired");
  json_array_foreach(required, i, entry)
  {
    const char *name = json_string_value(entry);
    if (name && !extension_is_known(name))
      return gltf_fail(gltf, STATUS_UNSUPPORTED, "export it without that extension", "requires the extension %.64s",
                       name);
  }
  const json_t *used = json_object_get(gltf->document, "extensionsUsed");
  json_array_foreach(used, i, entry)
  {
    const char *name = json_string_value(entry);
    if (name && !extension_is_known(name))
      log_warn(gltf->log, "%s: uses the extension %.64s, which is ignored", gltf->path, name);
  }
  return STATUS_OK;
}

// The number as tinygltf reads it right, or NULL where it does already.
static json_t *number_rewritten(const json_t *number, bool in_extension)
{
  double value = json_number_value(number);
  if (json_is_real(number) && value == floor(value) && fabs(value) <= INT32_MAX) return json_integer((json_int_t)value);
  if (json_is_integer(number) && in_extension && fabs(value) > INT32_MAX) return json_real(value);
  return NULL;
}

static void prune(json_t *node, bool in_extension)
{
  const char *key;
  void *next;
  json_t *child;
  size_t i;
  if (json_is_object(node)) {
    json_object_foreach_safe(node, next, key, child)
    {
      json_t *number = json_is_number(child) ? number_rewritten(child, in_extension) : NULL;
      if (strcmp(key, "extras") == 0) {
        json_object_del(node, key);
      } else if (number) {
        json_object_set_new(node, key, number);
      } else if (strcmp(key, "extensions") == 0 && json_is_object(child)) {
        const char *name;
        void *next_name;
        json_t *extension;
        json_object_foreach_safe(child, next_name, name, extension)
        {
          if (!extension_is_known(name)) json_object_del(child, name);
        }
        prune(child, true);
      } else {
        prune(child, in_extension);
      }
    }
  } else if (json_is_array(node)) {
    json_array_foreach(node, i, child)
    {
      json_t *number = json_is_number(child) ? number_rewritten(child, in_extension) : NULL;
      if (number)
        json_array_set_new(node, i, number);
      else
        prune(child, in_extension);
    }
  }
}

void gltf_json_prune(json_t *node) { prune(node, false); }

uint64_t gltf_json_uint(const json_t *object, const char *name, uint64_t fallback)
{
  const json_t *value = json_object_get(object, name);
  return value ? (uint64_t)json_integer_value(value) : fallback;
}
