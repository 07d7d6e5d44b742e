// The plan: which method finds what camera rays see.

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "plan/plan.h"

static Plan plan_of(PrimaryMethod asked, uint64_t triangles, uint64_t pixels, uint32_t samples, bool gpu)
{
  RenderSettings settings = {.primary = asked, .samples = samples};
  SceneFacts facts = {.triangle_count = triangles, .pixel_count = pixels, .gpu = gpu};
  return plan_make(&settings, &facts);
}

static void the_method_asked_for_is_taken(void **state)
{
  for (int gpu = 0; gpu < 2; gpu++) {
    assert_int_equal(plan_of(PRIMARY_RASTER, 1u << 27, 1, 1, gpu).primary, PRIMARY_RASTER);
    assert_int_equal(plan_of(PRIMARY_RAYS, 1, 1u << 27, 1, gpu).primary, PRIMARY_RAYS);
  }
}

// A million triangles in a thumbnail are slower to draw than its few rays are to trace; a picture with more pixels than
// triangles is quicker to draw.
static void auto_weighs_triangles_against_pixels(void **state)
{
  assert_int_equal(plan_of(PRIMARY_AUTO, 1000000, 100 * 60, 1, false).primary, PRIMARY_RAYS);
  assert_int_equal(plan_of(PRIMARY_AUTO, 1000000, 1920 * 1080, 1, false).primary, PRIMARY_RASTER);
  assert_int_equal(plan_of(PRIMARY_AUTO, 10000, 320 * 180, 1, false).primary, PRIMARY_RASTER);
  assert_int_equal(plan_of(PRIMARY_AUTO, 0, 0, 1, false).primary, PRIMARY_RAYS);
}

// Costs are there for the report, grow with the work, and the cheaper is what auto takes.
static void auto_takes_what_is_predicted_to_be_cheaper(void **state)
{
  for (uint64_t triangles = 1; triangles < 1u << 24; triangles *= 7) {
    for (uint64_t pixels = 1; pixels < 1u << 26; pixels *= 11) {
      for (int gpu = 0; gpu < 2; gpu++) {
        Plan plan = plan_of(PRIMARY_AUTO, triangles, pixels, 2, gpu);
        Plan more = plan_of(PRIMARY_AUTO, triangles, 2 * pixels, 2, gpu);
        bool raster = plan.primary_cost.raster_ms < plan.primary_cost.rays_ms;
        assert_int_equal(plan.primary, raster ? PRIMARY_RASTER : PRIMARY_RAYS);
        assert_true(more.primary_cost.raster_ms > plan.primary_cost.raster_ms);
        assert_true(more.primary_cost.rays_ms > plan.primary_cost.rays_ms);
      }
    }
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_method_asked_for_is_taken),
      cmocka_unit_test(auto_weighs_triangles_against_pixels),
      cmocka_unit_test(auto_takes_what_is_predicted_to_be_cheaper),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
