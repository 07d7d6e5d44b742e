// Kernels are told of a scene all that their code looks at (SceneUse): one that is not would trace or shade as if
// masks, textures or glass were not there.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "device/kernel_source.h"
#include "passes/near_trace.h"
#include "passes/raster_depth.h"
#include "render/frame.h"
#include "support/kernel_text.h"
#include "support/picture_fixture.h"
#include "support/scene_features.h"
#include "support/test_device.h"

// A build that was asked for.
typedef struct Asked {
  const char *path;
  char options[512];
} Asked;
enum { ASKED_MOST = 64 };
static Asked asked[ASKED_MOST];
static int asked_count;

// In the linker's place (Makefile): nothing is compiled, and nothing runs.
Status __wrap_program_build(Program **out, Device *device, const char *path, const char *options, Log *log);
Status __wrap_program_kernel(Kernel *out, const Program *program, const char *name, Log *log);
Status __wrap_device_launch(Device *device, const Kernel *kernel, size_t work_items, uint64_t items,
                            const char *sentence, const KernelArg *args, size_t arg_count, Log *log);

Status __wrap_program_build(Program **out, Device *device, const char *path, const char *options, Log *log)
{
  *out = NULL;
  for (int i = 0; i < asked_count; i++)
    if (!strcmp(asked[i].path, path) && !strcmp(asked[i].options, options)) return STATUS_OK;
  assert_in_range(asked_count, 0, ASKED_MOST - 1);
  asked[asked_count].path = path;
  snprintf(asked[asked_count++].options, sizeof asked->options, "%s", options);
  return STATUS_OK;
}

Status __wrap_program_kernel(Kernel *out, const Program *program, const char *name, Log *log)
{
  *out = (Kernel){.name = name};
  return STATUS_OK;
}

Status __wrap_device_launch(Device *device, const Kernel *kernel, size_t work_items, uint64_t items,
                            const char *sentence, const KernelArg *args, size_t arg_count, Log *log)
{
  return STATUS_OK;
}

// What a frame of a scene asks for; a plan is made of the settings.
static void frame_ask(Device *device, const DeviceScene *scene, const RenderSettings *settings)
{
  Frame frame = {0};
  const Camera camera = scene_features_camera();
  const SceneFacts facts = {.light_count = scene->light_count,
                            .has_mirrors = true,
                            .has_blends = true,
                            .least_roughness = 0.25f,
                            .environment_lights = true};
  const FrameRequest request = {.camera = &camera,
                                .area = {16, 16, 0, 0, 16, 16},
                                .samples = 1,
                                .aovs = AOV_SET_SURFACE,
                                .plan = plan_make(settings, &facts)};
  picture_assert_ok(frame_make(&frame, device, scene, &request, &picture_log));
  frame_free(&frame);
}

static RenderSettings settings_of(PrimaryMethod primary, ShadowMethod shadows)
{
  PictureRequest picture = picture_request(16, 16, 1);
  picture.settings.primary = primary;
  picture.settings.shadows = shadows;
  return picture.settings;
}

// Rasters of both ways, on whatever device.
static void rasters_ask(Device *device, const DeviceScene *scene, RasterWay way)
{
  const RasterOptions options = {.way = way};
  RasterScene triangles = {0};
  RasterVisibility visibility = {0};
  RasterDepth depth = {0};
  SureRaster sure = {0};
  picture_assert_ok(raster_scene_make(&triangles, device, scene, &options, &picture_log));
  picture_assert_ok(raster_visibility_make(&visibility, device, scene, &options, &picture_log));
  picture_assert_ok(raster_depth_make(&depth, device, scene, &options, &picture_log));
  picture_assert_ok(sure_raster_make(&sure, device, &triangles, &options, &picture_log));
  sure_raster_free(&sure);
  raster_depth_free(&depth);
  raster_visibility_free(&visibility);
  raster_scene_free(&triangles);
}

// A scene that has everything.
static void scene_of_all_make(DeviceScene *scene, Scene *features, Device *device)
{
  *features = scene_features();
  picture_assert_ok(device_scene_make(scene, device, features, NULL, &picture_log));
  scene->has_textures = scene->has_second_uvs = scene->has_normal_maps = scene->has_masks = true;
  scene->has_blends = scene->has_colors = scene->has_shadowless = true;
}

static void all_ask(Device *device)
{
  NearTrace near = {0};
  NearInfo info = {0};
  Scene features;
  DeviceScene scene;
  const RenderSettings settings[] = {settings_of(PRIMARY_RAYS, SHADOWS_RAYS),
                                     settings_of(PRIMARY_RASTER, SHADOWS_HYBRID),
                                     settings_of(PRIMARY_RASTER, SHADOWS_PCSS)};
  scene_of_all_make(&scene, &features, device);
  asked_count = 0;
  for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) frame_ask(device, &scene, &settings[i]);
  rasters_ask(device, &scene, RASTER_WAY_BINS);
  rasters_ask(device, &scene, RASTER_WAY_DIRECT);
  picture_assert_ok(near_trace_make(&near, device, &scene, NULL, &info, 0, 64, &picture_log));
  near_trace_free(&near);
  device_scene_free(&scene);
  scene_free(&features);
}

// What is looked at in code that a kernel holds and never reaches.
static const struct {
  const char *path;
  const char *flags;
} unreached[] = {
    {"capture/near_trace.cl", "-D HAS_BLEND -D HAS_SHADOWLESS "},  // of packets that look for any hit
    {"shade/aov.cl", "-D HAS_BLEND "},                             // a surface's alpha, which no AOV shows
};

static uint32_t flags_unreached(const char *path)
{
  for (size_t i = 0; i < sizeof unreached / sizeof *unreached; i++)
    if (!strcmp(path, unreached[i].path)) return scene_flags_given(unreached[i].flags);
  return 0;
}

static void flags_name(char *out, uint32_t flags)
{
  *out = 0;
  for (int i = 0; i < SCENE_FLAGS; i++)
    if (flags >> i & 1) strcat(strcat(out, " "), scene_flags[i]);
}

// All that they look at, for want of which something is wrong, and no more, for which they would be compiled in vain.
static void kernels_are_told_what_they_look_at(void **state)
{
  char looked_at[256], told[256];
  all_ask(picture_device(16));
  for (int i = 0; i < asked_count; i++) {
    const uint32_t given = scene_flags_given(asked[i].options), except = flags_unreached(asked[i].path),
                   looks = scene_flags_looked_at(asked[i].path, asked[i].options);
    flags_name(looked_at, looks & ~except);
    flags_name(told, given);
    printf("%s:%s\n", asked[i].path, told);
    if ((looks & ~except) != given) fail_msg("%s looks at%s, and is told of%s", asked[i].path, looked_at, told);
    assert_int_equal(looks & except, except);  // else the table is out of date
  }
}

// No other file has kernels that look at anything.
static void no_kernel_is_left_out(void **state)
{
  char looked_at[256];
  if (test_skips_on_gpu("kernels for lanes")) return;
  all_ask(picture_device(16));
  for (const KernelSource *source = kernel_sources; source->path; source++) {
    bool is_asked = false;
    if (strstr(source->path, ".cl") == NULL || !strncmp(source->path, "lib/", 4)) continue;
    for (int i = 0; i < asked_count && !is_asked; i++) is_asked = kernel_file_holds(asked[i].path, source->path);
    if (is_asked) continue;
    const uint32_t looks = scene_flags_looked_at(source->path, "");
    flags_name(looked_at, looks);
    if (looks) fail_msg("%s looks at%s: build it here too", source->path, looked_at);
  }
}

// Shading is told what the plan does, and of nothing else that costs time to compile.
static void shading_is_told_what_the_plan_does(void **state)
{
  static const struct {
    ShadowMethod shadows;
    EnvironmentLightMethod environment_light;
    ReflectionMethod reflections;
    const char *told;
  } rows[] = {
      {SHADOWS_RAYS, ENVIRONMENT_LIGHT_SH, REFLECTIONS_RAYS, ""},
      {SHADOWS_HYBRID, ENVIRONMENT_LIGHT_SH, REFLECTIONS_RAYS, "HAS_SURE_MAPS"},
      {SHADOWS_PCF, ENVIRONMENT_LIGHT_SH, REFLECTIONS_RAYS, "HAS_SHADOW_MAPS"},
      {SHADOWS_PCSS, ENVIRONMENT_LIGHT_SH, REFLECTIONS_RAYS, "HAS_SHADOW_MAPS HAS_DISC"},
      {SHADOWS_AREA, ENVIRONMENT_LIGHT_SH, REFLECTIONS_RAYS, "HAS_AREA_LIGHTS"},
      {SHADOWS_RAYS, ENVIRONMENT_LIGHT_SAMPLED, REFLECTIONS_RAYS, "HAS_LOBES"},
      {SHADOWS_RAYS, ENVIRONMENT_LIGHT_SH_AO, REFLECTIONS_RAYS, "HAS_OCCLUSION_RAYS"},
      {SHADOWS_RAYS, ENVIRONMENT_LIGHT_SH, REFLECTIONS_CUBE, "HAS_ROUGH_MAPS"},
  };
  static const char *const flags[] = {"HAS_SURE_MAPS", "HAS_SHADOW_MAPS",    "HAS_DISC",      "HAS_AREA_LIGHTS",
                                      "HAS_LOBES",     "HAS_OCCLUSION_RAYS", "HAS_ROUGH_MAPS"};
  Scene features;
  DeviceScene scene;
  Device *device = picture_device(16);
  scene_of_all_make(&scene, &features, device);
  for (size_t row = 0; row < sizeof rows / sizeof *rows; row++) {
    int shaders = 0;
    RenderSettings settings = settings_of(PRIMARY_RAYS, rows[row].shadows);
    settings.max_roughness = MAX_ROUGHNESS_AUTO;
    settings.environment_light = rows[row].environment_light;
    settings.reflections = rows[row].reflections;
    asked_count = 0;
    frame_ask(device, &scene, &settings);
    for (int i = 0; i < asked_count; i++) {
      if (strcmp(asked[i].path, "shade/shade.cl") != 0) continue;
      shaders++;
      for (size_t f = 0; f < sizeof flags / sizeof *flags; f++)
        if (!strstr(asked[i].options, flags[f]) != !strstr(rows[row].told, flags[f]))
          fail_msg("row %zu: %s: %s", row, flags[f], asked[i].options);
    }
    assert_int_equal(shaders, 1);
  }
  device_scene_free(&scene);
  scene_free(&features);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(kernels_are_told_what_they_look_at),
      cmocka_unit_test(no_kernel_is_left_out),
      cmocka_unit_test(shading_is_told_what_the_plan_does),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
