// What a hit must not depend on: the order of the rays, how many there are, the number of threads; and which
// triangle an exact tie goes to.
#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/test_device.h"
#include "support/trace_rays.h"

enum { RAYS = 60000 };

// Something of everything, with overlaps and ties.
static Soup soup_mixed(void)
{
  static const float center[3] = {2, 2, 1};
  Soup soup = {0};
  soup_random(&soup, 2000, 4, 0.3f, 1);
  soup_sphere(&soup, 20, 1, center, 0.2f);
  soup_slivers(&soup, 500, 2);
  soup_coplanar(&soup, 200, 1.5f, 3);
  soup_axis(&soup, 4);
  for (uint32_t i = 0; i < soup.triangle_count; i++) soup.flags[i] = (i / 64) % 2;
  return soup;
}

static void order_of_the_rays_changes_nothing(void **state)
{
  TraceFixture fixture;
  Soup soup = soup_mixed();
  Random random = random_make(7);
  TraceRay *rays = oracle_array(RAYS, sizeof *rays), *shuffled = oracle_array(RAYS, sizeof *shuffled);
  TraceHit *hits = oracle_array(RAYS, sizeof *hits), *others = oracle_array(RAYS, sizeof *others);
  bool *lit = oracle_array(RAYS, sizeof *lit), *others_lit = oracle_array(RAYS, sizeof *others_lit);
  uint32_t *place = oracle_array(RAYS, sizeof *place);
  trace_rays_make(rays, RAYS, &soup, 8);
  trace_fixture_make(&fixture, &soup);
  for (uint32_t i = 0; i < RAYS; i++) {
    uint32_t j = random_next(&random) % (i + 1);
    place[i] = place[j];
    place[j] = i;
  }
  for (uint32_t i = 0; i < RAYS; i++) shuffled[i] = rays[place[i]];
  for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
    uint32_t differ = 0;
    trace_fixture_closest(hits, &fixture, (TraceKernel)kernel, rays, RAYS, 0);
    trace_fixture_closest(others, &fixture, (TraceKernel)kernel, shuffled, RAYS, 0);
    trace_fixture_lit(lit, &fixture, (TraceKernel)kernel, rays, RAYS);
    trace_fixture_lit(others_lit, &fixture, (TraceKernel)kernel, shuffled, RAYS);
    for (uint32_t i = 0; i < RAYS; i++) {
      if (!memcmp(&others[i], &hits[place[i]], sizeof *hits) && others_lit[i] == lit[place[i]]) continue;
      if (differ++ < 3) trace_ray_print(trace_kernel_names[kernel], &shuffled[i], place[i]);
    }
    assert_int_equal(differ, 0);
  }
  trace_fixture_free(&fixture);
  soup_free(&soup);
  free(rays);
  free(shuffled);
  free(hits);
  free(others);
  free(lit);
  free(others_lit);
  free(place);
}

// The first rays of a stream give what they give in a longer one, for each count up to a few packets; and any-hit rays
// behind the last one add nothing (trace_fixture_lit fails if they do).
static void number_of_rays_may_be_any(void **state)
{
  enum { MOST = 150 };
  TraceFixture fixture;
  TraceRay rays[MOST];
  TraceHit all[MOST], few[MOST];
  bool all_lit[MOST], few_lit[MOST];
  Soup soup = soup_mixed();
  trace_rays_make(rays, MOST, &soup, 9);
  trace_fixture_make(&fixture, &soup);
  for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
    trace_fixture_closest(all, &fixture, (TraceKernel)kernel, rays, MOST, 0);
    trace_fixture_lit(all_lit, &fixture, (TraceKernel)kernel, rays, MOST);
    for (uint32_t count = 1; count < MOST; count += 1 + count / 4) {
      trace_fixture_closest(few, &fixture, (TraceKernel)kernel, rays, count, 0);
      trace_fixture_lit(few_lit, &fixture, (TraceKernel)kernel, rays, count);
      assert_memory_equal(few, all, count * sizeof *few);
      assert_memory_equal(few_lit, all_lit, count * sizeof *few_lit);
    }
  }
  trace_fixture_free(&fixture);
  soup_free(&soup);
}

// t_min and t_max bound what is hit: t_min is left out, t_max is not.
static void hits_lie_between_t_min_and_t_max(void **state)
{
  TraceFixture fixture;
  Soup soup = {0};
  for (int plane = 1; plane <= 3; plane++) {
    uint32_t a = soup_vertex(&soup, -9, -9, (float)plane), b = soup_vertex(&soup, 9, -9, (float)plane);
    soup_triangle(&soup, a, b, soup_vertex(&soup, 0, 9, (float)plane));
  }
  trace_fixture_make(&fixture, &soup);
  for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
    TraceRay rays[] = {{{0, 0, 0}, {0, 0, 1}, 3}, {{0, 0, 0}, {0, 0, 1}, 2.5f}, {{0, 0, 0}, {0, 0, 1}, 0.5f},
                       {{0, 0, 0}, {0, 0, 1}, 0}, {{0, 0, 0}, {0, 0, 1}, -1},   {{0, 0, 0}, {0, 0, 0.5f}, 6}};
    TraceHit hits[6];
    trace_fixture_closest(hits, &fixture, (TraceKernel)kernel, rays, 6, 2);
    assert_int_equal(hits[0].triangle, 2);
    for (int i = 1; i < 5; i++) assert_int_equal(hits[i].triangle, ORACLE_MISS);
    assert_int_equal(hits[5].triangle, 1);
    assert_float_equal(hits[5].t, 4, 0);
  }
  trace_fixture_free(&fixture);
  soup_free(&soup);
}

// Four copies of every triangle, at random places of the soup, whose corners are in the same order.
static void of_identical_triangles_the_lowest_is_hit(void **state)
{
  enum { KINDS = 200, COPIES = 4, ALL = KINDS * COPIES, COUNT = 20000 };
  static uint32_t kind_of[ALL], lowest[KINDS];
  TraceFixture fixture;
  Soup once = {0}, soup = {0};
  Random random = random_make(10);
  TraceRay *rays = oracle_array(COUNT, sizeof *rays);
  TraceHit *hits = oracle_array(COUNT, sizeof *hits);
  soup_random(&once, KINDS, 1, 0.3f, 11);
  for (uint32_t i = 0; i < ALL; i++) {
    uint32_t j = random_next(&random) % (i + 1);
    kind_of[i] = kind_of[j];
    kind_of[j] = i % KINDS;
  }
  for (uint32_t i = 0; i < once.vertex_count; i++)
    soup_vertex(&soup, once.positions[i][0], once.positions[i][1], once.positions[i][2]);
  for (uint32_t i = 0; i < ALL; i++) {
    const uint32_t *corners = once.triangles[kind_of[i]];
    soup_triangle(&soup, corners[0], corners[1], corners[2]);
  }
  for (uint32_t i = ALL; i-- > 0;) lowest[kind_of[i]] = i;
  trace_rays_make(rays, COUNT, &soup, 12);
  trace_fixture_make(&fixture, &soup);
  for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
    uint32_t hit_count = 0;
    trace_fixture_closest(hits, &fixture, (TraceKernel)kernel, rays, COUNT, 0);
    for (uint32_t i = 0; i < COUNT; i++) {
      if (hits[i].triangle == ORACLE_MISS) continue;
      hit_count++;
      assert_int_equal(hits[i].triangle, lowest[kind_of[hits[i].triangle]]);
    }
    assert_in_range(hit_count, COUNT / 4, COUNT);
  }
  trace_fixture_free(&fixture);
  soup_free(&once);
  soup_free(&soup);
  free(rays);
  free(hits);
}

// Rectangles that overlap in a plane, with corners at quarters, hit between them: the arithmetic is exact, so that all
// triangles at a point tie.
static void of_coplanar_triangles_the_lowest_is_hit(void **state)
{
  enum { SIDE = 48 };
  static TraceRay rays[SIDE * SIDE];
  static TraceHit hits[SIDE * SIDE];
  TraceFixture fixture;
  Soup soup = {0};
  soup_coplanar(&soup, 150, 2, 13);
  for (int i = 0; i < SIDE * SIDE; i++)
    rays[i] = (TraceRay){
        {0.125f + 0.125f * (float)(i % SIDE), 0.140625f + 0.125f * (float)(i / SIDE), -2}, {0, 0, 1}, INFINITY};
  trace_fixture_make(&fixture, &soup);
  for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
    trace_fixture_closest(hits, &fixture, (TraceKernel)kernel, rays, SIDE * SIDE, 0);
    for (int i = 0; i < SIDE * SIDE; i++) {
      OracleRay ray = trace_oracle_ray(&rays[i], false);
      OracleHit truth;
      oracle_closest(&truth, &fixture.oracle, &ray);
      assert_int_equal(hits[i].triangle, truth.triangle);
      if (truth.triangle != ORACLE_MISS) assert_true(hits[i].t == 4);
    }
  }
  trace_fixture_free(&fixture);
  soup_free(&soup);
}

// What a process prints that traces on so many threads: PoCL takes their number once in a process.
static uint64_t hash_all(unsigned threads)
{
  Log log = {0};
  Device *device = NULL;
  TraceFixture fixture;
  Soup soup = soup_mixed();
  TraceRay *rays = oracle_array(RAYS, sizeof *rays);
  TraceHit *hits = oracle_array(RAYS, sizeof *hits);
  uint64_t hash = 14695981039346656037u;
  if (device_open(&device, "cpu", threads, NULL, &log)) return 0;
  device_close(device);
  trace_rays_make(rays, RAYS, &soup, 14);
  trace_fixture_make(&fixture, &soup);
  for (int kernel = 0; kernel < TRACE_KERNELS; kernel++) {
    trace_fixture_closest(hits, &fixture, (TraceKernel)kernel, rays, RAYS, 0);
    for (size_t i = 0; i < RAYS * sizeof *hits; i++) hash = (hash ^ ((const uint8_t *)hits)[i]) * 1099511628211u;
  }
  trace_fixture_free(&fixture);
  soup_free(&soup);
  free(rays);
  free(hits);
  return hash;
}

static void number_of_threads_changes_nothing(void **state)
{
  static const unsigned threads[] = {1, 2, 5};
  char self[4096] = "", command[4200], line[64], first[64] = "";
  if (test_skips_on_gpu("threads of a CPU")) skip();
  assert_in_range(readlink("/proc/self/exe", self, sizeof self - 1), 1, sizeof self - 2);
  for (int i = 0; i < 3; i++) {
    snprintf(command, sizeof command, "'%s' --threads %u", self, threads[i]);
    FILE *child = popen(command, "r");
    assert_non_null(child);
    assert_non_null(fgets(line, sizeof line, child));
    assert_int_equal(pclose(child), 0);
    if (i == 0) snprintf(first, sizeof first, "%s", line);
    assert_string_equal(line, first);
    assert_string_not_equal(line, "0\n");
  }
}

int main(int argc, char **argv)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(order_of_the_rays_changes_nothing),
      cmocka_unit_test(number_of_rays_may_be_any),
      cmocka_unit_test(hits_lie_between_t_min_and_t_max),
      cmocka_unit_test(of_identical_triangles_the_lowest_is_hit),
      cmocka_unit_test(of_coplanar_triangles_the_lowest_is_hit),
      cmocka_unit_test(number_of_threads_changes_nothing),
  };
  if (argc == 3 && !strcmp(argv[1], "--threads")) {
    printf("%" PRIu64 "\n", hash_all((unsigned)strtoul(argv[2], NULL, 10)));
    return 0;
  }
  return cmocka_run_group_tests_name("trace_bits", tests, NULL, NULL);
}
