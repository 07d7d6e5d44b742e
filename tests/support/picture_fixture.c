#include "support/picture_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/effort.h"
#include "support/gltf_build.h"
#include "support/test_device.h"

enum { DEVICES = 4 };

Log picture_log;
static ImageHelper *images;
static Device *devices[DEVICES];  // by lanes: 0 the device's own, then 16, 8, 1

static const DeviceTraits traits_by_lanes[DEVICES] = {
    {0},
    {.lanes = 16, .rays_per_item = 64, .group_size = 1, .wave_rays = 1u << 18, .wide_bvh = true},
    {.lanes = 8, .rays_per_item = 64, .group_size = 1, .wave_rays = 1u << 18, .wide_bvh = true},
    {.lanes = 1, .rays_per_item = 1, .group_size = 64, .wave_rays = 1u << 20, .wide_bvh = false},
};

int picture_tests_begin(void **state)
{
  if (gltf_tests_begin(state)) return -1;
  return image_helper_start(&images, 1 << 24, &picture_log) == STATUS_OK ? 0 : -1;
}

int picture_tests_end(void **state)
{
  for (int i = 0; i < DEVICES; i++) device_close(devices[i]);
  image_helper_stop(images);
  return gltf_tests_end(state);
}

void picture_assert_ok(Status status)
{
  if (status) fail_msg("status %d: %s", status, picture_log.error);
}

Device *picture_device(uint32_t lanes)
{
  int at = 0;
  // A slow build looks at the host, for which widths of 8 and 16 are alike.
  if (test_on_gpu() || (effort_is_quick() && lanes == 8)) lanes = traits_by_lanes[0].lanes;
  while (at < DEVICES && traits_by_lanes[at].lanes != lanes) at++;
  assert_int_not_equal(at, DEVICES);
  if (devices[at]) return devices[at];
  picture_assert_ok(device_open(&devices[at], test_device(), 0, NULL, &picture_log));
  if (at) {
    DeviceTraits traits = traits_by_lanes[at];
    traits.fast_fma = device_traits(devices[at])->fast_fma;  // bytes hang on it
    device_override_traits(devices[at], &traits);
  }
  return devices[at];
}

Status picture_read_image(Image *out, const char *path)
{
  return image_read(out, images, IMAGE_RADIANCE, path, NULL, 0, &picture_log);
}

PictureRequest picture_request(uint32_t width, uint32_t height, uint32_t samples)
{
  return (PictureRequest){.settings = {.width = width,
                                       .height = height,
                                       .samples = samples,
                                       .shadows = SHADOWS_RAYS,
                                       .shadow_options = {.kernel_px = 3},
                                       .reflections = REFLECTIONS_RAYS,
                                       .environment_light = ENVIRONMENT_LIGHT_SH,
                                       .max_depth = 8,
                                       .ambient = 0.05f}};
}

// Renders to the file at `path`.
static Status picture_save(Picture *out, const char *path, const Scene *scene, const Camera *camera,
                           const PictureRequest *request)
{
  Status status = STATUS_OK;
  DeviceScene device_scene = {0};
  Frame frame = {0};
  const RenderSettings *settings = &request->settings;
  Device *device = picture_device(request->lanes);
  const DeviceTraits traits = *device_traits(device);
  if (request->wave_rays) {
    DeviceTraits other = traits;
    other.wave_rays = request->wave_rays;
    other.lean_waves = 1;
    device_override_traits(device, &other);
  }
  TRY(device_scene_make(&device_scene, device, scene, NULL, &picture_log));
  if (request->bare) device_scene.has_normal_maps = device_scene.has_second_uvs = device_scene.has_colors = false;
  SceneFacts facts = {.light_count = device_scene.light_count,
                      .has_mirrors = device_scene.has_mirrors,
                      .has_blends = device_scene.has_blends,
                      .least_roughness = device_scene.least_roughness,
                      .environment_lights = device_scene.environment_lights};
  FrameRequest frame_request = {.camera = camera,
                                .area = {settings->width, settings->height, 0, 0, settings->width, settings->height},
                                .samples = settings->samples,
                                .plan = plan_make(settings, &facts),
                                .seed = request->seed,
                                .aovs = aov_set_of(request->aovs)};
  PictureOptions options = {.aovs = request->aovs, .bit_depth = 8, .quality = 95, .compression = "none"};
  TRY(frame_make(&frame, device, &device_scene, &frame_request, &picture_log));
  TRY(frame_render(&frame, &picture_log));
  out->shadow_rays = frame.shadow_hybrid.rays;
  out->shadow_rays_traced = frame.shadow_hybrid.traced;
  TRY(picture_write(&frame, &options, images, path, "exr", &picture_log));

done:
  frame_free(&frame);
  device_scene_free(&device_scene);
  device_override_traits(device, &traits);
  return status;
}

const char *const picture_layer_names[PICTURE_LAYERS] = {
    "depth.Z",     "position.X", "position.Y",   "position.Z",   "normal.X",     "normal.Y",
    "normal.Z",    "albedo.R",   "albedo.G",     "albedo.B",     "object.id",    "primitive.id",
    "material.id", "shadow.Y",   "reflection.R", "reflection.G", "reflection.B",
};

// AovName bit of a layer: names begin alike and in the same order.
static uint32_t aov_of_layer(const char *name)
{
  static const char *const aovs[] = {"depth.",     "position.", "normal.", "albedo.",     "object.",
                                     "primitive.", "material.", "shadow.", "reflection.", NULL};
  for (int i = 0; aovs[i]; i++)
    if (!strncmp(aovs[i], name, strlen(aovs[i]))) return 1u << i;
  return 0;
}

static void layer_read(ImageLayer *out, const char *path, const char *name, const RenderSettings *settings)
{
  picture_assert_ok(image_read_layer(out, images, path, name, &picture_log));
  assert_int_equal(out->width, settings->width);
  assert_int_equal(out->height, settings->height);
}

Picture picture_render(const Scene *scene, const Camera *camera, const PictureRequest *request)
{
  char path[512];
  const RenderSettings *settings = &request->settings;
  Picture picture = {.width = settings->width, .height = settings->height};
  ImageLayer color;
  snprintf(path, sizeof path, "%s/picture.exr", gltf_folder);
  picture_log = (Log){0};
  picture_assert_ok(picture_save(&picture, path, scene, camera, request));
  layer_read(&color, path, NULL, settings);
  assert_true(color.channels == 4 && color.element == IMAGE_FLOAT && !color.is_display);
  picture.radiance = color.values;
  for (int i = 0; picture_layer_names[i]; i++)
    if (request->aovs & aov_of_layer(picture_layer_names[i]))
      layer_read(&picture.layers[i], path, picture_layer_names[i], settings);
  return picture;
}

void picture_free(Picture *picture)
{
  for (int i = 0; i < PICTURE_LAYERS; i++) image_layer_free(&picture->layers[i]);
  free(picture->radiance);
  *picture = (Picture){0};
}

static const void *layer_values(const Picture *picture, const char *name, ImageElement element)
{
  int at = 0;
  while (picture_layer_names[at] && strcmp(picture_layer_names[at], name) != 0) at++;
  const ImageLayer *layer = &picture->layers[at];
  if (!layer->values || layer->element != element) fail_msg("no layer '%s', or of another type", name);
  return layer->values;
}

const float *picture_floats(const Picture *picture, const char *name)
{
  return layer_values(picture, name, IMAGE_FLOAT);
}

const uint32_t *picture_integers(const Picture *picture, const char *name)
{
  return layer_values(picture, name, IMAGE_UINT32);
}

const float *picture_pixel(const Picture *picture, uint32_t x, uint32_t y)
{
  assert_true(x < picture->width && y < picture->height);
  return picture->radiance[(size_t)y * picture->width + x];
}

void picture_assert_same(const Picture *a, const Picture *b)
{
  size_t pixels = (size_t)a->width * a->height;
  assert_memory_equal(a->radiance, b->radiance, pixels * sizeof *a->radiance);
  for (int i = 0; picture_layer_names[i]; i++)
    if (a->layers[i].values && memcmp(a->layers[i].values, b->layers[i].values, pixels * sizeof(float)) != 0)
      fail_msg("%s differs", picture_layer_names[i]);
}

void picture_assert_signal(const Picture *picture, double contrast)
{
  double widest = 0;
  for (int channel = 0; channel < 3; channel++) {
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < (size_t)picture->width * picture->height; i++) {
      double value = picture->radiance[i][channel];
      if (!isfinite(value) || value < 0)
        fail_msg("pixel (%zu, %zu) is %g", i % picture->width, i / picture->width, value);
      low = fmin(low, value);
      high = fmax(high, value);
    }
    widest = fmax(widest, high - low);
  }
  if (!(widest > contrast)) fail_msg("no pixels differ by more than %g", widest);
}

OracleOptions picture_oracle_options(const PictureRequest *request)
{
  const RenderSettings *settings = &request->settings;
  OracleOptions options = oracle_options(settings->width, settings->height, settings->samples);
  options.model = settings->lighting == LIGHTING_PHONG ? ORACLE_PHONG : ORACLE_PBR;
  options.ambient = settings->ambient;
  options.max_depth = settings->reflections == REFLECTIONS_NONE ? 0 : settings->max_depth;
  options.cast_shadows = settings->shadows == SHADOWS_RAYS;
  return options;
}
