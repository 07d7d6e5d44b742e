// Makes a seed of a few kilobytes of a scene: all that its JSON says, with accessors of three elements, all zero, and
// images of two pixels.
//
// Usage: shrink_scene SCENE.glb SEED.glb

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/gltf_build.h"

enum { HEADER_WORDS = 5, BIN_BYTES = 72 + 192 };

static void set(json_t *object, const char *key, size_t value)
{
  json_object_set_new(object, key, json_integer((json_int_t)value));
}

static void scene_shrink(json_t *scene)
{
  size_t i;
  json_t *entry, *views = json_object_get(scene, "bufferViews");
  json_object_set_new(scene, "buffers", json_pack("[{s:i}]", "byteLength", BIN_BYTES));
  json_array_foreach(views, i, entry)
  {
    json_object_clear(entry);
    set(entry, "buffer", 0);
    set(entry, "byteOffset", gltf_png_bytes);
    set(entry, "byteLength", BIN_BYTES - gltf_png_bytes);
  }
  json_array_foreach(json_object_get(scene, "images"), i, entry)
  {
    json_t *view = json_array_get(views, (size_t)json_integer_value(json_object_get(entry, "bufferView")));
    set(view, "byteOffset", 0);
    set(view, "byteLength", gltf_png_bytes);
  }
  json_array_foreach(json_object_get(scene, "accessors"), i, entry)
  {
    json_object_del(entry, "byteOffset");
    json_object_del(entry, "min");
    json_object_del(entry, "max");
    set(entry, "count", 3);
  }
}

int main(int argc, char **argv)
{
  uint32_t header[HEADER_WORDS];
  uint8_t bin[BIN_BYTES] = {0};
  FILE *in = argc == 3 ? fopen(argv[1], "rb") : NULL, *out = in ? fopen(argv[2], "wb") : NULL;
  if (!out || fread(header, sizeof header, 1, in) != 1)
    return fputs("usage: shrink_scene SCENE.glb SEED.glb\n", stderr), 2;
  char *text = calloc(header[3] + 1, 1);
  if (fread(text, 1, header[3], in) != header[3]) return 1;
  json_t *scene = json_loads(text, 0, NULL);
  if (!scene) return 1;
  scene_shrink(scene);
  char *json = json_dumps(scene, JSON_COMPACT);
  int json_bytes = (int)(strlen(json) + 3) & ~3;
  memcpy(bin, gltf_png, gltf_png_bytes);
  header[2] = 28 + (uint32_t)json_bytes + BIN_BYTES;
  header[3] = (uint32_t)json_bytes;
  const uint32_t bin_header[2] = {BIN_BYTES, 0x004e4942};
  fwrite(header, sizeof header, 1, out);
  fprintf(out, "%-*s", json_bytes, json);
  fwrite(bin_header, sizeof bin_header, 1, out);
  fwrite(bin, sizeof bin, 1, out);
  free(json);
  free(text);
  json_decref(scene);
  fclose(in);
  return fclose(out) != 0;
}
