// Refit of trees: afterwards they are whole, tight trees of the moved soup, they say what they wrote, and they know
// when they are worn.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "accel/bvh_cost.h"
#include "accel/bvh_refit.h"
#include "accel/bvh_validate.h"
#include "base/parallel.h"
#include "support/soup.h"

static const BvhOptions usual = {.max_leaf = 4, .traversal_cost = 1};

typedef struct Trees {
  Bvh2 two;
  Bvh8 eight;
  BvhRefit refit;
} Trees;

static void assert_ok(Status status, const Log *log)
{
  if (status) fail_msg("status %d: %s", status, log->error);
}

// *out must stay where it is.
static void trees_build(Trees *out, const Soup *soup)
{
  Log log = {0};
  TriangleSoup view = soup_view(soup);
  assert_ok(bvh2_build(&out->two, &view, &usual, &log), &log);
  assert_ok(bvh8_from_bvh2(&out->eight, &out->two, &log), &log);
  assert_ok(bvh_refit_make(&out->refit, &out->two, &out->eight, soup->triangle_count, 1, &log), &log);
}

static void trees_free(Trees *trees)
{
  bvh_refit_free(&trees->refit);
  bvh2_free(&trees->two);
  bvh8_free(&trees->eight);
}

static void assert_near(double a, double b)
{
  if (!(fabs(a - b) <= 1e-9 * fabs(b))) fail_msg("%.17g is not %.17g", a, b);
}

static void assert_valid(const Trees *trees, const Soup *soup)
{
  Log log = {0};
  TriangleSoup view = soup_view(soup);
  assert_ok(bvh2_validate(&trees->two, &view, usual.max_leaf, &log), &log);
  assert_ok(bvh8_validate(&trees->eight, &view, &log), &log);
  const double root_area = bvh2_root_area(&trees->two.nodes[0]);
  assert_near(bvh2_cost_of_sum(trees->refit.cost_sum, root_area, 1), bvh2_cost(&trees->two, 1));
}

// Moves the trees, which must follow.
static void refit_and_check(Trees *trees, const Soup *soup, const BvhIds *moved, uint32_t moved_count)
{
  TriangleSoup view = soup_view(soup);
  assert_true(bvh_refit(&trees->refit, &view, moved, moved_count));
  assert_valid(trees, soup);
}

static void triangle_shift(Soup *soup, uint32_t triangle, float x, float y, float z)
{
  for (int corner = 0; corner < 3; corner++) {
    float *position = soup->positions[soup->triangles[triangle][corner]];
    position[0] += x;
    position[1] += y;
    position[2] += z;
  }
}

static void *copied(const void *array, size_t bytes)
{
  void *copy = malloc(bytes + 1);
  assert_non_null(copy);
  memcpy(copy, array, bytes);
  return copy;
}

// Elements that changed are marked. Few others are.
static void assert_marks(const uint8_t *marks, void *before, const void *now, size_t count, size_t bytes)
{
  size_t marked = 0, changed = 0;
  for (size_t i = 0; i < count; i++) {
    bool differs = memcmp((char *)before + i * bytes, (const char *)now + i * bytes, bytes) != 0;
    if (differs && marks[i] != 1) fail_msg("element %zu of %zu changed and is not marked", i, count);
    assert_true(marks[i] <= 1);
    marked += marks[i];
    changed += differs;
  }
  if (marked > 40 + 4 * changed) fail_msg("%zu of %zu marked, %zu changed", marked, count, changed);
  free(before);
}

static void marks_cover_what_is_written(void **state)
{
  static const BvhIds ranges[][2] = {
      {{0, 1}, {29999, 30000}}, {{500, 600}, {10000, 10001}}, {{0, 20000}, {25000, 30000}}};
  Soup soup = {0};
  Trees trees = {0};
  soup_random(&soup, 30000, 10, 0.1f, 1);
  trees_build(&trees, &soup);
  for (int i = 0; i < 3; i++) {
    void *nodes = copied(trees.two.nodes, trees.two.node_count * sizeof *trees.two.nodes);
    void *triangles = copied(trees.two.triangles, trees.two.triangle_count * sizeof *trees.two.triangles);
    void *wide_nodes = copied(trees.eight.nodes, trees.eight.node_count * sizeof *trees.eight.nodes);
    void *blocks = copied(trees.eight.blocks, trees.eight.block_count * sizeof *trees.eight.blocks);
    for (int r = 0; r < 2; r++)
      for (uint32_t t = ranges[i][r].begin; t < ranges[i][r].end; t++) triangle_shift(&soup, t, 0.5f, 0, 0.25f);
    refit_and_check(&trees, &soup, ranges[i], 2);
    const BvhRefit *refit = &trees.refit;
    assert_marks(refit->nodes_moved, nodes, trees.two.nodes, trees.two.node_count, sizeof *trees.two.nodes);
    assert_marks(refit->triangles_moved, triangles, trees.two.triangles, trees.two.triangle_count,
                 sizeof *trees.two.triangles);
    assert_marks(refit->wide_nodes_moved, wide_nodes, trees.eight.nodes, trees.eight.node_count,
                 sizeof *trees.eight.nodes);
    assert_marks(refit->blocks_moved, blocks, trees.eight.blocks, trees.eight.block_count, sizeof *trees.eight.blocks);
  }
  BvhIds all = {0, soup.triangle_count};  // that did not move
  refit_and_check(&trees, &soup, &all, 1);
  assert_null(memchr(trees.refit.nodes_moved, 1, trees.two.node_count));
  assert_null(memchr(trees.refit.blocks_moved, 1, trees.eight.block_count));
  trees_free(&trees);
  soup_free(&soup);
}

static void soups_make(Soup *soup, int kind)
{
  static const float center[3] = {1, -2, 3}, low[3] = {-1, 0, -2}, high[3] = {4, 1, 2};
  if (kind == 0) soup_random(soup, 30000, 10, 0.1f, 1);
  if (kind == 1) soup_sphere(soup, 90, 2, center, 0.1f);
  if (kind == 2) soup_grid(soup, 30, low, high);
  if (kind == 3) soup_slivers(soup, 20000, 3);
  if (kind == 4) soup_far(soup, 20000, 4);
  if (kind == 5) soup_coplanar(soup, 5000, 1.5f, 5);
  if (kind == 6) soup_axis(soup, 12);
  if (kind == 7) soup_random(soup, 60, 1, 1, 6);
  if (kind == 8) soup_random(soup, 9, 1, 1, 7);
}

static void every_soup_can_be_moved(void **state)
{
  for (int kind = 0; kind < 9; kind++) {
    Soup soup = {0};
    Trees trees = {0};
    Random random = random_make((uint64_t)kind);
    soups_make(&soup, kind);
    trees_build(&trees, &soup);
    assert_valid(&trees, &soup);
    for (int frame = 0; frame < 4; frame++) {
      for (uint32_t i = 0; i < soup.vertex_count; i++)
        for (int axis = 0; axis < 3; axis++)
          soup.positions[i][axis] *= frame == 3 ? 1e15f : random_between(&random, -1, 2);
      BvhIds all = {0, soup.triangle_count};
      refit_and_check(&trees, &soup, &all, 1);
    }
    trees_free(&trees);
    soup_free(&soup);
  }
}

static void threads_do_not_change_the_refit(void **state)
{
  static const unsigned threads[] = {1, 2, 5};
  Trees trees[3] = {0};
  for (int i = 0; i < 3; i++) {
    parallel_set_threads(threads[i]);
    Soup soup = {0};
    soup_random(&soup, 50000, 10, 0.1f, 1);
    trees_build(&trees[i], &soup);
    for (uint32_t t = 0; t < soup.triangle_count; t++) triangle_shift(&soup, t, (float)(t % 16), 0, (float)(t % 3));
    BvhIds all = {0, soup.triangle_count};
    refit_and_check(&trees[i], &soup, &all, 1);
    assert_memory_equal(trees[i].two.nodes, trees[0].two.nodes, trees[0].two.node_count * sizeof(Bvh2Node));
    assert_memory_equal(trees[i].eight.nodes, trees[0].eight.nodes, trees[0].eight.node_count * sizeof(Bvh8Node));
    assert_memory_equal(trees[i].eight.blocks, trees[0].eight.blocks, trees[0].eight.block_count * sizeof(Bvh8Block));
    assert_true(trees[i].refit.cost_sum == trees[0].refit.cost_sum);
    soup_free(&soup);
  }
  for (int i = 0; i < 3; i++) trees_free(&trees[i]);
  parallel_set_threads(0);
}

static void what_is_finite_may_not_change(void **state)
{
  static const float bad[] = {NAN, INFINITY, -INFINITY};
  Soup soup = {0};
  soup_random(&soup, 10000, 5, 0.1f, 6);
  for (uint32_t i = 0; i < 10; i++) soup.positions[soup.triangles[i][i % 3]][1] = bad[i % 3];
  TriangleSoup view = soup_view(&soup);
  BvhIds all = {0, soup.triangle_count};
  for (int i = 0; i < 3; i++) {
    Trees trees = {0};
    trees_build(&trees, &soup);
    triangle_shift(&soup, 0, 1, 1, 1);
    triangle_shift(&soup, 77, 1, 1, 1);
    refit_and_check(&trees, &soup, &all, 1);  // those left out stay so
    float *at = &soup.positions[soup.triangles[i == 0 ? 5 : 5000][2]][1], was = *at;
    *at = i == 0 ? 0.5f : bad[i];
    assert_false(bvh_refit(&trees.refit, &view, &all, 1));
    *at = was;
    trees_free(&trees);
  }
  soup_free(&soup);

  for (uint32_t count = 0; count < 9; count++) {  // a few triangles are built anew
    Trees trees = {0};
    Soup few = {0};
    soup_random(&few, count, 1, 1, count);
    trees_build(&trees, &few);
    TriangleSoup few_view = soup_view(&few);
    assert_false(bvh_refit(&trees.refit, &few_view, &(BvhIds){0, count}, 1));
    trees_free(&trees);
    soup_free(&few);
  }
}

// A ball that turns and flies as a whole costs its tree little; one that bursts wears it out, which is as good as new
// when the ball is whole again.
static void trees_wear_out_where_neighbours_part(void **state)
{
  static const float center[3] = {0, 0, 0}, low[3] = {-5, -5, -5}, high[3] = {5, -4, 5};
  Soup soup = {0};
  Trees trees = {0};
  soup_sphere(&soup, 60, 1, center, 0.1f);
  const uint32_t ball = soup.triangle_count, ball_vertices = soup.vertex_count;
  soup_grid(&soup, 20, low, high);
  trees_build(&trees, &soup);
  const BvhIds moved = {0, ball}, floor = {ball, soup.triangle_count};
  for (uint32_t i = 0; i < ball_vertices; i++) {
    float *at = soup.positions[i], x = at[0];
    at[0] = 0.8f * x - 0.6f * at[1];
    at[1] = 0.6f * x + 0.8f * at[1] + 3;
  }
  refit_and_check(&trees, &soup, &moved, 1);
  assert_false(bvh_refit_is_worn(&trees.refit));
  float(*whole)[3] = copied(soup.positions, ball_vertices * sizeof *whole);
  Random random = random_make(1);
  for (uint32_t i = 0; i < ball_vertices; i++)
    for (int axis = 0; axis < 3; axis++) soup.positions[i][axis] += random_between(&random, -1, 1);
  refit_and_check(&trees, &soup, &moved, 1);
  assert_true(bvh_refit_is_worn(&trees.refit));
  memcpy(soup.positions, whole, ball_vertices * sizeof *whole);
  refit_and_check(&trees, &soup, &moved, 1);
  assert_false(bvh_refit_is_worn(&trees.refit));

  // What flies far off stretches all boxes above it, and makes the rest small beside the whole.
  triangle_shift(&soup, floor.begin, 0, 400, 0);
  refit_and_check(&trees, &soup, &floor, 1);
  assert_true(bvh_refit_is_worn(&trees.refit));
  free(whole);
  trees_free(&trees);
  soup_free(&soup);
}

// A sum of areas that was huge for a while loses the digits of what is left.
static void huge_boxes_leave_no_error_behind(void **state)
{
  Soup soup = {0};
  Trees trees = {0};
  soup_random(&soup, 5000, 1, 0.1f, 9);
  trees_build(&trees, &soup);
  BvhIds moved = {17, 18};
  float *at = soup.positions[soup.triangles[17][0]], was = *at;
  for (float far = 10; far < 1e38f; far *= 1000) {
    *at = far;
    refit_and_check(&trees, &soup, &moved, 1);
    *at = was;
    refit_and_check(&trees, &soup, &moved, 1);
  }
  trees_free(&trees);
  soup_free(&soup);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_soup_can_be_moved),
      cmocka_unit_test(marks_cover_what_is_written),
      cmocka_unit_test(threads_do_not_change_the_refit),
      cmocka_unit_test(what_is_finite_may_not_change),
      cmocka_unit_test(trees_wear_out_where_neighbours_part),
      cmocka_unit_test(huge_boxes_leave_no_error_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
