// What cl/shade/shade.cl adds without a light, and the rays that it sends on.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/oracle_environment.h"
#include "support/shade_lab.h"

static void assert_close(const float got[3], Vec3 wanted, double relative, double absolute, const char *what,
                         uint32_t i)
{
  const double want[3] = {wanted.x, wanted.y, wanted.z};
  for (int c = 0; c < 3; c++)
    if (!(fabs(got[c] - want[c]) <= relative * fabs(want[c]) + absolute))
      fail_msg("%s %u, component %d: %.9g, not %.9g", what, i, c, got[c], want[c]);
}

// ---- surfaces -------------------------------------------------------------------------------------------------------

enum { PLAIN, GLOWING, UNLIT, MIRROR, METAL_MIRROR, DARK_MIRROR, BENT_MIRROR, SURFACES, VIEWS = 9 };
enum { HITS = SURFACES * VIEWS };

static Scene surfaces_scene(void)
{
  Scene scene = scene_empty();
  const Vec3 corners[3] = {vec3(-1, -0.8, 0.3), vec3(1.2, -0.7, 0.5), vec3(-0.2, 1.1, 0.7)};
  Vec3 normal = vec3_cross(vec3_sub(corners[1], corners[0]), vec3_sub(corners[2], corners[0]));
  Material materials[SURFACES];
  for (int i = 0; i < SURFACES; i++) materials[i] = material_plain(vec3(0.8, 0.5, 0.1), 0.25, i < MIRROR ? 0.5 : 0);
  materials[GLOWING].emission[0] = 3;
  materials[UNLIT].unlit = true;
  materials[UNLIT].emission[2] = 5;  // which it then does not have
  materials[METAL_MIRROR].metallic = 1;
  memset(materials[DARK_MIRROR].base_color, 0, 3 * sizeof(float));
  for (int i = 0; i < SURFACES; i++) {
    Vec3 normals[3] = {normal, normal, normal};
    if (i == BENT_MIRROR) normals[1] = vec3(0.9, 0.1, 0.1);
    scene_add_triangle(&scene, scene_add_material(&scene, materials[i]), corners, normals);
  }
  scene_add_light(&scene, light_point(vec3(0.5, -2, 3), 20));
  scene_add_light(&scene, light_directional(vec3(0.2, 0.4, -1), 2));
  scene_add_light(&scene, light_spot(vec3(0, 0, 2), vec3(0.1, 0, 0), 5, 0.2, 0.9));
  return scene;
}

static void surfaces_hits(LabHit hits[HITS])
{
  for (int i = 0; i < HITS; i++) {
    Vec3 view = lab_polar(0.15 + 0.09 * (i % VIEWS), i);
    hits[i] = (LabHit){.triangle = (uint32_t)(i / VIEWS),
                       .u = 0.1f + 0.05f * (float)(i % VIEWS),
                       .v = 0.3f,
                       .direction = {(float)(-3 * view.x), (float)(-3 * view.y), (float)(-3 * view.z)},
                       .weight = {1, 0.5f, 0.125f}};
  }
}

// A lab with the surfaces, for each width in turn.
typedef void (*SurfaceTest)(ShadeLab *lab, const OracleScene *oracle, const LabHit hits[HITS]);

static void for_each_width(SurfaceTest test)
{
  LabHit hits[HITS];
  Scene scene = surfaces_scene();
  OracleScene oracle = oracle_scene_from_model(&scene);
  surfaces_hits(hits);
  for (size_t i = 0; i < LAB_WIDTHS; i++) {
    ShadeLab lab = lab_open(&scene, lab_widths[i]);
    lab_set_hits(&lab, hits, HITS);
    test(&lab, &oracle, hits);
    lab_close(&lab);
  }
  oracle_scene_free(&oracle);
  scene_free(&scene);
}

static Vec3 weighted(Vec3 v, const LabHit *hit) { return vec3_mul(v, vec3_from_floats(hit->weight)); }

static void own_light_check(ShadeLab *lab, const OracleScene *oracle, const LabHit hits[HITS])
{
  for (uint32_t model = LIGHTING_MODEL_PBR; model <= LIGHTING_MODEL_PHONG; model++) {
    float got[HITS][4];
    ShadeInfo info = {.model = model, .first_batch = 1, .ambient = 0.125f, .primary = 1};
    lab_shade(got, lab, &info);
    for (uint32_t i = 0; i < HITS; i++) {
      OraclePoint point = lab_oracle_point(oracle, &hits[i], NULL);
      OracleModel oracle_model = model == LIGHTING_MODEL_PHONG ? ORACLE_PHONG : ORACLE_PBR;
      assert_close(got[i], weighted(oracle_own_light(oracle_model, &point.surface, 0.125), &hits[i]), 1e-6, 0, "hit",
                   i);
      assert_true(got[i][3] == 1);  // covered
    }
    assert_true(got[GLOWING * VIEWS][0] >= 3 && got[UNLIT * VIEWS][2] < 1);
  }
}

static void emission_ambient_and_unlit_need_no_light(void **state) { for_each_width(own_light_check); }

// The same radiance is either added at once or rides on a shadow ray that runs from the surface to the light.
static void shadow_rays_check(ShadeLab *lab, const OracleScene *oracle, const LabHit hits[HITS])
{
  for (uint32_t light = 0; light < oracle->model->light_count; light++) {
    float open[HITS][4];
    ShadeInfo info = {.model = LIGHTING_MODEL_PBR, .first_light = light, .light_count = 1};
    lab_shade(open, lab, &info);
    info.casting_lights = 1;
    float added[HITS][4];
    lab_shade(added, lab, &info);
    LabRay *rays = lab_shadow_rays(lab, 0);
    uint32_t count = lab->counts[0], lit = 0;
    for (uint32_t i = 0; i < HITS; i++) {
      lit += open[i][0] > 0;
      if (i / VIEWS == UNLIT) assert_true(open[i][0] == 0);
      assert_true(added[i][0] == 0 && added[i][1] == 0 && added[i][2] == 0);
    }
    assert_int_equal(count, lit);
    assert_true(lit > HITS / 2);
    for (uint32_t i = 0; i < count; i++) {
      uint32_t at = lab_ray_of_slot(lab, rays[i].slot);
      OraclePoint point = lab_oracle_point(oracle, &hits[at], NULL);
      const Light *from = &oracle->model->lights[light];
      OracleArrival arrival = oracle_light_at(from, point.position_world);
      Vec3 origin = vec3_from_floats(rays[i].origin), away = vec3_sub(origin, point.position_world);
      assert_memory_equal(rays[i].weight, open[at], 3 * sizeof(float));
      assert_true(vec3_dot(away, point.geometric_world) > 0 && vec3_length(away) < 1e-5);
      if (from->kind == LIGHT_DIRECTIONAL) {
        assert_true(isinf(rays[i].t_max));
        assert_close(rays[i].direction, arrival.direction, 0, 1e-6, "shadow ray", at);
      } else {
        assert_true(rays[i].t_max == 1);
        assert_close(rays[i].direction, vec3_sub(from->position_world, origin), 0, 1e-6, "shadow ray", at);
      }
    }
    free(rays);
  }
}

static void shadow_rays_carry_what_the_light_would_add(void **state) { for_each_width(shadow_rays_check); }

// Mirrors alone reflect, along 2 (n.v) n - v with the model's reflectance, unless that is under 1/255 in every channel.
static void reflected_rays_check(ShadeLab *lab, const OracleScene *oracle, const LabHit hits[HITS])
{
  for (uint32_t model = LIGHTING_MODEL_PBR; model <= LIGHTING_MODEL_PHONG; model++) {
    ShadeInfo info = {.model = model, .first_batch = 1, .reflect = 1, .min_weight = 1.0f / 255};
    lab_shade(NULL, lab, &info);
    uint32_t count = lab->counts[STREAM_COUNT_REFLECTED], bent = 0;
    LabRay *rays = lab_reflected_rays(lab);
    assert_int_equal(count, (SURFACES - MIRROR) * VIEWS);
    for (uint32_t i = 0; i < count; i++) {
      Vec3 view;
      uint32_t at = lab_ray_of_slot(lab, rays[i].slot);
      OraclePoint point = lab_oracle_point(oracle, &hits[at], &view);
      double n_dot_v = vec3_dot(point.normal_world, view);
      Vec3 weight =
          oracle_reflectance(model == LIGHTING_MODEL_PHONG ? ORACLE_PHONG : ORACLE_PBR, &point.surface, n_dot_v);
      Vec3 away = vec3_sub(vec3_from_floats(rays[i].origin), point.position_world);
      Vec3 mirrored = vec3_sub(vec3_scale(point.normal_world, 2 * n_dot_v), view);
      double n_dot_g = vec3_dot(point.geometric_world, view);
      if (vec3_dot(mirrored, point.geometric_world) <= 0) {  // then at the triangle's plane
        mirrored = vec3_sub(vec3_scale(point.geometric_world, 2 * n_dot_g), view);
        bent++;
      }
      assert_int_not_equal(point.surface.roughness > 0, true);
      assert_true(isinf(rays[i].t_max));
      assert_true(vec3_dot(away, point.geometric_world) > 0 && vec3_length(away) < 1e-5);
      assert_close(rays[i].direction, mirrored, 0, 1e-6, "reflected ray", at);
      assert_close(rays[i].weight, weighted(weight, &hits[at]), 2e-6, 0, "reflected ray", at);
    }
    assert_true(bent > 0 && bent < VIEWS);
    free(rays);
    info.reflect = 0;
    lab_shade(NULL, lab, &info);
    assert_int_equal(lab->counts[STREAM_COUNT_REFLECTED], 0);
  }
}

static void mirrors_send_rays_on_with_their_reflectance(void **state) { for_each_width(reflected_rays_check); }

static void throughput_is_cut_at_the_least_weight(void **state)
{
  Scene scene = surfaces_scene();
  ShadeLab lab = lab_open(&scene, 0);
  LabHit hits[HITS];
  surfaces_hits(hits);
  uint32_t expected = 0;
  for (uint32_t i = 0; i < HITS; i++) {  // phong's ks of this metal is its base colour: 0.8, 0.5, 0.1
    float weight = (i & 1 ? 1.001f : 0.999f) / 255 / 0.8f;
    hits[i] = hits[METAL_MIRROR * VIEWS + i % VIEWS];
    memcpy(hits[i].weight, (float[3]){weight, 0, 0}, sizeof hits[i].weight);
    expected += i & 1;
  }
  lab_set_hits(&lab, hits, HITS);
  ShadeInfo info = {.model = LIGHTING_MODEL_PHONG, .first_batch = 1, .reflect = 1, .min_weight = 1.0f / 255};
  lab_shade(NULL, &lab, &info);
  assert_int_equal(lab.counts[STREAM_COUNT_REFLECTED], expected);
  lab_close(&lab);
  scene_free(&scene);
}

// Of a BLEND surface alpha is seen, and 1 - alpha goes on behind it, unless that is under the least share.
static void blend_lets_the_rest_through(void **state)
{
  Scene scene = surfaces_scene();
  LabHit hits[HITS];
  surfaces_hits(hits);
  for (uint32_t i = 0; i < scene.material_count; i++) {
    scene.materials[i].alpha_mode = ALPHA_BLEND;
    scene.materials[i].base_color[3] = i == UNLIT ? 0.999f : 0.25f + 0.1f * (float)i;
  }
  OracleScene oracle = oracle_scene_from_model(&scene);
  for (size_t width = 0; width < LAB_WIDTHS; width++) {
    ShadeLab lab = lab_open(&scene, lab_widths[width]);
    float got[HITS][4];
    lab_set_hits(&lab, hits, HITS);
    ShadeInfo info = {
        .model = LIGHTING_MODEL_PHONG, .first_batch = 1, .ambient = 1, .primary = 1, .min_transmitted = 1.0f / 256};
    lab_shade(got, &lab, &info);
    LabRay *rays = lab_transmitted_rays(&lab);
    assert_int_equal(lab.counts[STREAM_COUNT_TRANSMITTED], (SURFACES - 1) * VIEWS);
    for (uint32_t i = 0; i < HITS; i++) {
      OraclePoint point = lab_oracle_point(&oracle, &hits[i], NULL);
      Vec3 own = vec3_scale(oracle_own_light(ORACLE_PHONG, &point.surface, 1), point.surface.alpha);
      assert_close(got[i], weighted(own, &hits[i]), 1e-6, 0, "hit", i);
      assert_true(fabs(got[i][3] - point.surface.alpha) <= 1e-6);
    }
    for (uint32_t i = 0; i < lab.counts[STREAM_COUNT_TRANSMITTED]; i++) {
      uint32_t at = lab_ray_of_slot(&lab, rays[i].slot);
      OraclePoint point = lab_oracle_point(&oracle, &hits[at], NULL);
      Vec3 away = vec3_sub(vec3_from_floats(rays[i].origin), point.position_world);
      double rest = 1 - point.surface.alpha;
      assert_close(rays[i].weight, weighted(vec3(rest, rest, rest), &hits[at]), 1e-6, 0, "transmitted ray", at);
      assert_close(rays[i].direction, vec3_from_floats(hits[at].direction), 0, 0, "transmitted ray", at);
      assert_true(vec3_dot(away, point.geometric_world) < 0 && vec3_length(away) < 1e-5);
    }
    free(rays);
    lab_close(&lab);
  }
  oracle_scene_free(&oracle);
  scene_free(&scene);
}

// Roughness may be any number in a file: no highlight may be infinite or no number, its centre least of all.
static void no_roughness_breaks_a_highlight(void **state)
{
  enum { STEPS = 40 };
  Scene scene = scene_empty();
  const Vec3 corners[3] = {vec3(-1, -1, 0), vec3(1, -1, 0), vec3(0, 1, 0)}, up = vec3(0, 0, 1);
  LabHit hits[2 * STEPS];
  for (uint32_t i = 0; i < STEPS; i++) {
    int material = scene_add_material(&scene, material_plain(vec3(1, 1, 1), 1, pow(10, -(double)i)));
    scene_add_triangle(&scene, material, corners, (const Vec3[3]){up, up, up});
    hits[2 * i] = (LabHit){.triangle = i, .u = 0.25f, .v = 0.25f, .direction = {0, 0, -1}, .weight = {1, 1, 1}};
    hits[2 * i + 1] = hits[2 * i];
    memcpy(hits[2 * i + 1].direction, (float[3]){-0.6f, 0, -0.8f}, sizeof hits->direction);
  }
  scene_add_light(&scene, light_directional(vec3(0, 0, -1), 1));
  scene_add_light(&scene, light_directional(vec3(0.6, 0, -0.8), 1));
  for (size_t width = 0; width < LAB_WIDTHS; width++) {
    ShadeLab lab = lab_open(&scene, lab_widths[width]);
    lab_set_hits(&lab, hits, 2 * STEPS);
    for (uint32_t model = LIGHTING_MODEL_PBR; model <= LIGHTING_MODEL_PHONG; model++) {
      float got[2 * STEPS][4];
      ShadeInfo info = {.model = model, .light_count = 2};
      lab_shade(got, &lab, &info);
      for (uint32_t i = 0; i < 2 * STEPS; i++)
        if (!isfinite(got[i][0])) fail_msg("model %u, roughness 1e-%u: %g", model, i / 2, got[i][0]);
    }
    lab_close(&lab);
  }
  scene_free(&scene);
}

// ---- the environment ------------------------------------------------------------------------------------------------

static void random_image_set(Scene *scene)
{
  enum { WIDTH = 16, HEIGHT = 8 };
  float colors[WIDTH * HEIGHT][3];
  uint32_t state = 7;
  for (int i = 0; i < WIDTH * HEIGHT; i++)
    for (int c = 0; c < 3; c++) colors[i][c] = (float)((state = state * 1664525u + 1013904223u) >> 8) / 0x1p24f;
  scene_set_image(scene, WIDTH, HEIGHT, (const float(*)[3])colors);
}

static void gradient_set(Scene *scene)
{
  scene->environment = (Environment){.kind = ENVIRONMENT_GRADIENT,
                                     .zenith = {0.2f, 0.4f, 1},
                                     .horizon = {0.9f, 0.8f, 0.7f},
                                     .ground = {0.1f, 0.2f, 0.05f}};
}

// An environment by its number: constant, gradient, image; the image turned as well.
enum { ENVIRONMENTS = 4 };
static Scene environment_scene(int number)
{
  Scene scene = surfaces_scene();
  if (number == 0) scene_set_constant(&scene, 0.3, 0.2, 0.1);
  if (number == 1) gradient_set(&scene);
  if (number > 1) random_image_set(&scene);
  scene.environment.intensity = 2.5f;
  scene.environment.rotation_rad = number == 3 ? 2.0 : 0;
  return scene;
}

enum { DIRECTIONS = 500 };

// Spread over the sphere, of any length, and along the axes.
static void directions_make(LabHit hits[DIRECTIONS])
{
  for (int i = 0; i < DIRECTIONS; i++) {
    Vec3 d = vec3_scale(lab_polar(1 - (2 * i + 1.0) / DIRECTIONS, 2.4 * i), 0.1 + i % 7);
    if (i < 6) d = vec3(i == 0 ? 1 : i == 1 ? -1 : 0, i == 2 ? 1 : i == 3 ? -1 : 0, i == 4 ? 1 : i == 5 ? -1 : 0);
    hits[i] =
        (LabHit){.triangle = HIT_NONE, .direction = {(float)d.x, (float)d.y, (float)d.z}, .weight = {1, 0.5f, 0.25f}};
  }
}

// 2e-6 of the brightest is what float makes of an angle, times what an image changes by from pixel to pixel.
static void rays_that_miss_see_the_environment(void **state)
{
  LabHit hits[DIRECTIONS];
  directions_make(hits);
  for (int number = 0; number < ENVIRONMENTS; number++) {
    Scene scene = environment_scene(number);
    for (size_t width = 0; width < LAB_WIDTHS; width++) {
      float got[DIRECTIONS][4];
      ShadeLab lab = lab_open(&scene, lab_widths[width]);
      lab_set_hits(&lab, hits, DIRECTIONS);
      ShadeInfo info = {.first_batch = 1, .primary = 1};
      lab_shade(got, &lab, &info);
      for (uint32_t i = 0; i < DIRECTIONS; i++) {
        Vec3 direction = vec3_unit_or(vec3_from_floats(hits[i].direction), vec3(0, 0, 0));
        Vec3 wanted = weighted(oracle_environment(&scene.environment, direction), &hits[i]);
        assert_close(got[i], wanted, 1e-5, 2e-5, "direction", i);
        assert_true(got[i][3] == 0);  // nothing covers it
      }
      lab_close(&lab);
    }
    scene_free(&scene);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(emission_ambient_and_unlit_need_no_light),
      cmocka_unit_test(shadow_rays_carry_what_the_light_would_add),
      cmocka_unit_test(mirrors_send_rays_on_with_their_reflectance),
      cmocka_unit_test(throughput_is_cut_at_the_least_weight),
      cmocka_unit_test(blend_lets_the_rest_through),
      cmocka_unit_test(no_roughness_breaks_a_highlight),
      cmocka_unit_test(rays_that_miss_see_the_environment),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
