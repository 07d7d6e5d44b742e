// Any hit against every triangle in double precision, and what the two kinds of rays make of a triangle's sides and of
// alpha MASK: each kernel at each width.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "shared/bvh.h"
#include "support/effort.h"
#include "support/trace_rays.h"

static uint32_t ray_count;  // for each soup

// Every ray is lit where the oracle says so, or where rounding excuses the other answer, and by all kernels alike.
// Frees the soup.
static void assert_lit_as_oracle(Soup *soup)
{
  TraceFixture fixture;
  TraceRay *rays = oracle_array(ray_count, sizeof *rays);
  OracleRay *oracle_rays = oracle_array(ray_count, sizeof *oracle_rays);
  double *truth = oracle_array(ray_count, sizeof *truth), *margins = oracle_array(ray_count, sizeof *margins);
  bool *lit = oracle_array(ray_count, sizeof *lit), *other = oracle_array(ray_count, sizeof *other);
  uint32_t wrong = 0, sure = 0, lit_count = 0, differ = 0;
  trace_rays_make(rays, ray_count, soup, 100 + soup->triangle_count);
  trace_fixture_make(&fixture, soup);
  for (uint32_t i = 0; i < ray_count; i++) oracle_rays[i] = trace_oracle_ray(&rays[i], false);
  oracle_lit_all(truth, margins, &fixture.oracle, oracle_rays, ray_count);
  trace_fixture_lit(lit, &fixture, TRACE_PACKET_16, rays, ray_count);
  for (uint32_t i = 0; i < ray_count; i++) {
    bool active = rays[i].t_max > 0, expected = active && truth[i] > 0;
    lit_count += lit[i];
    bool unsure = active && margins[i] <= TRACE_ROUNDING;
    sure += !unsure;
    if (unsure || lit[i] == expected) continue;
    trace_ray_print(lit[i] ? "wrongly lit" : "wrongly blocked", &rays[i], i);
    wrong++;
  }
  for (int kernel = 1; kernel < TRACE_KERNELS; kernel++) {
    trace_fixture_lit(other, &fixture, (TraceKernel)kernel, rays, ray_count);
    for (uint32_t i = 0; i < ray_count; i++) {
      if (other[i] == lit[i]) continue;
      trace_ray_print(trace_kernel_names[kernel], &rays[i], i);
      differ++;
    }
  }
  printf("%u triangles: %u of %u lit, %u sure, %u wrong, %u differ\n", soup->triangle_count, lit_count, ray_count, sure,
         wrong, differ);
  trace_fixture_free(&fixture);
  free(rays);
  free(oracle_rays);
  free(truth);
  free(margins);
  free(lit);
  free(other);
  soup_free(soup);
  assert_int_equal(wrong, 0);
  assert_int_equal(differ, 0);
  assert_in_range(lit_count, ray_count / 20, ray_count - ray_count / 20);
  assert_in_range(sure, ray_count / 5, ray_count);
}

static void blocked_where_double_precision_says(void **state)
{
  static const float center[3] = {1, -2, 3};
  Soup soup = {0};
  soup_random(&soup, 500, 1, 0.2f, 1);
  assert_lit_as_oracle(&soup);
  soup_sphere(&soup, 16, 2, center, 0.3f);
  assert_lit_as_oracle(&soup);
  soup_slivers(&soup, 400, 3);
  assert_lit_as_oracle(&soup);
  soup_far(&soup, 500, 4);
  assert_lit_as_oracle(&soup);
  soup_coplanar(&soup, 60, 1.5f, 5);
  assert_lit_as_oracle(&soup);
  soup_axis(&soup, 4);
  assert_lit_as_oracle(&soup);
}

static void single_sided_triangles_block_from_either_side(void **state)
{
  Soup soup = {0};
  soup_random(&soup, 500, 1, 0.2f, 1);
  for (uint32_t i = 0; i < soup.triangle_count; i++) soup.flags[i] = TRIANGLE_SINGLE_SIDED;
  assert_lit_as_oracle(&soup);
}

static void masked_triangles_block_where_their_texture_is_opaque(void **state)
{
  Soup soup = {0};
  soup_random(&soup, 500, 1, 0.2f, 1);
  for (uint32_t i = 0; i < soup.triangle_count; i++) soup.flags[i] = i * 4 / soup.triangle_count;
  assert_lit_as_oracle(&soup);
}

// The square [0, 1]^2 in the plane z = 0, whose front is seen from +z.
static void square_add(Soup *soup, uint32_t flags)
{
  uint32_t a = soup_vertex(soup, 0, 0, 0), b = soup_vertex(soup, 1, 0, 0);
  uint32_t c = soup_vertex(soup, 1, 1, 0), d = soup_vertex(soup, 0, 1, 0);
  soup_triangle(soup, a, b, c);
  soup_triangle(soup, a, c, d);
  soup->flags[soup->triangle_count - 2] = soup->flags[soup->triangle_count - 1] = flags;
}

// From z = 2 at the front and from z = -2 at the back, aslant, along each kind of direction.
static void rays_at_square(TraceRay *out, uint32_t count, float side)
{
  for (uint32_t i = 0; i < count; i++) {
    float x = 0.03f + 0.9f * (float)i / (float)count, y = 0.05f + 0.9f * (float)(i * 7 % count) / (float)count;
    float aslant = 0.5f * (float)(i % 13);
    out[i] = (TraceRay){{x + aslant, y - aslant, 2 * side}, {-aslant, aslant, -2 * side}, INFINITY};
  }
}

static void single_sided_triangles_are_open_to_closest_hits_from_behind(void **state)
{
  enum { COUNT = 200 };
  TraceFixture fixture;
  TraceRay front[COUNT], back[COUNT];
  TraceHit hits[COUNT];
  bool lit[COUNT];
  for (uint32_t flags = 0; flags <= TRIANGLE_SINGLE_SIDED; flags++) {
    Soup soup = {0};
    square_add(&soup, flags);
    rays_at_square(front, COUNT, 1);
    rays_at_square(back, COUNT, -1);
    trace_fixture_make(&fixture, &soup);
    for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
      trace_fixture_closest(hits, &fixture, (TraceKernel)kernel, front, COUNT, 0);
      for (int i = 0; i < COUNT; i++) assert_float_equal(hits[i].t, 1, 1e-6);
      trace_fixture_closest(hits, &fixture, (TraceKernel)kernel, back, COUNT, 0);
      for (int i = 0; i < COUNT; i++) assert_int_equal(hits[i].triangle == ORACLE_MISS, flags == TRIANGLE_SINGLE_SIDED);
      trace_fixture_lit(lit, &fixture, (TraceKernel)kernel, front, COUNT);
      for (int i = 0; i < COUNT; i++) assert_false(lit[i]);
      trace_fixture_lit(lit, &fixture, (TraceKernel)kernel, back, COUNT);
      for (int i = 0; i < COUNT; i++) assert_false(lit[i]);
    }
    trace_fixture_free(&fixture);
    soup_free(&soup);
  }
}

// The oracle's answer for both kinds of rays, where the ray is a texel's filter or more from a texel that differs.
static void mask_cuts_closest_hits_and_lets_light_through(void **state)
{
  enum { COUNT = 2000 };
  static TraceRay rays[COUNT];
  static TraceHit hits[COUNT];
  static bool lit[COUNT];
  for (uint32_t flags = TRIANGLE_MASKED; flags <= (TRIANGLE_MASKED | TRIANGLE_SINGLE_SIDED); flags++) {
    TraceFixture fixture;
    Soup soup = {0};
    square_add(&soup, flags);
    rays_at_square(rays, COUNT, 1);
    trace_fixture_make(&fixture, &soup);
    for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
      uint32_t cut = 0, unsure = 0;
      trace_fixture_closest(hits, &fixture, (TraceKernel)kernel, rays, COUNT, 0);
      trace_fixture_lit(lit, &fixture, (TraceKernel)kernel, rays, COUNT);
      for (int i = 0; i < COUNT; i++) {
        OracleRay ray = trace_oracle_ray(&rays[i], true);
        double margin = ORACLE_MARGIN_MAX, share = oracle_lit(&fixture.oracle, &ray, &margin);
        cut += lit[i];
        assert_int_equal(lit[i], hits[i].triangle == ORACLE_MISS);
        if (margin <= TRACE_ROUNDING)
          unsure++;
        else
          assert_int_equal(lit[i], share > 0);
      }
      assert_in_range(cut, COUNT / 5, COUNT - COUNT / 5);
      assert_in_range(unsure, 0, COUNT / 100);
    }
    trace_fixture_free(&fixture);
    soup_free(&soup);
  }
}

// What is cut away does not hide what is behind it.
static void closest_hit_goes_on_behind_a_cut(void **state)
{
  enum { COUNT = 500 };
  static TraceRay rays[COUNT];
  static TraceHit hits[COUNT];
  TraceFixture fixture;
  Soup soup = {0};
  square_add(&soup, TRIANGLE_MASKED);
  for (int i = 0; i < 4; i++) soup_vertex(&soup, i & 1 ? 9.0f : -9.0f, i & 2 ? 9.0f : -9.0f, -1);
  soup_triangle(&soup, 4, 5, 6);
  soup_triangle(&soup, 5, 7, 6);
  rays_at_square(rays, COUNT, 1);
  trace_fixture_make(&fixture, &soup);
  for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
    uint32_t behind = 0;
    trace_fixture_closest(hits, &fixture, (TraceKernel)kernel, rays, COUNT, 0);
    for (int i = 0; i < COUNT; i++) {
      assert_int_not_equal(hits[i].triangle, ORACLE_MISS);
      assert_float_equal(hits[i].t, hits[i].triangle < 2 ? 1 : 1.5, 1e-5);
      behind += hits[i].triangle >= 2;
    }
    assert_in_range(behind, COUNT / 5, COUNT - COUNT / 5);
  }
  trace_fixture_free(&fixture);
  soup_free(&soup);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(blocked_where_double_precision_says),
      cmocka_unit_test(single_sided_triangles_block_from_either_side),
      cmocka_unit_test(masked_triangles_block_where_their_texture_is_opaque),
      cmocka_unit_test(single_sided_triangles_are_open_to_closest_hits_from_behind),
      cmocka_unit_test(mask_cuts_closest_hits_and_lets_light_through),
      cmocka_unit_test(closest_hit_goes_on_behind_a_cut),
  };
  ray_count = effort_is_quick() ? 10001 : 40001;
  return cmocka_run_group_tests_name("trace_any", tests, NULL, NULL);
}
