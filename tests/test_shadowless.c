// What casts no shadow is seen, by camera and in mirrors, and blocks no light, whatever finds the shadows.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/picture_fixture.h"
#include "support/test_device.h"

enum { WIDTH = 144, HEIGHT = 96, PIXELS = WIDTH * HEIGHT };

static const uint32_t widths[] = {16, 1};
static const ShadowMethod methods[] = {SHADOWS_RAYS, SHADOWS_HYBRID, SHADOWS_MAP,
                                       SHADOWS_PCF,  SHADOWS_PCSS,   SHADOWS_AREA};

// A floor, a box that casts, mirrors, two posts that hold the scene's bounds; and last, its numbers above all
// others, what may cast no shadow: a box over the first, an open sheet, masked leaves.
typedef struct Stage {
  Scene scene;
  uint32_t mirrors[2], first;  // objects: a plane and a ball; from `first` on they may be shadowless
} Stage;

typedef enum Tested { TESTED_ABSENT, TESTED_CASTS, TESTED_SHADOWLESS } Tested;

static void tested_add(Stage *stage, int thin, int leaf)
{
  Scene *scene = &stage->scene;
  scene_add_box(scene, thin, vec3(-0.9, 1.1, -0.4), vec3(0.1, 1.5, 0.6));
  scene_add_quad(scene, thin, vec3(0.6, 0.3, 0.2), vec3(0.8, 0, 0), vec3(0, 1, -0.3));
  scene_add_quad(scene, leaf, vec3(-1.9, 0.6, 0.4), vec3(0.8, 0, 0), vec3(0, 0.3, -0.7));
}

static Stage stage_make(Tested tested)
{
  Stage stage = {.scene = scene_empty()};
  Scene *scene = &stage.scene;
  int white = scene_add_material(scene, material_plain(vec3(0.8, 0.8, 0.8), 0, 1));
  Material thin = material_plain(vec3(0.7, 0.2, 0.1), 0, 1), masked = thin;
  thin.double_sided = true;
  int red = scene_add_material(scene, thin), mirror = scene_add_material(scene, material_plain(vec3(1, 1, 1), 1, 0));
  static const uint8_t texels[4][4] = {{255, 255, 255, 255}, {255, 255, 255, 0}, {255, 255, 255, 0}, {0, 255, 0, 255}};
  masked.base_color_slot.texture = scene_add_texture(scene, 2, 2, texels);
  masked.alpha_mode = ALPHA_MASK;
  masked.alpha_cutoff = 0.5f;
  int leaf = scene_add_material(scene, masked);
  scene_add_quad(scene, white, vec3(-3, 0, 3), vec3(6, 0, 0), vec3(0, 0, -6));
  scene_add_box(scene, white, vec3(-0.7, 0, -0.3), vec3(0, 0.7, 0.4));
  stage.mirrors[0] = scene_add_quad(scene, mirror, vec3(-2, 0.1, -2), vec3(4, 0, 0), vec3(0, 1.8, 0));
  stage.mirrors[1] = scene_add_sphere(scene, mirror, vec3(1.7, 0.5, 1.1), 0.5, 16);
  for (int i = -1; i <= 1; i += 2) scene_add_box(scene, white, vec3(2.8 * i, 0, -2.9), vec3(2.8 * i + 0.1, 2.5, -2.8));
  scene_add_quad(scene, white, vec3(-1, -0.2, -1), vec3(1, 0, 0), vec3(0, 0, 1));
  scene->objects[scene->object_count - 1].shadowless = true;  // unseen: all stages take the same kernels
  stage.first = scene->object_count;
  if (tested != TESTED_ABSENT) tested_add(&stage, red, leaf);
  for (uint32_t i = stage.first; i < scene->object_count; i++)
    scene->objects[i].shadowless = tested == TESTED_SHADOWLESS;
  return stage;
}

static Light stage_light(int kind)
{
  return kind == 0   ? light_point(vec3(-0.2, 2.2, 0.5), 30)
         : kind == 1 ? light_spot(vec3(1, 2.4, 1.5), vec3(0, 0, 0), 60, 0.6, 0.8)
                     : light_directional(vec3(0.3, -1, -0.4), 3);
}

static Picture stage_picture(const Stage *stage, const PictureRequest *request)
{
  Camera camera = camera_perspective(vec3(0.4, 2.6, 4.6), vec3(0, 0.5, 0), 0.8);
  return picture_render(&stage->scene, &camera, request);
}

// How two pictures differ, where what is tested is not seen directly, and where it is seen.
typedef struct Differences {
  uint32_t beside, seen;
} Differences;

static Differences differences(const Picture *with, const Picture *without, uint32_t first)
{
  Differences out = {0};
  const uint32_t *objects = picture_integers(with, "object.id");
  for (uint32_t i = 0; i < PIXELS; i++) {
    bool seen = objects[i] != UINT32_MAX && objects[i] >= first;
    out.seen += seen;
    if (!seen) out.beside += memcmp(with->radiance[i], without->radiance[i], sizeof with->radiance[i]) != 0;
  }
  return out;
}

// Shadows where nothing reflects: those of a scene without what is tested, to the bit; the same with shadows would not
// be. And what is seen of it is lit.
static void shadows_check(const PictureRequest *request, void (*lights_set)(Scene *scene, int kind), int kind)
{
  Picture pictures[3];
  uint32_t first = 0, lit = 0;
  for (int t = 0; t < 3; t++) {
    Stage stage = stage_make((Tested)t);
    lights_set(&stage.scene, kind);
    pictures[t] = stage_picture(&stage, request);
    first = stage.first;
    scene_free(&stage.scene);
  }
  Differences shadowless = differences(&pictures[TESTED_SHADOWLESS], &pictures[TESTED_ABSENT], first);
  Differences casting = differences(&pictures[TESTED_CASTS], &pictures[TESTED_ABSENT], first);
  const uint32_t *objects = picture_integers(&pictures[TESTED_SHADOWLESS], "object.id");
  for (uint32_t i = 0; i < PIXELS; i++)
    lit += objects[i] != UINT32_MAX && objects[i] >= first && pictures[TESTED_SHADOWLESS].radiance[i][0] > 0.01f;
  if (shadowless.beside > 0 || casting.beside < 100 || shadowless.seen < 200 || lit < 100)
    fail_msg("method %d, light %d, %u lanes: %u pixels differ beside it (%u where it casts), %u see it, %u of them lit",
             request->settings.shadows, kind, request->lanes, shadowless.beside, casting.beside, shadowless.seen, lit);
  for (int t = 0; t < 3; t++) picture_free(&pictures[t]);
}

static PictureRequest shadow_request(uint32_t lanes)
{
  PictureRequest request = picture_request(WIDTH, HEIGHT, 1);
  request.lanes = lanes;
  request.aovs = AOV_NAME_OBJECT;
  request.settings.reflections = REFLECTIONS_NONE;
  return request;
}

static void one_light_set(Scene *scene, int kind) { scene_add_light(scene, stage_light(kind)); }

static void no_method_finds_a_shadow(void **state)
{
  for (int w = 0; w < (test_on_gpu() ? 1 : 2); w++) {
    PictureRequest request = shadow_request(widths[w]);
    request.settings.shadow_options.light_radius_m = 0.1f;
    request.settings.shadow_options.light_angle_rad = 0.05;
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++)
      for (int kind = 0; kind < 3; kind++) {
        if (w > 0 && (m > 1 || kind != (int)m)) continue;  // enough: what these kernels look up is the others'
        request.settings.shadows = methods[m];
        shadows_check(&request, one_light_set, kind);
      }
  }
}

static void environment_set(Scene *scene, int kind)
{
  static const float colors[4][3] = {{4, 4, 3}, {1, 2, 1}, {0.5f, 0.5f, 0.5f}, {0.2f, 0.2f, 0.2f}};
  scene_set_image(scene, 2, 2, colors);
}

static void neither_does_the_environment(void **state)
{
  for (int w = 0; w < (test_on_gpu() ? 1 : 2); w++)
    for (int sampled = 0; sampled < 2; sampled++) {
      PictureRequest request = shadow_request(widths[w]);
      request.settings.environment_light = sampled ? ENVIRONMENT_LIGHT_SAMPLED : ENVIRONMENT_LIGHT_SH_AO;
      shadows_check(&request, environment_set, sampled);
    }
}

// Hybrid shadows are those of rays, with closed surfaces left out of the maps, about the light too.
static void hybrid_is_rays(void **state)
{
  for (int w = 0; w < (test_on_gpu() ? 1 : 2); w++)
    for (int kind = 0; kind < 3; kind++) {
      Stage stage = stage_make(TESTED_SHADOWLESS);
      one_light_set(&stage.scene, kind);
      uint32_t shade = scene_add_sphere(&stage.scene, 0, stage.scene.lights[0].position_world, 0.4, 8);
      stage.scene.objects[shade].shadowless = true;
      PictureRequest request = shadow_request(widths[w]);
      Picture by_rays = stage_picture(&stage, &request);
      request.settings.shadows = SHADOWS_HYBRID;
      Picture hybrid = stage_picture(&stage, &request);
      picture_assert_same(&by_rays, &hybrid);
      assert_true(hybrid.shadow_rays > 1000 && hybrid.shadow_rays_traced < hybrid.shadow_rays / 4);
      picture_free(&by_rays);
      picture_free(&hybrid);
      scene_free(&stage.scene);
    }
}

// Pixels of a mirror that differ by more than `least` of radiance.
static uint32_t mirror_differences(const Picture *a, const Picture *b, uint32_t mirror, float least)
{
  uint32_t count = 0;
  const uint32_t *objects = picture_integers(a, "object.id");
  for (uint32_t i = 0; i < PIXELS; i++)
    count += objects[i] == mirror && !(fabsf(a->radiance[i][1] - b->radiance[i][1]) <= least);
  return count;
}

static Picture mirrors_picture(Tested tested, ReflectionMethod method, uint32_t mirrors[2])
{
  Stage stage = stage_make(tested);
  PictureRequest request = shadow_request(0);
  request.settings.reflections = method;
  request.settings.cubes.size_px = 64;
  one_light_set(&stage.scene, 2);
  memcpy(mirrors, stage.mirrors, sizeof stage.mirrors);
  Picture picture = stage_picture(&stage, &request);
  scene_free(&stage.scene);
  return picture;
}

static void mirrors_show_it_by_every_rung(void **state)
{
  static const ReflectionMethod rungs[] = {REFLECTIONS_HYBRID, REFLECTIONS_SNAPSHOT, REFLECTIONS_PLANAR,
                                           REFLECTIONS_MIXED,  REFLECTIONS_IMPOSTOR, REFLECTIONS_CANDIDATES};
  uint32_t mirrors[2];
  Picture by_rays = mirrors_picture(TESTED_SHADOWLESS, REFLECTIONS_RAYS, mirrors);
  for (size_t r = 0; r < sizeof rungs / sizeof *rungs; r++) {
    Picture with = mirrors_picture(TESTED_SHADOWLESS, rungs[r], mirrors);
    Picture none = mirrors_picture(TESTED_ABSENT, rungs[r], mirrors);
    for (int i = 0; i < 2; i++) {
      uint32_t shown = mirror_differences(&with, &none, mirrors[i], 0.02f);
      uint32_t apart = mirror_differences(&with, &by_rays, mirrors[i], 0.02f);
      bool exact = rungs[r] == REFLECTIONS_HYBRID || rungs[r] == REFLECTIONS_PLANAR;
      if (shown < 10 || (exact && apart > 0))
        fail_msg("rung %d, mirror %d: %u pixels show it, %u are not those of rays", rungs[r], i, shown, apart);
    }
    picture_free(&with);
    picture_free(&none);
  }
  picture_free(&by_rays);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(no_method_finds_a_shadow),
      cmocka_unit_test(neither_does_the_environment),
      cmocka_unit_test(hybrid_is_rays),
      cmocka_unit_test(mirrors_show_it_by_every_rung),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
