#include "scene/gltf_guard.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/gltf_json.h"
#include "scene/gltf_uri.h"

enum { GLB_HEADER_BYTES = 12, GLB_CHUNK_HEADER_BYTES = 8, GLB_JSON = 0x4e4f534a, GLB_BIN = 0x004e4942 };

static uint32_t uint32_at(const uint8_t *bytes)
{
  return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

// Splits a GLB into its JSON chunk and its BIN chunk (size 0 where it has none).
static Status glb_split(GltfBytes *json, GltfBytes *bin, Gltf *gltf)
{
  const uint8_t *file = gltf->file.bytes;
  uint64_t size = gltf->file.size, at = GLB_HEADER_BYTES;
  if (size < GLB_HEADER_BYTES + GLB_CHUNK_HEADER_BYTES || uint32_at(file + 8) > size)
    return gltf_fail(gltf, STATUS_BAD_SCENE, "copy it again", "is a GLB file that was cut off");
  if (uint32_at(file + 4) != 2)
    return gltf_fail(gltf, STATUS_UNSUPPORTED, "convert it to glTF 2.0", "is a GLB file of version %u",
                     uint32_at(file + 4));
  size = uint32_at(file + 8);
  for (int chunk = 0; at + GLB_CHUNK_HEADER_BYTES <= size; chunk++) {
    uint64_t length = uint32_at(file + at);
    uint32_t type = uint32_at(file + at + 4);
    at += GLB_CHUNK_HEADER_BYTES;
    if (length > size - at)
      return gltf_fail(gltf, STATUS_BAD_SCENE, "copy it again", "is a GLB file whose chunk %d was cut off", chunk);
    if (chunk == 0 && type == GLB_JSON) *json = (GltfBytes){.bytes = file + at, .size = length};
    if (chunk == 1 && type == GLB_BIN) *bin = (GltfBytes){.bytes = file + at, .size = length};
    at += (length + 3) & ~3ull;
  }
  if (!json->bytes) return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "is a GLB file without a JSON chunk");
  return STATUS_OK;
}

static Status buffer_load(GltfBytes *out, Gltf *gltf, size_t index, const json_t *buffer, const GltfBytes *bin)
{
  Status status = STATUS_OK;
  GltfBytes data = {0};
  char *path = NULL;
  uint64_t size = gltf_json_uint(buffer, "byteLength", 0);
  const char *uri = json_string_value(json_object_get(buffer, "uri"));
  snprintf(gltf->where, sizeof gltf->where, "buffers[%zu]", index);
  if (uri && !gltf_uri_is_data(uri)) {
    TRY(gltf_uri_resolve(&path, gltf, uri));
    TRY(gltf_file_read(&data, gltf, path, size));
  } else if (uri) {
    TRY(gltf_uri_decode_data(&data, gltf, uri));
  } else if (index == 0) {
    data = *bin;
  }
  if (data.size < size) {
    status = gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "buffers[%zu] holds %llu of its %llu bytes", index,
                       (unsigned long long)data.size, (unsigned long long)size);
    goto done;
  }
  data.size = size;
  *out = data;

done:
  free(path);
  if (status) free(data.owned);
  return status;
}

static Status buffers_load(Gltf *gltf, const GltfBytes *bin)
{
  Status status = STATUS_OK;
  size_t i;
  json_t *buffer;
  const json_t *buffers = json_object_get(gltf->document, "buffers");
  TRY(gltf_allocate(&gltf->buffers, gltf, json_array_size(buffers), sizeof *gltf->buffers));
  gltf->buffer_count = (uint32_t)json_array_size(buffers);
  json_array_foreach(buffers, i, buffer) { TRY(buffer_load(&gltf->buffers[i], gltf, i, buffer, bin)); }

done:
  gltf->where[0] = 0;
  return status;
}

static Status images_list(Gltf *gltf)
{
  Status status = STATUS_OK;
  size_t i;
  json_t *image;
  const json_t *images = json_object_get(gltf->document, "images");
  TRY(gltf_allocate(&gltf->images, gltf, json_array_size(images), sizeof *gltf->images));
  gltf->image_count = (uint32_t)json_array_size(images);
  json_array_foreach(images, i, image)
  {
    const json_t *view = json_object_get(image, "bufferView");
    gltf->images[i].view = view ? (int)json_integer_value(view) : NONE;
    gltf->images[i].uri = view ? NULL : json_string_value(json_object_get(image, "uri"));
  }

done:
  return status;
}

// The document less what the guard keeps to itself.
static Status json_write(char **out, Gltf *gltf)
{
  json_t *copy = json_copy(gltf->document);
  json_object_del(copy, "buffers");
  json_object_del(copy, "images");
  *out = json_dumps(copy, JSON_COMPACT);
  json_decref(copy);
  if (!*out) return log_no_memory(gltf->log, gltf->path);
  if (strlen(*out) <= INT32_MAX) return STATUS_OK;
  free(*out);
  *out = NULL;
  return gltf_fail(gltf, STATUS_TOO_LARGE, "split the scene", "has over 2 GiB of JSON");
}

Status gltf_guard(char **json, Gltf *gltf)
{
  Status status = STATUS_OK;
  GltfBytes text = {0}, bin = {0};
  TRY(gltf_file_read(&gltf->file, gltf, gltf->path, 0));
  if (gltf->file.size == 0) {
    status = gltf_fail(gltf, STATUS_BAD_SCENE, "name a .gltf or .glb file", "is empty");
    goto done;
  }
  text = gltf->file;
  if (gltf->file.size >= 4 && memcmp(gltf->file.bytes, "glTF", 4) == 0) {
    text = (GltfBytes){0};
    TRY(glb_split(&text, &bin, gltf));
  }
  TRY(gltf_json_parse(gltf, &text));
  TRY(gltf_json_check_header(gltf));
  gltf_json_prune(gltf->document);
  TRY(gltf_json_check_rules(gltf));
  TRY(buffers_load(gltf, &bin));
  TRY(images_list(gltf));
  TRY(gltf_check_bounds(gltf));
  TRY(gltf_check_forest(gltf));
  TRY(json_write(json, gltf));

done:
  return status;
}
