// Whole pictures against the oracle's, pixel by pixel, wherever the picture is stable: where single precision finds the
// same triangles, lights and reflections as exact arithmetic (ORACLE_STABLE).
//
// Errors are the worst channel's, relative to its value + 0.01. In stable pixels they stay under 2e-3, which is what
// rounding a texture coordinate makes of a strong texture seen from far, and under 2e-5 in the mean. Unstable pixels,
// at edges of things and of shadows, may show either side: few do, and the mean of all stays under 1e-3.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <unistd.h>

#include <cmocka.h>

#include "scene/scene_defaults.h"
#include "support/effort.h"
#include "support/gltf_build.h"
#include "support/picture_fixture.h"
#include "support/scene_features.h"

typedef struct Bounds {
  double stable_share;  // at least
  double worst, mean;   // of the stable
  double all_mean;
} Bounds;

static const Bounds usual = {.stable_share = 0.9, .worst = 2e-3, .mean = 2e-5, .all_mean = 1e-3};

static double pixel_error(const float *got, const double *wanted)
{
  double error = 0;
  for (int c = 0; c < 3; c++) error = fmax(error, fabs(got[c] - wanted[c]) / (wanted[c] + 0.01));
  return error;
}

static void pictures_compare(const char *name, const Picture *picture, const OracleImage *oracle, const Bounds *bounds)
{
  double worst = 0, mean = 0, all_mean = 0, count = (double)picture->width * picture->height;
  uint32_t stable = 0;
  for (uint32_t y = 0; y < picture->height; y++) {
    for (uint32_t x = 0; x < picture->width; x++) {
      const double *wanted = oracle->radiance[(size_t)y * picture->width + x];
      const float *got = picture_pixel(picture, x, y);
      double error = pixel_error(got, wanted);
      all_mean += error / count;
      if (!oracle_image_stable(oracle, x, y)) continue;
      stable++;
      mean += error;
      worst = fmax(worst, error);
      if (!(error <= bounds->worst))
        fail_msg("%s: (%u, %u) is %g %g %g, not %g %g %g", name, x, y, got[0], got[1], got[2], wanted[0], wanted[1],
                 wanted[2]);
    }
  }
  mean /= stable;
  print_message("%-32s stable %.3f, their errors up to %.1e, mean %.1e, mean of all %.1e\n", name, stable / count,
                worst, mean, all_mean);
  if (!(stable >= bounds->stable_share * count && mean <= bounds->mean && all_mean <= bounds->all_mean))
    fail_msg("%s: too many unstable pixels, or errors too large in the mean", name);
}

// Renders by each width of `lanes` (ends with 0, the device's own).
static void scene_check(const char *name, Scene *scene, const Camera *camera, PictureRequest request,
                        const uint32_t *lanes, const Bounds *bounds)
{
  OracleScene oracle_scene = oracle_scene_from_model(scene);
  OracleOptions options = picture_oracle_options(&request);
  OracleImage oracle = oracle_image_render(&oracle_scene, camera, &options);
  do {
    request.lanes = *lanes;
    Picture picture = picture_render(scene, camera, &request);
    picture_assert_signal(&picture, 0.05);
    pictures_compare(name, &picture, &oracle, bounds);
    picture_free(&picture);
  } while (*lanes++);
  oracle_image_free(&oracle);
  oracle_scene_free(&oracle_scene);
}

static const uint32_t own_width[] = {0}, all_widths[] = {16, 8, 1, 0};

static void every_feature_agrees(void **state)
{
  Scene scene = scene_features();
  Camera camera = scene_features_camera();
  PictureRequest request = effort_is_quick() ? picture_request(79, 46, 1) : picture_request(157, 91, 1);
  scene_check("features, pbr", &scene, &camera, request, all_widths, &usual);
  request.settings.lighting = LIGHTING_PHONG;
  scene_set_sky(&scene);
  scene_check("features, phong, sky", &scene, &camera, request, all_widths, &usual);
  scene_free(&scene);
}

static void without_shadows_and_reflections_pictures_agree(void **state)
{
  Scene scene = scene_features();
  Camera camera = scene_features_camera();
  PictureRequest request = picture_request(64, 36, 4);
  request.settings.shadows = SHADOWS_NONE;
  request.settings.reflections = REFLECTIONS_NONE;
  scene_check("features, camera rays alone", &scene, &camera, request, own_width, &usual);
  scene_free(&scene);
}

// The environment in `pbr`: nine harmonics stand for it where surfaces are rough, hence the bounds.
static void the_sky_lights_surfaces_nearly(void **state)
{
  Scene scene = scene_features();
  Camera camera = scene_features_camera();
  PictureRequest request = picture_request(48, 27, 5);
  request.settings.max_depth = 2;
  scene_set_sky(&scene);
  scene_check("features, pbr, sky, depth 2", &scene, &camera, request, own_width,
              &(Bounds){.stable_share = 0.9, .worst = 0.2, .mean = 0.03, .all_mean = 0.03});
  scene_free(&scene);
}

// A file with its own first camera, or a fitted one, and the light it gets without any.
static void file_check(const char *path, uint32_t width, uint32_t height, LightingModel model, Bounds bounds)
{
  Camera camera;
  Scene scene = gltf_read_fine(path);
  picture_assert_ok(scene_add_default_lighting(&scene, true, &picture_log));
  picture_assert_ok(scene_camera_choose(&camera, &scene, NULL, (double)width / height, &picture_log));
  PictureRequest request = picture_request(width, height, 1);
  request.settings.lighting = model;
  scene_check(path, &scene, &camera, request, own_width, &bounds);
  scene_free(&scene);
}

static void shipped_scenes_agree(void **state)
{
  // Mirrors that show fine geometry leave few pixels stable.
  Bounds fine = usual;
  fine.stable_share = 0.6;
  file_check("scenes/room.glb", 96, 54, LIGHTING_PBR, usual);
  file_check("scenes/chrome.glb", 64, 36, LIGHTING_PHONG, usual);
  file_check("scenes/colonnade.glb", 32, 18, LIGHTING_PBR, fine);
}

// Whitted's picture: a mirror ball fills it, and shows the room, what stands in it, and itself in what shines there. No
// stable pixel is off by more than 1 %, by rays and by hybrid reflections with a map of 256 texels.
static void a_mirror_ball_in_a_room_agrees(void **state)
{
  Camera camera;
  Scene scene = gltf_read_fine("scenes/room.glb");
  PictureRequest request = picture_request(96, 54, 1);
  picture_assert_ok(scene_add_default_lighting(&scene, true, &picture_log));
  picture_assert_ok(scene_camera_choose(&camera, &scene, "ball", 96.0 / 54, &picture_log));
  for (int model = LIGHTING_PBR; model <= (effort_is_quick() ? LIGHTING_PBR : LIGHTING_PHONG); model++) {
    request.settings.lighting = (LightingModel)model;
    request.settings.reflections = REFLECTIONS_RAYS;
    scene_check("mirror ball", &scene, &camera, request, all_widths,
                &(Bounds){.stable_share = 0.8, .worst = 0.01, .mean = 2e-5, .all_mean = 2e-3});
    request.settings.reflections = REFLECTIONS_HYBRID;
    request.settings.cubes.size_px = 256;
    scene_check("mirror ball, hybrid", &scene, &camera, request, own_width,
                &(Bounds){.stable_share = 0.8, .worst = 0.01, .mean = 3e-4, .all_mean = 2e-3});
  }
  scene_free(&scene);
}

static void asset_check(const char *name, Bounds bounds)
{
  const char *assets = gltf_assets();
  char path[512];
  snprintf(path, sizeof path, "%s/%s/%s.glb", assets, name, name);
  if (access(path, R_OK) != 0) snprintf(path, sizeof path, "%s/%s/%s.gltf", assets, name, name);
  file_check(path, 96, 54, LIGHTING_PHONG, bounds);
}

static void shared_assets_agree(void **state)
{
  static const char *const names[] = {"TextureSettingsTest", "TextureTransformTest", "MultiUVTest",
                                      "VertexColorTest",     "NegativeScaleTest",    "AlphaBlendModeTest",
                                      "OrientationTest",     "LightsPunctualLamp",   "EmissiveStrengthTest"};
  if (!gltf_assets()) return;
  size_t count = effort_is_quick() ? 2 : sizeof names / sizeof *names;
  for (size_t i = 0; i < count; i++) asset_check(names[i], usual);
  if (effort_is_quick()) return;
  // Normals that a map turns away from the viewer have no defined image: such pixels are unstable, and off.
  Bounds mapped = usual;
  mapped.all_mean = 0.01;
  asset_check("NormalTangentMirrorTest", mapped);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_feature_agrees),
      cmocka_unit_test(without_shadows_and_reflections_pictures_agree),
      cmocka_unit_test(the_sky_lights_surfaces_nearly),
      cmocka_unit_test(shipped_scenes_agree),
      cmocka_unit_test(a_mirror_ball_in_a_room_agrees),
      cmocka_unit_test(shared_assets_agree),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
