#include "support/gltf_build.h"

#include <errno.h>
#include <ftw.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

enum { TEXT_BYTES = 1 << 16 };

const uint8_t gltf_png[] = {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
                            0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01, 0x08, 0x02, 0x00, 0x00, 0x00, 0x7b,
                            0x40, 0xe8, 0xdd, 0x00, 0x00, 0x00, 0x0f, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0xf8,
                            0xcf, 0xc0, 0xc0, 0xd0, 0xf0, 0x1f, 0x00, 0x08, 0x00, 0x02, 0x7f, 0x25, 0x3e, 0xfc, 0x09,
                            0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
const size_t gltf_png_bytes = sizeof gltf_png;

char gltf_folder[] = "/tmp/test_gltf_XXXXXX";
char gltf_warnings[4096];
GltfOptions gltf_options;
static ImageHelper *helper;
static Log test_log;

static void quotes_replace(char *text)
{
  for (; *text; text++)
    if (*text == '\'') *text = '"';
}

static void text_add(char *text, size_t size, const char *format, ...) __attribute__((format(printf, 3, 4)));
static void text_add(char *text, size_t size, const char *format, ...)
{
  va_list arguments;
  size_t length = strlen(text);
  va_start(arguments, format);
  int wrote = vsnprintf(text + length, size - length, format, arguments);
  va_end(arguments);
  assert_true(wrote >= 0 && (size_t)wrote < size - length);
}

int gltf_view(GltfBuild *build, const void *bytes, size_t size, int stride)
{
  char stride_text[32] = "";
  build->bin_bytes = (build->bin_bytes + 3) & ~(size_t)3;
  assert_true(build->bin_bytes + size <= sizeof build->bin);
  memcpy(build->bin + build->bin_bytes, bytes, size);
  if (stride) snprintf(stride_text, sizeof stride_text, ",'byteStride':%d", stride);
  text_add(build->views, sizeof build->views, "%s{'buffer':0,'byteOffset':%zu,'byteLength':%zu%s}",
           build->view_count ? "," : "", build->bin_bytes, size, stride_text);
  build->bin_bytes += size;
  return build->view_count++;
}

int gltf_accessor(GltfBuild *build, const char *format, ...)
{
  char text[1024];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  text_add(build->accessors, sizeof build->accessors, "%s%s", build->accessor_count ? "," : "", text);
  return build->accessor_count++;
}

int gltf_array(GltfBuild *build, int component_type, const char *type, const void *bytes, size_t size, int count,
               const char *more)
{
  int view = gltf_view(build, bytes, size, 0);
  return gltf_accessor(build, "{'bufferView':%d,'componentType':%d,'type':'%s','count':%d%s}", view, component_type,
                       type, count, more);
}

const char *gltf_save_bytes(const char *name, const void *bytes, size_t size)
{
  static char path[512];
  snprintf(path, sizeof path, "%s/%s", gltf_folder, name);
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, size, file), size);
  fclose(file);
  return path;
}

// With FRUGAL_KEEP_FILES, a folder, whole files are kept there as well: scripts/fuzz starts from them.
static const char *file_keep(const char *name, const void *bytes, size_t size)
{
  static int count;
  char kept[512];
  const char *to = getenv("FRUGAL_KEEP_FILES");
  if (to) {
    snprintf(kept, sizeof kept, "%s/%s_%d_%s", to, program_invocation_short_name, count++, name);
    FILE *file = fopen(kept, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
  }
  return gltf_save_bytes(name, bytes, size);
}

const char *gltf_save_text(const char *format, ...)
{
  static char text[TEXT_BYTES];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  quotes_replace(text);
  return file_keep("test.gltf", text, strlen(text));
}

const char *gltf_save(const GltfBuild *build, const char *format, ...)
{
  static char file[2 * TEXT_BYTES];
  char *json = file + 20, rest[TEXT_BYTES / 2];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(rest, sizeof rest, format, arguments);
  va_end(arguments);
  *json = 0;
  text_add(json, TEXT_BYTES,
           "{'asset':{'version':'2.0'},'buffers':[{'byteLength':%zu}],'bufferViews':[%s],'accessors':[%s]%s%s}",
           build->bin_bytes, build->views, build->accessors, *rest ? "," : "", rest);
  quotes_replace(json);
  while (strlen(json) % 4) strcat(json, " ");
  uint32_t json_bytes = (uint32_t)strlen(json), bin_bytes = (uint32_t)(build->bin_bytes + 3) & ~3u;
  uint32_t header[5] = {0x46546c67, 2, 28 + json_bytes + bin_bytes, json_bytes, 0x4e4f534a};
  uint32_t bin_header[2] = {bin_bytes, 0x004e4942};
  memcpy(file, header, sizeof header);
  memcpy(json + json_bytes, bin_header, sizeof bin_header);
  memcpy(json + json_bytes + 8, build->bin, bin_bytes);
  return file_keep("test.glb", file, header[2]);
}

static void warning_keep(void *context, LogLevel level, const char *message)
{
  text_add(gltf_warnings, sizeof gltf_warnings, "%s\n", message);
}

static void options_reset(void) { gltf_options = (GltfOptions){.scene = NONE, .max_memory_bytes = 1 << 30}; }

static void log_clear(void)
{
  test_log = (Log){.sink = warning_keep};
  gltf_warnings[0] = 0;
}

int gltf_tests_begin(void **state)
{
  options_reset();
  return mkdtemp(gltf_folder) && image_helper_start(&helper, 1 << 24, &test_log) == STATUS_OK ? 0 : -1;
}

static int file_remove(const char *path, const struct stat *info, int type, struct FTW *where) { return remove(path); }

int gltf_tests_end(void **state)
{
  image_helper_stop(helper);
  return nftw(gltf_folder, file_remove, 16, FTW_DEPTH | FTW_PHYS);
}

Scene gltf_read_fine(const char *path)
{
  Scene scene = {0};
  log_clear();
  Status status = gltf_read(&scene, path, &gltf_options, helper, &test_log);
  if (status) fail_msg("%s: status %d: %s", path, status, test_log.error);
  options_reset();
  return scene;
}

static void check_failed(Status got, Status expected, const char *message)
{
  bool hinted = strchr(test_log.error, ':') != strrchr(test_log.error, ':');
  if (got != expected || !strstr(test_log.error, message) || !hinted)
    fail_msg("status %d, not %d: '%s' without '%s'", got, expected, test_log.error, message);
}

void gltf_read_fails(const char *path, Status expected, const char *message)
{
  Scene untouched = {.object_count = 77}, scene = untouched;
  log_clear();
  check_failed(gltf_read(&scene, path, &gltf_options, helper, &test_log), expected, message);
  assert_memory_equal(&scene, &untouched, sizeof scene);
  options_reset();
}

GltfMotion *gltf_motion_fine(Scene *scene, const char *path, const char *animation)
{
  GltfMotion *motion = NULL;
  log_clear();
  Status status = gltf_motion_open(&motion, scene, path, &gltf_options, animation, helper, &test_log);
  if (status) fail_msg("%s: status %d: %s", path, status, test_log.error);
  options_reset();
  return motion;
}

void gltf_motion_fails(const char *path, const char *animation, Status expected, const char *message)
{
  Scene untouched = {.object_count = 77}, scene = untouched;
  GltfMotion *motion = NULL;
  log_clear();
  check_failed(gltf_motion_open(&motion, &scene, path, &gltf_options, animation, helper, &test_log), expected, message);
  assert_null(motion);
  assert_memory_equal(&scene, &untouched, sizeof scene);
  options_reset();
}

void gltf_pose_fine(GltfMotion *motion, Scene *scene, double time_s)
{
  log_clear();
  Status status = gltf_motion_pose(motion, scene, time_s, &test_log);
  if (status) fail_msg("at %g s: status %d: %s", time_s, status, test_log.error);
}

void gltf_pose_fails(GltfMotion *motion, Scene *scene, double time_s, Status expected, const char *message)
{
  log_clear();
  check_failed(gltf_motion_pose(motion, scene, time_s, &test_log), expected, message);
}

void gltf_motion_end(GltfMotion *motion, Scene *scene)
{
  gltf_motion_close(motion);
  scene_free(scene);
}

GltfBuild gltf_targets_build(void)
{
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  GLTF_FLOATS(&build, "VEC3", 3, 1, 0, 0, 1, 0, 0, 1, 0, 0);
  GLTF_FLOATS(&build, "VEC3", 3, 0, 1, 0, 0, 1, 0, 0, 1, 0);
  return build;
}

const char *gltf_assets(void)
{
  const char *assets = getenv("FRUGAL_ASSETS");
  if (!assets) assets = "../shared/assets";
  if (access(assets, R_OK) == 0) return assets;
  fprintf(stderr, "SKIPPED: reading the shared models: no assets\n");
  return NULL;
}

void assert_near(double got, double expected)
{
  if (!(fabs(got - expected) <= 1e-5 * fmax(1, fabs(expected)))) fail_msg("%.9g, not %.9g", got, expected);
}

void assert_vec3(Vec3 got, double x, double y, double z)
{
  assert_near(got.x, x);
  assert_near(got.y, y);
  assert_near(got.z, z);
}

void assert_floats(const float *got, int count, const float *expected)
{
  for (int i = 0; i < count; i++) assert_near(got[i], expected[i]);
}

Vec3 gltf_object_point(const Scene *scene, uint32_t object, double x, double y, double z)
{
  return mat4_point(&scene->objects[object].world_from_object, vec3(x, y, z));
}
