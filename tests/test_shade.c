// Lights on surfaces: cl/shade/shade.cl on hits made by hand, against plain C in double precision.
//
// "Within 1e-4" means: |kernel - oracle| <= 1e-4 |oracle| + 1e-9 of the light that arrives + what the oracle itself
// changes by when its inputs move by as much as float arithmetic moves them (points by 2e-6 of their coordinates;
// components of unit vectors, and the cosines of cones, by 2^-22). The last term is no excuse where a picture would
// show it: tame cases, all but grazing angles, narrow lobes, the borders of cones and ranges, and what is less than a
// thousandth of the light, must do with as much again as the first.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "scene/scene_build.h"
#include "support/shade_lab.h"

static const double metallics[] = {0, 0.5, 1}, roughnesses[] = {0, 0.05, 0.1, 0.25, 0.5, 0.75, 1};
static const double cosines_v[] = {1, 0.7, 0.3, 0.1, 0.01, 0.001}, cosines_l[] = {1, 0.7, 0.3, 0.1, 0.01, 0.001, -0.1};

#define COUNT_OF(array) (sizeof(array) / sizeof *(array))
enum { BENT = 1, SIDES = 3 };  // a material's triangles: flat, with bent normals, seen from behind
enum { HITS_MAX = 1024 };

static Vec3 corner_at(int i) { return vec3(i == 1 ? 1.2 : -1 + 0.4 * i, i == 2 ? 1.1 : -0.8 + 0.1 * i, 0.3); }

static void lights_add(Scene *scene)
{
  for (size_t i = 0; i < COUNT_OF(cosines_l); i++)
    for (int turn = 0; turn < 3; turn++)
      scene_add_light(scene, light_directional(vec3_neg(lab_polar(cosines_l[i], M_PI * (1 - 0.45 * turn))), 3));
  const Vec3 places[] = {vec3(0.3, 0.2, 0.9), vec3(2, 1, 4), vec3(-3, 0.5, 0.4), vec3(0.1, 0.1, 0.32), vec3(0, 0, -1)};
  for (size_t i = 0; i < COUNT_OF(places); i++) {
    Light light = light_point(places[i], 5);
    scene_add_light(scene, light);
    light.range_m = 2;
    scene_add_light(scene, light);
    scene_add_light(scene, light_spot(places[i], vec3(0.2, 0, 0.3), 7, M_PI / 9, 0.6));
    scene_add_light(scene, light_spot(places[i], vec3(-0.3, 0.3, 0.3), 7, 0, M_PI / 2));
  }
  for (uint32_t i = 0; i < scene->light_count; i++) {
    scene->lights[i].color[1] = 0.8f;
    scene->lights[i].color[2] = 0.5f;
  }
}

// Every material three times over.
static Scene grid_scene(void)
{
  Scene scene = scene_empty();
  const Vec3 corners[3] = {corner_at(0), corner_at(1), corner_at(2)}, up = vec3(0, 0, 1);
  for (size_t m = 0; m < COUNT_OF(metallics); m++) {
    for (size_t r = 0; r < COUNT_OF(roughnesses); r++) {
      Material material = material_plain(vec3(0.9, 0.6, 0.02), metallics[m], roughnesses[r]);
      material.emission[1] = 0.25f;
      int at = scene_add_material(&scene, material);
      for (int side = 0; side < SIDES; side++) {
        Vec3 normals[3] = {up, up, up};
        for (int i = 0; i < 3 && side == BENT; i++) normals[i] = lab_polar(0.9 - 0.25 * i, 2.2 * i);
        scene_add_triangle(&scene, at, corners, normals);
      }
    }
  }
  lights_add(&scene);
  return scene;
}

static uint32_t grid_hits(LabHit *hits, const Scene *scene)
{
  uint32_t count = 0;
  for (uint32_t triangle = 0; triangle < scene->object_count; triangle++) {
    for (size_t i = 0; i < 2 * COUNT_OF(cosines_v); i++) {
      Vec3 to_eye = lab_polar(cosines_v[i / 2], 0);
      double length = 0.5 + i, back = triangle % SIDES == 2 ? -1 : 1;
      assert_true(count < HITS_MAX);
      hits[count++] = (LabHit){
          .triangle = triangle,
          .u = (float)(0.05 + 0.06 * (double)i),
          .v = (float)(0.25 - 0.02 * (double)i),
          .direction = {(float)(-length * to_eye.x), (float)(-length * to_eye.y), (float)(-back * length * to_eye.z)},
          .weight = {1, 0.5f, 0.25f}};
    }
  }
  return count;
}

// Everything that a light's share depends on.
typedef struct Inputs {
  OracleModel model;
  OraclePoint point;
  Vec3 view;
  Light light;
  Vec3 shift;  // added to the direction to the light
} Inputs;

static Vec3 share_of(const Inputs *in)
{
  OracleArrival arrival = oracle_light_at(&in->light, in->point.position_world);
  arrival.direction = vec3_add(arrival.direction, in->shift);
  return oracle_direct(in->model, &in->point.surface, in->point.normal_world, in->point.geometric_world, in->view,
                       &arrival);
}

static void spread_add(Vec3 *spread, Vec3 at, const Inputs *moved)
{
  Vec3 there = share_of(moved);
  *spread = vec3_add(*spread, vec3(fabs(there.x - at.x), fabs(there.y - at.y), fabs(there.z - at.z)));
}

// What the share changes by, summed over the inputs.
static Vec3 spread_of(const Inputs *in)
{
  Vec3 at = share_of(in), spread = {0}, p = in->point.position_world;
  const double angle = 0x1p-22;
  const Vec3 axes[3] = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
  for (int axis = 0; axis < 3; axis++) {
    Vec3 step = vec3_scale(axes[axis], angle);
    double reach = fabs(vec3_dot(p, axes[axis])) + fabs(vec3_dot(in->light.position_world, axes[axis]));
    Inputs moved = *in;
    moved.point.position_world = vec3_add(p, vec3_scale(axes[axis], 2e-6 * reach));
    spread_add(&spread, at, &moved);
    moved = *in;
    moved.shift = step;
    spread_add(&spread, at, &moved);
    moved = *in;
    moved.view = vec3_add(in->view, step);
    spread_add(&spread, at, &moved);
    moved = *in;
    moved.point.normal_world = vec3_unit_or(vec3_add(in->point.normal_world, step), step);
    spread_add(&spread, at, &moved);
  }
  if (in->light.kind == LIGHT_SPOT) {
    Inputs moved = *in;
    moved.light.inner_cone_rad = acos(fmin(1, cos(in->light.inner_cone_rad) - angle));
    moved.light.outer_cone_rad = acos(cos(in->light.outer_cone_rad) - angle);
    spread_add(&spread, at, &moved);
  }
  return spread;
}

static bool is_tame(const Inputs *in, double share)
{
  OracleArrival arrival = oracle_light_at(&in->light, in->point.position_world);
  Vec3 n = in->point.normal_world;
  double full = in->light.intensity / (isfinite(arrival.distance_m) ? arrival.distance_m * arrival.distance_m : 1);
  return in->point.surface.roughness >= 0.2 && vec3_dot(n, in->view) >= 0.05 &&
         vec3_dot(n, arrival.direction) >= 0.05 && vec3_dot(in->point.geometric_world, arrival.direction) >= 0.05 &&
         arrival.irradiance.x > 0.1 * full && share > 1e-3 * full;
}

typedef struct Tally {
  uint32_t compared, lit, tame;
  double worst_tame;  // relative error
} Tally;

static double channel_of(Vec3 v, int channel) { return channel == 0 ? v.x : channel == 1 ? v.y : v.z; }

static void share_check(Tally *tally, const Inputs *in, const LabHit *hit, const float got[4], uint32_t light)
{
  Vec3 want = share_of(in), spread = spread_of(in);
  double floor = 1e-9 * oracle_light_at(&in->light, in->point.position_world).irradiance.x;
  for (int channel = 0; channel < 3; channel++) {
    double weight = hit->weight[channel], wanted = weight * channel_of(want, channel);
    double moved = weight * channel_of(spread, channel), error = fabs(got[channel] - wanted);
    bool tame = is_tame(in, channel_of(want, channel));
    tally->compared++;
    tally->lit += wanted > 0;
    if (!(error <= 1e-4 * wanted + moved + floor) || (tame && moved > 1e-4 * wanted))
      fail_msg("triangle %u (roughness %g, metallic %g), n.v %g, light %u, channel %d: %.9g, not %.9g (moves by %.2g)",
               hit->triangle, in->point.surface.roughness, in->point.surface.metallic,
               vec3_dot(in->point.normal_world, in->view), light, channel, got[channel], wanted, moved);
    if (!tame || !(wanted > 0)) continue;
    tally->tame++;
    tally->worst_tame = fmax(tally->worst_tame, error / wanted);
  }
}

// Shades by one light at a time.
static Tally model_check(ShadeLab *lab, const OracleScene *oracle, const LabHit *hits, uint32_t model)
{
  Tally tally = {0};
  float(*got)[4] = oracle_array(lab->count, sizeof *got);
  for (uint32_t light = 0; light < oracle->model->light_count; light++) {
    ShadeInfo info = {.model = model, .first_light = light, .light_count = 1};
    lab_shade(got, lab, &info);
    for (uint32_t i = 0; i < lab->count; i++) {
      Inputs in = {.model = model == LIGHTING_MODEL_PHONG ? ORACLE_PHONG : ORACLE_PBR,
                   .light = oracle->model->lights[light]};
      in.point = lab_oracle_point(oracle, &hits[i], &in.view);
      share_check(&tally, &in, &hits[i], got[i], light);
      if (got[i][3] != 0) fail_msg("a light adds %g of coverage", got[i][3]);
    }
  }
  free(got);
  return tally;
}

static void lights_agree_with_double_precision(uint32_t model)
{
  LabHit hits[HITS_MAX];
  Scene scene = grid_scene();
  OracleScene oracle = oracle_scene_from_model(&scene);
  uint32_t count = grid_hits(hits, &scene);
  for (size_t i = 0; i < LAB_WIDTHS; i++) {
    ShadeLab lab = lab_open(&scene, lab_widths[i]);
    lab_set_hits(&lab, hits, count);
    Tally tally = model_check(&lab, &oracle, hits, model);
    print_message("LANES %u: %u values, %u lit, %u tame ones within %.2g\n", lab_widths[i], tally.compared, tally.lit,
                  tally.tame, tally.worst_tame);
    assert_true(tally.lit > tally.compared / 4 && tally.tame > tally.compared / 20);
    lab_close(&lab);
  }
  oracle_scene_free(&oracle);
  scene_free(&scene);
}

static void pbr_agrees_with_double_precision(void **state) { lights_agree_with_double_precision(LIGHTING_MODEL_PBR); }
static void phong_agrees_with_double_precision(void **state)
{
  lights_agree_with_double_precision(LIGHTING_MODEL_PHONG);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pbr_agrees_with_double_precision),
      cmocka_unit_test(phong_agrees_with_double_precision),
  };
  return cmocka_run_group_tests(tests, picture_tests_begin, picture_tests_end);
}
