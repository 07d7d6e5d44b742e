// Hybrid shadows are those of rays: the same pictures, with few rays traced.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "scene/scene_defaults.h"
#include "support/effort.h"
#include "support/gltf_build.h"
#include "support/picture_fixture.h"
#include "support/ratios.h"
#include "support/scene_features.h"
#include "support/shared_models.h"
#include "support/test_device.h"

// Pixels in which the pictures of two methods differ at all.
static uint32_t pixels_between(const Scene *scene, const Camera *camera, PictureRequest request, ShadowMethod one,
                               ShadowMethod other)
{
  request.settings.shadows = one;
  Picture a = picture_render(scene, camera, &request);
  request.settings.shadows = other;
  Picture b = picture_render(scene, camera, &request);
  uint32_t apart = 0;
  for (uint32_t i = 0; i < a.width * a.height; i++)
    apart += memcmp(a.radiance[i], b.radiance[i], sizeof a.radiance[i]) != 0;
  picture_free(&a);
  picture_free(&b);
  return apart;
}

static uint32_t pixels_apart(const Scene *scene, const Camera *camera, PictureRequest request)
{
  return pixels_between(scene, camera, request, SHADOWS_RAYS, SHADOWS_HYBRID);
}

static void check_same(const Scene *scene, const Camera *camera, PictureRequest request)
{
  uint32_t pixels = request.settings.width * request.settings.height;
  assert_true(pixels_between(scene, camera, request, SHADOWS_RAYS, SHADOWS_NONE) > pixels / 100);
  assert_int_equal(pixels_apart(scene, camera, request), 0);
}

// Every kind of material, alpha and light, at every width; maps from far too small to large.
static void every_feature_is_judged_alike(void **state)
{
  static const uint32_t lanes[] = {16, 8, 1}, sizes[] = {16, 128, 0};
  Scene scene = scene_features();
  Camera camera = scene_features_camera();
  for (int i = 0; i < (test_on_gpu() ? 1 : 3); i++) {
    PictureRequest request = picture_request(97, 71, 2);
    request.lanes = lanes[i];
    request.settings.shadow_options.map_size_px = sizes[i];
    check_same(&scene, &camera, request);
  }
  scene_free(&scene);
}

// A wall of boxes, balls and open sheets between three kinds of light and a floor.
static Scene scene_casters(void)
{
  Scene scene = scene_empty();
  int grey = scene_add_material(&scene, material_plain(vec3(0.7, 0.7, 0.7), 0, 1));
  Material thin = material_plain(vec3(0.3, 0.5, 0.2), 0, 1);
  thin.double_sided = true;
  int leaf = scene_add_material(&scene, thin);
  scene_add_quad(&scene, grey, vec3(-6, 0, 6), vec3(12, 0, 0), vec3(0, 0, -12));
  for (int i = 0; i < 5; i++) {
    scene_add_box(&scene, grey, vec3(-4 + 2 * i, 0, -2), vec3(-3.2 + 2 * i, 0.6 + 0.3 * i, -1.4));
    scene_add_sphere(&scene, grey, vec3(-4 + 2 * i, 0.5 + 0.1 * i, 1), 0.5, 6 + 4 * i);
    scene_add_quad(&scene, leaf, vec3(-4 + 1.7 * i, 1.5, 2), vec3(0.9, 0.3 * i - 0.5, 0.2), vec3(0.1, 0.6, 0.4));
  }
  return scene;
}

static void each_kind_of_light_is_judged_alike(void **state)
{
  Camera camera = camera_perspective(vec3(1, 5, 9), vec3(0, 0.4, 0), 0.8);
  for (int kind = 0; kind < 4; kind++) {
    Scene scene = scene_casters();
    scene_add_light(&scene, kind == 0   ? light_point(vec3(0.3, 3.1, 0.2), 60)
                            : kind == 1 ? light_spot(vec3(3, 5, 5), vec3(0, 0, 0), 200, 0.4, 0.6)
                            : kind == 2 ? light_spot(vec3(1, 4, 2), vec3(0, 0, 0), 100, 1.2, 1.5)
                                        : light_directional(vec3(-0.4, -1, -0.3), 3));
    check_same(&scene, &camera, picture_request(160, 100, 1));
    scene_free(&scene);
  }
}

// A camera or a light inside closed surfaces, and surfaces wound inside out: where the rule of averted triangles has
// its conditions.
static void closed_surfaces_are_left_out_where_that_is_right_alone(void **state)
{
  for (int variant = 0; variant < 4; variant++) {
    Scene scene = scene_casters();
    int grey = 0, leaf = 1;
    if (variant == 0) scene_add_box(&scene, grey, vec3(-0.5, 2.5, -0.5), vec3(0.9, 3.5, 0.8));  // about the light
    // About all but one light, seen from within: that light crosses fronts alone on its way in.
    if (variant == 1) scene_add_box(&scene, leaf, vec3(-7, -1, -7), vec3(7, 7, 10));
    if (variant == 2) scene_add_box(&scene, grey, vec3(0.5, 4.5, 8.5), vec3(1.5, 5.5, 9.5));  // about the camera
    if (variant == 3) {  // a ball turned inside out
      uint32_t ball = scene_add_sphere(&scene, grey, vec3(0, 1.6, 0), 0.5, 12);
      Primitive *primitive = &scene.meshes[scene.objects[ball].mesh].primitives[0];
      for (uint32_t i = 0; i < primitive->triangle_count; i++) {
        uint32_t corner = primitive->triangles[i][1];
        primitive->triangles[i][1] = primitive->triangles[i][2];
        primitive->triangles[i][2] = corner;
      }
    }
    scene_add_light(&scene, light_point(vec3(0.3, variant == 1 ? 9 : 3.1, 0.2), 60));
    scene_add_light(&scene, light_point(vec3(-3, 2.5, 4), 30));
    Camera camera = camera_perspective(vec3(1, 5, 9), vec3(0, 0.4, 0), 0.8);
    camera.znear_m = 0.05;
    assert_int_equal(pixels_apart(&scene, &camera, picture_request(160, 100, 1)), 0);
    scene_free(&scene);
  }
}

// A passage between two mirrors, under a roof that leaves its end open: most of the floors that they show of each other
// is dark, and need not be traced.
static void the_dark_between_mirrors_is_not_traced(void **state)
{
  Scene scene = scene_empty();
  int grey = scene_add_material(&scene, material_plain(vec3(0.7, 0.7, 0.7), 0, 1));
  int mirror = scene_add_material(&scene, material_plain(vec3(0.9, 0.9, 0.9), 1, 0));
  scene_add_quad(&scene, grey, vec3(-6, 0, 6), vec3(12, 0, 0), vec3(0, 0, -12));
  scene_add_box(&scene, mirror, vec3(-0.9, 0, -5), vec3(-0.7, 3, 5));
  scene_add_box(&scene, mirror, vec3(0.7, 0, -5), vec3(0.9, 3, 5));
  scene_add_box(&scene, grey, vec3(-3, 3.1, -6), vec3(3, 3.2, 3));
  scene_add_light(&scene, light_directional(vec3(0.1, -1, 0.2), 3));
  Camera camera = camera_perspective(vec3(0.3, 1.6, 3.5), vec3(-0.7, 1, 2.5), 0.9);
  PictureRequest request = picture_request(160, 100, 1);
  check_same(&scene, &camera, request);
  request.settings.shadows = SHADOWS_HYBRID;
  Picture hybrid = picture_render(&scene, &camera, &request);
  request.settings.max_depth = 1;
  Picture shallow = picture_render(&scene, &camera, &request);
  assert_true(hybrid.shadow_rays > 1.2 * (double)shallow.shadow_rays);
  assert_true((double)hybrid.shadow_rays_traced <= 0.1 * (double)hybrid.shadow_rays);
  picture_free(&shallow);
  picture_free(&hybrid);
  scene_free(&scene);
}

static void shipped_scenes_are_judged_alike(void **state)
{
  static const char *const paths[] = {"scenes/room.glb", "scenes/colonnade.glb", "scenes/chrome.glb"};
  for (int i = 0; i < 3; i++) {
    Scene scene = gltf_read_fine(paths[i]);
    Camera camera;
    picture_assert_ok(scene_camera_choose(&camera, &scene, NULL, 16.0 / 9, &picture_log));
    PictureRequest request = picture_request(320, 180, 1);
    request.settings.shadow_options.map_size_px = 256;
    check_same(&scene, &camera, request);
    scene_free(&scene);
  }
}

enum { SHARES_MOST = 1000 };
static const double traced_most = 0.1;

// What became of pictures: pixels in which hybrid shadows and rays differ, and of each the share of shadow rays traced.
typedef struct Verdicts {
  uint32_t width, height;
  uint32_t models;
  uint64_t pixels, apart;
  uint32_t beyond;  // pictures of which more was traced than should be
  double traced[SHARES_MOST];
  int count;
} Verdicts;

static void picture_judge(Verdicts *verdicts, const char *name, const char *light, const Scene *scene,
                          const Camera *camera)
{
  PictureRequest request = picture_request(verdicts->width, verdicts->height, 1);
  request.bare = !effort_is_full();  // scene_features has all of it
  Picture rays = picture_render(scene, camera, &request);
  request.settings.shadows = SHADOWS_HYBRID;
  Picture hybrid = picture_render(scene, camera, &request);
  uint32_t apart = 0, pixels = verdicts->width * verdicts->height;
  for (uint32_t i = 0; i < pixels; i++)
    apart += memcmp(rays.radiance[i], hybrid.radiance[i], sizeof rays.radiance[i]) != 0;
  double traced = (double)hybrid.shadow_rays_traced / (double)(hybrid.shadow_rays ? hybrid.shadow_rays : 1);
  if (apart || traced > traced_most)
    printf("%s, %s: %u pixels apart, %.2f %% traced\n", name, light, apart, 100 * traced);
  verdicts->pixels += pixels;
  verdicts->apart += apart;
  verdicts->beyond += traced > traced_most;
  assert_in_range(verdicts->count, 0, SHARES_MOST - 1);
  if (hybrid.shadow_rays) verdicts->traced[verdicts->count++] = traced;
  picture_free(&rays);
  picture_free(&hybrid);
}

// Lit from outside of its bounds by each kind of light in turn; by usual effort each model by one of them, in slow
// builds every fourth model.
static void model_judge(void *context, const char *path, Scene *scene)
{
  static const char *const names[] = {"point", "spot", "directional"};
  Verdicts *verdicts = context;
  Vec3 low, high;
  Camera camera;
  const uint32_t number = verdicts->models++;
  if ((effort_is_quick() && number % 4) || !scene_bounds(scene, &low, &high)) return;
  picture_assert_ok(
      scene_camera_choose(&camera, scene, "fit", (double)verdicts->width / verdicts->height, &picture_log));
  Vec3 center = vec3_scale(vec3_add(low, high), 0.5);
  double size = vec3_length(vec3_sub(high, low));
  Vec3 above = vec3_add(center, vec3_scale(vec3(0.3, 0.8, 0.4), size));
  for (uint32_t i = 0; i < scene->light_count; i++) scene->lights[i].intensity = 0;
  scene_add_light(scene, light_point(above, 1));
  Light *light = &scene->lights[scene->light_count - 1];
  const int only = (int)(number % 3);
  for (int kind = 0; kind < 3; kind++) {
    if (!effort_is_full() && kind != only) continue;
    char *name = light->name;
    *light = kind == 0   ? light_point(above, size * size)
             : kind == 1 ? light_spot(above, center, 3 * size * size, 0.3, 0.7)
                         : light_directional(vec3(-0.5, -0.7, -0.3), 3);
    light->name = name;
    picture_judge(verdicts, path, names[kind], scene, &camera);
  }
}

// Shared models by three kinds of light, and shipped scenes by their own, with maps of automatic size. At full size
// three pixels of colonnade differ: mirrored rays that start closer to the floor than rounding can tell pass it and
// meet what stands in it; shadow rays from there begin within a closed surface (cl/rays/shadow_hybrid.cl).
static void models_are_judged_alike_with_few_rays(void **state)
{
  static const char *const shipped[] = {"scenes/room.glb", "scenes/colonnade.glb", "scenes/chrome.glb",
                                        "scenes/field.glb"};
  Verdicts verdicts = {.width = effort_is_full() ? 1280 : 120, .height = effort_is_full() ? 720 : 80};
  assert_true(shared_models_visit(model_judge, &verdicts) >= 40);
  for (int i = 0; i < (effort_is_full() ? 4 : 1); i++) {
    Scene scene = gltf_read_fine(shipped[i]);
    Camera camera;
    picture_assert_ok(
        scene_camera_choose(&camera, &scene, NULL, (double)verdicts.width / verdicts.height, &picture_log));
    picture_judge(&verdicts, shipped[i], "its own", &scene, &camera);
    scene_free(&scene);
  }
  ratios_sort(verdicts.traced, verdicts.count);
  double median = verdicts.traced[verdicts.count / 2], worst = verdicts.traced[verdicts.count - 1];
  printf("%llu of %llu pixels apart; of %d pictures' shadow rays %.2f %% traced in the median, %.2f %% in the worst\n",
         (unsigned long long)verdicts.apart, (unsigned long long)verdicts.pixels, verdicts.count, 100 * median,
         100 * worst);
  assert_true(verdicts.apart * 100000 <= verdicts.pixels);
  assert_true(median <= 0.05);
  if (effort_is_full()) assert_int_equal(verdicts.beyond, 0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_feature_is_judged_alike),
      cmocka_unit_test(each_kind_of_light_is_judged_alike),
      cmocka_unit_test(closed_surfaces_are_left_out_where_that_is_right_alone),
      cmocka_unit_test(the_dark_between_mirrors_is_not_traced),
      cmocka_unit_test(shipped_scenes_are_judged_alike),
      cmocka_unit_test(models_are_judged_alike_with_few_rays),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
