// What is planned: no more than the scene needs, and what the samples are enough for.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include <math.h>

#include "plan/plan.h"

// As without options.
static RenderSettings settings_of(uint32_t samples)
{
  return (RenderSettings){.samples = samples,
                          .shadows = SHADOWS_RAYS,
                          .reflections = REFLECTIONS_RAYS,
                          .max_depth = 8,
                          .max_roughness = MAX_ROUGHNESS_AUTO};
}

// Rough surfaces and a mirror under a light and an environment.
static const SceneFacts all = {
    .light_count = 1, .has_mirrors = true, .least_roughness = 0.3f, .environment_lights = true};

static void few_samples_get_no_noise(void **state)
{
  RenderSettings settings = settings_of(SAMPLED_FROM - 1);
  Plan plan = plan_make(&settings, &all);
  assert_int_equal(plan.environment_light, ENVIRONMENT_LIGHT_SH);
  assert_true(plan.max_roughness == 0 && !plan.lobes && plan.reflected_rays);
}

static void many_samples_get_the_right_picture(void **state)
{
  RenderSettings settings = settings_of(SAMPLED_FROM);
  Plan plan = plan_make(&settings, &all);
  assert_int_equal(plan.environment_light, ENVIRONMENT_LIGHT_SAMPLED);
  assert_true(plan.max_roughness == 1 && plan.lobes && plan.max_depth == 8);
}

static void who_asks_for_exact_methods_gets_them_at_any_number_of_samples(void **state)
{
  RenderSettings settings = settings_of(1);
  settings.methods = METHODS_EXACT;
  Plan plan = plan_make(&settings, &all);
  assert_int_equal(plan.environment_light, ENVIRONMENT_LIGHT_SAMPLED);
  assert_true(plan.max_roughness == 1);
  settings.methods = METHODS_AUTO;
  settings.environment_light = ENVIRONMENT_LIGHT_SAMPLED;
  assert_true(plan_make(&settings, &all).max_roughness == 1);
}

static void what_is_named_is_done(void **state)
{
  RenderSettings settings = settings_of(64);
  settings.environment_light = ENVIRONMENT_LIGHT_SH_AO;
  settings.max_roughness = 0;
  Plan plan = plan_make(&settings, &all);
  assert_int_equal(plan.environment_light, ENVIRONMENT_LIGHT_SH_AO);
  assert_true(plan.max_roughness == 0 && !plan.lobes);
}

static void phong_has_neither_lobes_nor_environment_light(void **state)
{
  RenderSettings settings = settings_of(64);
  settings.lighting = LIGHTING_PHONG;
  Plan plan = plan_make(&settings, &all);
  assert_int_equal(plan.environment_light, ENVIRONMENT_LIGHT_NONE);
  assert_true(plan.max_roughness == 0 && !plan.lobes && plan.reflected_rays);
}

// A black environment needs no light of it; surfaces rougher than what reflects, or mirrors alone, no samples.
static void what_the_scene_lacks_is_left_out(void **state)
{
  RenderSettings settings = settings_of(64);
  SceneFacts facts = {.light_count = 1, .least_roughness = 0.5f};
  Plan plan = plan_make(&settings, &facts);
  assert_int_equal(plan.environment_light, ENVIRONMENT_LIGHT_NONE);
  assert_true(plan.lobes && plan.reflected_rays);
  settings.max_roughness = 0.25f;
  plan = plan_make(&settings, &facts);
  assert_true(!plan.lobes && !plan.reflected_rays && plan.max_depth == 0);
  settings.max_roughness = 1;
  facts = (SceneFacts){.has_mirrors = true, .least_roughness = INFINITY};
  plan = plan_make(&settings, &facts);
  assert_true(!plan.lobes && plan.reflected_rays && plan.max_roughness == 0 && !plan.shadow_rays);
  settings.reflections = REFLECTIONS_NONE;
  assert_true(!plan_make(&settings, &all).reflected_rays && plan_make(&settings, &all).max_roughness == 0);
}

// Deeper bounces go by the first's method unless told otherwise; with none of them one bounce is all.
static void deeper_bounces_have_a_method_of_their_own(void **state)
{
  RenderSettings settings = settings_of(SAMPLED_FROM);
  settings.reflections = REFLECTIONS_CUBE;
  Plan plan = plan_make(&settings, &all);
  assert_true(plan.reflections == REFLECTIONS_CUBE && plan.deep_reflections == REFLECTIONS_CUBE);
  assert_true(plan.max_depth == 8 && plan.max_roughness == 0 && plan_uses_cubes(&plan));
  settings.deep_reflections = REFLECTIONS_RAYS;
  plan = plan_make(&settings, &all);
  assert_int_equal(plan_reflections(&plan, 1), REFLECTIONS_CUBE);
  assert_int_equal(plan_reflections(&plan, 2), REFLECTIONS_RAYS);
  settings.reflections = REFLECTIONS_RAYS;
  settings.deep_reflections = REFLECTIONS_NONE;
  plan = plan_make(&settings, &all);
  assert_true(plan.max_depth == 1 && plan.max_roughness == 1 && !plan_uses_cubes(&plan));
  for (ReflectionMethod method = REFLECTIONS_NONE; method <= REFLECTIONS_RAYS; method++) {
    settings.reflections = method;
    settings.deep_reflections = REFLECTIONS_LIKE_FIRST;
    plan = plan_make(&settings, &all);
    bool lists = method >= REFLECTIONS_SNAPSHOT && method <= REFLECTIONS_MIXED;
    assert_int_equal(plan_uses_lists(&plan), lists);
    assert_int_equal(plan_uses_cubes(&plan), lists || (method >= REFLECTIONS_CUBE && method <= REFLECTIONS_IMPOSTOR));
  }
  SceneFacts matt = {.least_roughness = 1};
  settings.reflections = settings.deep_reflections = REFLECTIONS_IMPOSTOR;
  plan = plan_make(&settings, &matt);
  assert_true(plan.reflections == REFLECTIONS_NONE && !plan_uses_cubes(&plan));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(deeper_bounces_have_a_method_of_their_own),
      cmocka_unit_test(few_samples_get_no_noise),
      cmocka_unit_test(many_samples_get_the_right_picture),
      cmocka_unit_test(who_asks_for_exact_methods_gets_them_at_any_number_of_samples),
      cmocka_unit_test(what_is_named_is_done),
      cmocka_unit_test(phong_has_neither_lobes_nor_environment_light),
      cmocka_unit_test(what_the_scene_lacks_is_left_out),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
