// A closed mesh seen from inside never leaks: rays at its edges and vertices hit one of its triangles, whatever the
// kernel. 10^6 rays; FRUGAL_TEST_FULL=1 traces 10^7.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "support/effort.h"
#include "support/trace_fixture.h"

// Rays for each of the meshes.
static uint32_t ray_count(void) { return (effort_is_full() ? 10 : 1) * 200000 + 7; }

static double share(Random *random) { return (random_next(random) + 0.5) / 4294967296.0; }

static Vec3 vertex_of(const Soup *soup, uint32_t triangle, uint32_t corner)
{
  return vec3_from_floats(soup->positions[soup->triangles[triangle][corner % 3]]);
}

// A vertex, or a point of an edge, and every fourth time one that is nearly a vertex.
static Vec3 target_make(const Soup *soup, Random *random)
{
  uint32_t triangle = random_next(random) % soup->triangle_count, corner = random_next(random) % 3;
  double along = share(random);
  if (random_next(random) % 4 == 0) along = pow(10, -8 * share(random));
  if (random_next(random) % 3 == 0) along = 0;
  Vec3 from = vertex_of(soup, triangle, corner), to = vertex_of(soup, triangle, corner + 1);
  return vec3_add(vec3_scale(from, 1 - along), vec3_scale(to, along));
}

// From a point of the box [low, high] inside the mesh; every fifth ray runs along an axis through a vertex or an edge
// that lies in the box's width, with zeros of either sign. In a box-shaped mesh every third ray grazes the planes of an
// axis.
static TraceRay ray_make(const Soup *soup, Random *random, const float low[3], const float high[3], bool box)
{
  TraceRay ray = {.t_max = INFINITY};
  Vec3 target = target_make(soup, random);
  double at[3] = {target.x, target.y, target.z};
  bool parallel = random_next(random) % 5 == 0;
  uint32_t axis = random_next(random) % 3, grazed = random_next(random) % 9;
  for (uint32_t i = 0; i < 3; i++) {
    double from = random_between(random, low[i], high[i]), near = at[i] + (from - at[i]) * pow(10, -3 * share(random));
    if (parallel && i != axis && at[i] > low[i] && at[i] < high[i]) from = at[i];
    if (box && grazed == i && (float)near != (float)at[i]) from = near;
    ray.origin[i] = (float)from;
    ray.direction[i] = (float)(at[i] - ray.origin[i]);
    if (parallel && i != axis) ray.direction[i] = random_next(random) >> 31 ? 0.0f : -0.0f;
  }
  if (ray.direction[axis] == 0) ray.direction[axis] = 1;
  return ray;
}

static void assert_no_leak(Soup *soup, const float low[3], const float high[3], bool box)
{
  uint32_t count = ray_count();
  Random random = random_make(soup->triangle_count);
  TraceFixture fixture;
  TraceRay *rays = oracle_array(count, sizeof *rays);
  TraceHit *hits = oracle_array(count, sizeof *hits);
  for (uint32_t i = 0; i < count; i++) rays[i] = ray_make(soup, &random, low, high, box);
  trace_fixture_make(&fixture, soup);
  uint32_t all_leaks = 0;
  for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
    uint32_t leaks = 0;
    trace_fixture_closest(hits, &fixture, (TraceKernel)kernel, rays, count, 0);
    for (uint32_t i = 0; i < count; i++) {
      if (hits[i].triangle != ORACLE_MISS) continue;
      const float *o = rays[i].origin, *d = rays[i].direction;
      if (leaks++ < 3) printf("leak: from %a %a %a along %a %a %a\n", o[0], o[1], o[2], d[0], d[1], d[2]);
    }
    if (leaks) printf("%s: %u leaks of %u\n", trace_kernel_names[kernel], leaks, count);
    all_leaks += leaks;
  }
  trace_fixture_free(&fixture);
  free(rays);
  free(hits);
  soup_free(soup);
  assert_int_equal(all_leaks, 0);
}

static void bumpy_sphere_never_leaks(void **state)
{
  static const float center[3] = {0.1f, -0.2f, 0.3f}, low[3] = {-0.2f, -0.5f, 0}, high[3] = {0.4f, 0.1f, 0.6f};
  Soup soup = {0};
  soup_sphere(&soup, 100, 1, center, 0.3f);
  assert_no_leak(&soup, low, high, false);
}

static void sphere_far_from_the_origin_never_leaks(void **state)
{
  static const float center[3] = {1e4f, -2e4f, 3e4f}, low[3] = {9998, -20002, 29998}, high[3] = {10002, -19998, 30002};
  Soup soup = {0};
  soup_sphere(&soup, 100, 4, center, 0);
  assert_no_leak(&soup, low, high, false);
}

static void box_on_a_lattice_never_leaks(void **state)
{
  static const float corners[2][3] = {{-16, 0, 4}, {16, 32, 36}}, low[3] = {-15.9f, 0.1f, 4.1f},
                     high[3] = {15.9f, 31.9f, 35.9f};
  Soup soup = {0};
  soup_grid(&soup, 32, corners[0], corners[1]);
  assert_no_leak(&soup, low, high, true);
}

static void box_of_odd_size_never_leaks(void **state)
{
  static const float corners[2][3] = {{-0.7f, -0.1f, 0.3f}, {1.9f, 2.3f, 3.1f}};
  static const float low[3] = {-0.6f, 0, 0.4f}, high[3] = {1.8f, 2.2f, 3};
  Soup soup = {0};
  soup_grid(&soup, 50, corners[0], corners[1]);
  assert_no_leak(&soup, low, high, true);
}

// Rays nearly along the edges where two walls meet: what a slab test decides there hangs on less than a triangle test
// can tell.
static void long_corridor_never_leaks(void **state)
{
  static const float corners[2][3] = {{-1, -1, 0}, {1, 1, 1000}}, low[3] = {-0.9f, -0.9f, 1},
                     high[3] = {0.9f, 0.9f, 20};
  Soup soup = {0};
  soup_grid(&soup, 12, corners[0], corners[1]);
  assert_no_leak(&soup, low, high, false);
}

// Cells from 3 x 10^-7 to 1 wide: every aspect of sliver down to what rounding leaves of one a metre away. The rays
// start where no needle reaches behind them: where a ray meets one that is seen as thin as rounding cannot be told
// then.
static void box_of_slivers_never_leaks(void **state)
{
  static const float corners[2][3] = {{-1, -1, -1}, {1, 1, 1}}, low[3] = {-0.01f, -0.01f, -0.01f},
                     high[3] = {0.01f, 0.01f, 0.01f};
  Soup soup = {0};
  soup_grid(&soup, 40, corners[0], corners[1]);
  for (uint32_t i = 0; i < soup.vertex_count; i++)
    for (int axis = 0; axis < 3; axis++) {
      float *at = &soup.positions[i][axis];
      *at = (float)(pow(fabs(*at), 5) * (*at < 0 ? -1 : 1));
    }
  assert_no_leak(&soup, low, high, false);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(bumpy_sphere_never_leaks),     cmocka_unit_test(sphere_far_from_the_origin_never_leaks),
      cmocka_unit_test(box_on_a_lattice_never_leaks), cmocka_unit_test(box_of_odd_size_never_leaks),
      cmocka_unit_test(long_corridor_never_leaks),    cmocka_unit_test(box_of_slivers_never_leaks),
  };
  return cmocka_run_group_tests_name("trace_watertight", tests, NULL, NULL);
}
