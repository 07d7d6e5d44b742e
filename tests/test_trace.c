// Closest hits against every triangle in double precision: each kernel at each width, over soups that are hard to hit.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/parallel.h"
#include "support/effort.h"
#include "support/trace_rays.h"

// For each soup; no multiple of any width.
static uint32_t ray_count;

typedef struct Check {
  TraceFixture fixture;
  TraceRay *rays;
  OracleHit *truth;
  TraceHit *hits[TRACE_KERNELS];
  OracleVerdict *verdicts;
} Check;

static void check_begin(Check *check, const Soup *soup)
{
  OracleRay *oracle_rays = oracle_array(ray_count, sizeof *oracle_rays);
  check->rays = oracle_array(ray_count, sizeof *check->rays);
  check->truth = oracle_array(ray_count, sizeof *check->truth);
  check->verdicts = oracle_array(ray_count, sizeof *check->verdicts);
  trace_rays_make(check->rays, ray_count, soup, soup->triangle_count);
  trace_fixture_make(&check->fixture, soup);
  for (uint32_t i = 0; i < ray_count; i++) oracle_rays[i] = trace_oracle_ray(&check->rays[i], true);
  oracle_closest_all(check->truth, &check->fixture.oracle, oracle_rays, ray_count);
  for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
    check->hits[kernel] = oracle_array(ray_count, sizeof *check->hits[kernel]);
    trace_fixture_closest(check->hits[kernel], &check->fixture, (TraceKernel)kernel, check->rays, ray_count, 0);
  }
  free(oracle_rays);
}

static void check_end(Check *check)
{
  for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) free(check->hits[kernel]);
  trace_fixture_free(&check->fixture);
  free(check->rays);
  free(check->truth);
  free(check->verdicts);
}

static void ray_judge(void *context, size_t i)
{
  const Check *check = context;
  const TraceHit *hit = &check->hits[0][i];
  OracleRay ray = trace_oracle_ray(&check->rays[i], true);
  OracleHit claim = {.triangle = hit->triangle, .t = hit->t, .u = hit->u, .v = hit->v};
  check->verdicts[i] = oracle_judge(&check->fixture.oracle, &ray, &check->truth[i], &claim, TRACE_ROUNDING);
}

static void hit_print(const Check *check, const char *what, int kernel, uint32_t i)
{
  const TraceRay *ray = &check->rays[i];
  const OracleHit *truth = &check->truth[i];
  const TraceHit *hit = &check->hits[kernel][i];
  trace_ray_print(what, ray, i);
  printf("  truth: %u at %.9g (%.9g %.9g), margin %g; %s: %u at %.9g (%.9g %.9g)\n", truth->triangle, truth->t,
         truth->u, truth->v, truth->margin, trace_kernel_names[kernel], hit->triangle, hit->t, hit->u, hit->v);
}

// Judges one kernel's hits; those of the others must have the same bits. Frees the soup.
static void assert_soup(Soup *soup)
{
  Check check;
  uint32_t verdicts[3] = {0}, differ = 0, hits = 0;
  check_begin(&check, soup);
  parallel_for(ray_count, ray_judge, &check);
  for (uint32_t i = 0; i < ray_count; i++) {
    if (++verdicts[check.verdicts[i]] <= 3 && check.verdicts[i] == ORACLE_WRONG) hit_print(&check, "wrong", 0, i);
    hits += check.hits[0][i].triangle != ORACLE_MISS;
    for (int kernel = 1; kernel < TRACE_KERNELS; kernel++) {
      if (!memcmp(&check.hits[kernel][i], &check.hits[0][i], sizeof(TraceHit))) continue;
      if (++differ > 3) continue;
      hit_print(&check, "differs", 0, i);
      hit_print(&check, "differs", kernel, i);
    }
  }
  printf("%u triangles, %u hits: %u same, %u ties, %u wrong, %u differ\n", soup->triangle_count, hits,
         verdicts[ORACLE_SAME], verdicts[ORACLE_TIE], verdicts[ORACLE_WRONG], differ);
  check_end(&check);
  soup_free(soup);
  assert_int_equal(verdicts[ORACLE_WRONG], 0);
  assert_int_equal(differ, 0);
  // Half of the rays are aimed at edges, corners and planes. A judge that excused everything would show here.
  assert_in_range(verdicts[ORACLE_SAME], ray_count / 2, ray_count);
  assert_in_range(hits, ray_count / 8, ray_count);
}

static void large_triangles_are_hit_where_double_precision_says(void **state)
{
  Soup soup = {0};
  soup_random(&soup, 1000, 1, 0.2f, 1);
  for (uint32_t i = 0; i < soup.triangle_count; i++) soup.flags[i] = i % 3 == 0;
  assert_soup(&soup);
}

static void small_triangles_are_hit_where_double_precision_says(void **state)
{
  Soup soup = {0};
  soup_random(&soup, 1000, 10, 0.01f, 2);
  assert_soup(&soup);
}

static void bumpy_sphere_is_hit_where_double_precision_says(void **state)
{
  static const float center[3] = {1, -2, 3};
  Soup soup = {0};
  soup_sphere(&soup, 16, 2, center, 0.3f);
  for (uint32_t i = 0; i < soup.triangle_count; i++) soup.flags[i] = 1;
  assert_soup(&soup);
}

static void slivers_are_hit_where_double_precision_says(void **state)
{
  Soup soup = {0};
  soup_slivers(&soup, 400, 3);
  assert_soup(&soup);
}

static void triangles_far_from_the_origin_are_hit_where_double_precision_says(void **state)
{
  Soup soup = {0};
  soup_far(&soup, 1000, 4);
  assert_soup(&soup);
}

static void overlapping_coplanar_triangles_are_hit_where_double_precision_says(void **state)
{
  Soup soup = {0};
  soup_coplanar(&soup, 60, 1.5f, 5);
  assert_soup(&soup);
}

// As above, turned: rounding lays them some 10^-7 apart.
static void overlapping_tilted_triangles_are_hit_where_double_precision_says(void **state)
{
  Soup soup = {0};
  soup_coplanar(&soup, 60, 1.5f, 5);
  for (uint32_t i = 0; i < soup.vertex_count; i++) {
    float *p = soup.positions[i], x = p[0], y = p[1], z = p[2];
    p[0] = 0.6f * x - 0.64f * y + 0.48f * z;
    p[1] = 0.8f * x + 0.48f * y - 0.36f * z;
    p[2] = 0.6f * y + 0.8f * z;
  }
  assert_soup(&soup);
}

static void planes_on_a_lattice_are_hit_where_double_precision_says(void **state)
{
  Soup soup = {0};
  soup_axis(&soup, 5);
  assert_soup(&soup);
}

static void box_on_a_lattice_is_hit_where_double_precision_says(void **state)
{
  static const float low[3] = {-1, 0, -2}, high[3] = {4, 1, 2};
  Soup soup = {0};
  soup_grid(&soup, 8, low, high);
  assert_soup(&soup);
}

static void few_triangles_are_hit_where_double_precision_says(void **state)
{
  Soup soup = {0};
  soup_random(&soup, 1, 1, 1, 6);
  assert_soup(&soup);
  soup_random(&soup, 9, 1, 1, 7);
  assert_soup(&soup);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(large_triangles_are_hit_where_double_precision_says),
      cmocka_unit_test(small_triangles_are_hit_where_double_precision_says),
      cmocka_unit_test(bumpy_sphere_is_hit_where_double_precision_says),
      cmocka_unit_test(slivers_are_hit_where_double_precision_says),
      cmocka_unit_test(triangles_far_from_the_origin_are_hit_where_double_precision_says),
      cmocka_unit_test(overlapping_coplanar_triangles_are_hit_where_double_precision_says),
      cmocka_unit_test(overlapping_tilted_triangles_are_hit_where_double_precision_says),
      cmocka_unit_test(planes_on_a_lattice_are_hit_where_double_precision_says),
      cmocka_unit_test(box_on_a_lattice_is_hit_where_double_precision_says),
      cmocka_unit_test(few_triangles_are_hit_where_double_precision_says),
  };
  ray_count = effort_is_quick() ? 20001 : 100001;
  return cmocka_run_group_tests_name("trace", tests, NULL, NULL);
}
