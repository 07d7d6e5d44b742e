// Small glTF files made by tests, and reading them.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "scene/gltf_motion.h"

// A file in the making: a BIN chunk with its views and accessors. Zero-initialised.
typedef struct GltfBuild {
  uint8_t bin[1 << 14];
  size_t bin_bytes;
  int view_count, accessor_count;
  char views[1 << 13], accessors[1 << 13];
} GltfBuild;

// In all JSON text below, ' stands for ".

// Adds bytes as a buffer view (from a multiple of four on), with a byteStride where it is not 0; returns its index.
int gltf_view(GltfBuild *build, const void *bytes, size_t size, int stride);

// Adds an accessor given as JSON; returns its index.
int gltf_accessor(GltfBuild *build, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Adds `count` elements as a view and an accessor; `more` is further JSON, such as ",'normalized':true".
int gltf_array(GltfBuild *build, int component_type, const char *type, const void *bytes, size_t size, int count,
               const char *more);

// The same for floats given in place.
#define GLTF_FLOATS(build, type, count, ...) \
  gltf_array(build, 5126, type, (const float[]){__VA_ARGS__}, sizeof(float[]){__VA_ARGS__}, count, "")

// Writes a GLB whose root members besides asset, buffers, bufferViews and accessors are given; returns its path, which
// lives until the next call.
const char *gltf_save(const GltfBuild *build, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Writes a file into the test's folder, as it is (' stays); returns its path, which lives until the next call.
const char *gltf_save_bytes(const char *name, const void *bytes, size_t size);

// Writes a .gltf of the whole text given; returns its path.
const char *gltf_save_text(const char *format, ...) __attribute__((format(printf, 1, 2)));

// A 2 x 1 PNG: red, then (0, 128, 255).
extern const uint8_t gltf_png[];
extern const size_t gltf_png_bytes;

// What each test needs: a temporary folder, the image helper, a log. For cmocka's group set-up and tear-down.
extern char gltf_folder[];
extern GltfOptions gltf_options;  // reset by each read
extern char gltf_warnings[4096];  // of the last read, one a line
int gltf_tests_begin(void **state);
int gltf_tests_end(void **state);

// Reads a file that must be fine; the caller frees the scene.
Scene gltf_read_fine(const char *path);

// Reads a file that must fail with this status and a message that starts with the file's folder and holds `message`.
void gltf_read_fails(const char *path, Status expected, const char *message);

// Opens a file whose animation (a name, an index or NULL) must be fine; the caller closes it and frees the scene.
GltfMotion *gltf_motion_fine(Scene *scene, const char *path, const char *animation);

// Opens one that must fail, as gltf_read_fails.
void gltf_motion_fails(const char *path, const char *animation, Status expected, const char *message);

// Poses a scene at a time, which must do; or must not, with this status.
void gltf_pose_fine(GltfMotion *motion, Scene *scene, double time_s);
void gltf_pose_fails(GltfMotion *motion, Scene *scene, double time_s, Status expected, const char *message);

// Closes it and frees the scene that it poses.
void gltf_motion_end(GltfMotion *motion, Scene *scene);

// Folder of the shared assets; NULL, and a line on stderr, where they are not there.
const char *gltf_assets(void);

// A scene of one node that draws mesh 0, and the positions of a triangle in the plane z = 0, for building files.
#define ONE_NODE "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'name':'thing','mesh':0}]"
#define TRIANGLE 0, 0, 0, 1, 0, 0, 0, 1, 0

// The same as accessor 0, and two morph targets that push it along X and Y as 1 and 2; a mesh of these.
GltfBuild gltf_targets_build(void);
#define GLTF_MORPHED_TRIANGLE                                                                              \
  "'meshes':[{'weights':[0.5,0.25],'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':1},{" \
  "'POSITION':2}]}]}]"

// A channel of an animation.
#define GLTF_TRACK(sampler, node, path) "{'sampler':" #sampler ",'target':{'node':" #node ",'path':'" path "'}}"

// Fail unless equal within 1e-5, relative where the number is above 1.
void assert_near(double got, double expected);
void assert_vec3(Vec3 got, double x, double y, double z);
void assert_floats(const float *got, int count, const float *expected);
#define ASSERT_FLOATS(got, ...) \
  assert_floats(got, (int)(sizeof(float[]){__VA_ARGS__} / sizeof(float)), (const float[]){__VA_ARGS__})

// World position of a point of an object.
Vec3 gltf_object_point(const Scene *scene, uint32_t object, double x, double y, double z);
