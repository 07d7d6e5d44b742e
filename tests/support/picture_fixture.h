// Rendering in tests: devices of each lane width, and pictures as arrays of numbers.
#pragma once

#include "render/picture.h"
#include "support/oracle_image.h"

// For cmocka's group set-up and tear-down: those of gltf_build.h, and the devices closed.
int picture_tests_begin(void **state);
int picture_tests_end(void **state);

extern Log picture_log;

// Fails the test with the log's message.
void picture_assert_ok(Status status);

// The best device with the traits of LANES 16, 8 (as for CPUs) or 1 (as for GPUs); 0: its own. Open until the end.
Device *picture_device(uint32_t lanes);

// Reads an image as radiance.
Status picture_read_image(Image *out, const char *path);

// What to render: the whole picture, by rays.
typedef struct PictureRequest {
  RenderSettings settings;
  uint32_t aovs;   // of AovName (render/picture.h)
  uint32_t lanes;  // of picture_device
  uint32_t seed;
  uint32_t wave_rays;  // rays in flight; 0: the device's own
  bool bare;           // shaded without normal maps, vertex colours, second texture coordinates: fewer kernels
} PictureRequest;

// As `frugal render` makes it of few samples: mirrors alone reflect, the environment's light is that of its harmonics.
PictureRequest picture_request(uint32_t width, uint32_t height, uint32_t samples);

enum { PICTURE_LAYERS = 24 };

// What `frugal render -o picture.exr` writes, read back.
typedef struct Picture {
  uint32_t width, height;
  float (*radiance)[4];  // linear, [height][width] from the top left; the fourth is the share that hits something
  ImageLayer layers[PICTURE_LAYERS];         // the AOVs', by the order of picture_layer_names
  uint64_t shadow_rays, shadow_rays_traced;  // that hybrid shadows judged, and left to rays
} Picture;

extern const char *const picture_layer_names[PICTURE_LAYERS];  // "depth.Z"; ends with NULL

Picture picture_render(const Scene *scene, const Camera *camera, const PictureRequest *request);
void picture_free(Picture *picture);

// An AOV's layer by its name, [height][width]; the test fails where it was not asked for or holds the other type.
const float *picture_floats(const Picture *picture, const char *name);
const uint32_t *picture_integers(const Picture *picture, const char *name);

const float *picture_pixel(const Picture *picture, uint32_t x, uint32_t y);

// Fails unless all layers are the same, bit for bit.
void picture_assert_same(const Picture *a, const Picture *b);

// Fails for a picture that could be one of nothing: all values are finite and none negative, and some two pixels differ
// by more than `contrast` in some channel.
void picture_assert_signal(const Picture *picture, double contrast);

// The request in the oracle's words.
OracleOptions picture_oracle_options(const PictureRequest *request);
