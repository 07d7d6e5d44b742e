// libFuzzer on the glTF import: whatever a file holds, it is read and posed, or not, leaks nothing and says why.
//
// An input is a file, .glb or .gltf, as it is.

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "accel/bvh.h"
#include "accel/bvh_validate.h"
#include "base/parallel.h"
#include "device_scene/flat_scene.h"
#include "image/helper/signature.h"
#include "scene/gltf_motion.h"
#include "scene/scene_defaults.h"

enum { MAX_MEMORY_BYTES = 1 << 26, MAX_PIXELS = 1 << 20, HEADER_BYTES = 20, BIN_HEADER_BYTES = 8 };

size_t LLVMFuzzerMutate(unsigned char *data, size_t size, size_t max_size);

static char folder[] = "/tmp/fuzz_gltf_XXXXXX", path[64], beside[64];

static void file_save(const char *name, const void *bytes, size_t size)
{
  FILE *file = fopen(name, "wb");
  if (!file || fwrite(bytes, 1, size, file) != size || fclose(file) != 0) abort();
}

static void folder_remove(void)
{
  unlink(path);
  unlink(beside);
  rmdir(folder);
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  static const unsigned char bytes[256] = {0, 1, 2, 3};
  parallel_set_threads(1);
  if (!mkdtemp(folder)) abort();
  snprintf(path, sizeof path, "%s/x.glb", folder);
  snprintf(beside, sizeof beside, "%s/a", folder);  // what a URI may name
  file_save(beside, bytes, sizeof bytes);
  atexit(folder_remove);
  return 0;
}

// Stands in for the image helper's decoding.
Status __wrap_image_read(Image *out, ImageHelper *helper, ImageKind kind, const char *name, const void *bytes,
                         size_t size, Log *log)
{
  ImageFormat format;
  if (!bytes) return log_fail(log, STATUS_BAD_IMAGE, "%s: is a file: hold it in memory", name);
  Status status = signature_check(&format, bytes, size, MAX_PIXELS, log);
  if (status) return status;
  *out = (Image){.width = 1, .height = 1, .texels = calloc(1, 4)};
  return out->texels ? STATUS_OK : log_no_memory(log, name);
}

static void le32(unsigned char *at, size_t value)
{
  for (int i = 0; i < 4; i++) at[i] = (unsigned char)(value >> 8 * i);
}

// Makes the container whole again: its chunks meet at the word BIN, wherever that is now.
static size_t glb_mend(unsigned char *data, size_t size, size_t max_size)
{
  unsigned char *bin = size > HEADER_BYTES ? memmem(data + HEADER_BYTES, size - HEADER_BYTES, "BIN", 4) : NULL;
  size_t json_end = bin && bin - data >= HEADER_BYTES + 4 ? (size_t)(bin - data) - 4 : size, pad = -json_end & 3;
  if (size + pad > max_size) return size;
  memmove(data + json_end + pad, data + json_end, size - json_end);
  memset(data + json_end, ' ', pad);
  size += pad;
  le32(data + 8, size);
  le32(data + 12, json_end + pad - HEADER_BYTES);
  if (json_end + pad < size) le32(data + json_end + pad, size - json_end - pad - BIN_HEADER_BYTES);
  return size;
}

size_t LLVMFuzzerCustomMutator(unsigned char *data, size_t size, size_t max_size, unsigned seed)
{
  bool is_glb = size > HEADER_BYTES && memcmp(data, "glTF", 4) == 0;
  size = LLVMFuzzerMutate(data, size, max_size);
  return is_glb && size > HEADER_BYTES && seed % 16 ? glb_mend(data, size, max_size) : size;
}

static void drop(void *context, LogLevel level, const char *message)
{
  if (strlen(message) == 0) abort();
}

// What the rest of the program relies on.
static void scene_check(const Scene *scene)
{
  for (uint32_t m = 0; m < scene->mesh_count; m++) {
    for (uint32_t p = 0; p < scene->meshes[m].primitive_count; p++) {
      const Primitive *primitive = &scene->meshes[m].primitives[p];
      if (primitive->material < 0 || (uint32_t)primitive->material >= scene->material_count) abort();
      for (uint32_t i = 0; i < primitive->triangle_count; i++)
        for (int corner = 0; corner < 3; corner++)
          if (primitive->triangles[i][corner] >= primitive->vertex_count) abort();
      for (uint32_t i = 0; i < primitive->vertex_count; i++)
        for (int c = 0; c < 3; c++)
          if (!isfinite(primitive->positions[i][c]) || !isfinite(primitive->normals[i][c])) abort();
    }
  }
  for (uint32_t o = 0; o < scene->object_count; o++)
    if (scene->objects[o].mesh < 0 || (uint32_t)scene->objects[o].mesh >= scene->mesh_count) abort();
}

// On to the arrays and trees that a device is given.
static Status scene_flatten(const Scene *scene, Log *log)
{
  static const BvhOptions bvh_options = {.max_leaf = 4, .traversal_cost = 1};
  Status status = STATUS_OK;
  FlatScene flat = {0};
  Bvh2 bvh2 = {0};
  Bvh8 bvh8 = {0};
  uint32_t(*triples)[3] = NULL;
  TRY(flat_scene_make(&flat, scene, log));
  triples = calloc(flat.triangle_count + 1, sizeof *triples);
  for (uint32_t i = 0; i < flat.triangle_count; i++) memcpy(triples[i], flat.corners[i].vertex, sizeof triples[i]);
  TriangleSoup soup = {.positions = (const float(*)[3])flat.positions,
                       .triangles = (const uint32_t(*)[3])triples,
                       .flags = flat.flags,
                       .vertex_count = flat.vertex_count,
                       .triangle_count = flat.triangle_count};
  TRY(bvh2_build(&bvh2, &soup, &bvh_options, log));
  TRY(bvh8_from_bvh2(&bvh8, &bvh2, log));
  if (bvh2_validate(&bvh2, &soup, bvh_options.max_leaf, log) || bvh8_validate(&bvh8, &soup, log)) abort();

done:
  bvh8_free(&bvh8);
  bvh2_free(&bvh2);
  free(triples);
  flat_scene_free(&flat);
  return status;
}

// Read and posed half-way through its first animation; where that is bad, read.
static Status scene_read(Scene *scene, Log *log)
{
  Log quiet = {.sink = drop};
  GltfOptions options = {.scene = NONE, .max_memory_bytes = MAX_MEMORY_BYTES};
  GltfMotion *motion = NULL;
  if (gltf_motion_open(&motion, scene, path, &options, NULL, NULL, &quiet)) {
    if (!strchr(quiet.error, ':')) abort();
    return gltf_read(scene, path, &options, NULL, log);
  }
  scene_check(scene);
  Status status = gltf_motion_pose(motion, scene, gltf_motion_length_s(motion) / 2, log);
  gltf_motion_close(motion);
  return status;
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size)
{
  Log log = {.sink = drop};
  Scene scene = {0};
  Camera camera;
  file_save(path, data, size);
  Status status = scene_read(&scene, &log);
  if (!status) {
    scene_check(&scene);
    status = scene_add_default_lighting(&scene, true, &log);
    if (!status) status = scene_camera_choose(&camera, &scene, NULL, 1.5, &log);
    if (!status) status = scene_flatten(&scene, &log);
  }
  if (status && !strchr(log.error, ':')) abort();
  scene_free(&scene);
  return 0;
}
