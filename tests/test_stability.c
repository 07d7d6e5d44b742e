// The catalogue of failures: the verdict's rule, the tables, and `frugal stability` as a user runs it.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

#include "stability/stability.h"
#include "support/cli.h"
#include "support/effort.h"

#define VERDICT(...)                                       \
  stability_verdict((const StabilityPoint[]){__VA_ARGS__}, \
                    sizeof((const StabilityPoint[]){__VA_ARGS__}) / sizeof(StabilityPoint))

static void a_row_holds_where_all_is_within_its_bound(void **state)
{
  assert_int_equal(VERDICT({0, 0, 0, 0}), VERDICT_HOLDS);
  assert_int_equal(VERDICT({0, 0.1, 0.1, 0.1}, {1, 0.2, 0.3, 0.3}), VERDICT_HOLDS);
  assert_int_equal(VERDICT({0, 0, 0, 0}, {1, 0.7, INFINITY, INFINITY}), VERDICT_HOLDS);
}

static void one_point_beyond_without_a_warning_is_silent(void **state)
{
  assert_int_equal(VERDICT({0, 0, 0, 0}, {1, 1e-9, 0, 0}, {2, 0, 0, 0}), VERDICT_SILENT);
  assert_int_equal(VERDICT({0, 0, 0, 0}, {1, 0.3, 0, 0.2}), VERDICT_SILENT);
}

static void a_warning_counts_where_it_covers_the_error(void **state)
{
  assert_int_equal(VERDICT({0, 0, 0.1, 0.1}, {1, 0.3, 0.1, 0.4}, {2, 0.5, 0.1, 0.5}), VERDICT_SAYS_SO);
}

// A method that warns of the worst everywhere has said nothing.
static void a_warning_beyond_four_times_the_error_is_silent(void **state)
{
  assert_int_equal(VERDICT({0, 0, 0, 1}, {1, 0.2, 0, 1}), VERDICT_SILENT);
  assert_int_equal(VERDICT({0, 0, 0, 1}, {1, 0.2, 0, 1}, {2, 0.5, 0, 1}, {3, 0.6, 0, 1}), VERDICT_SAYS_SO);
}

static void the_easy_control_must_hold(void **state)
{
  assert_int_equal(VERDICT({0, 0.3, 0, 0.4}, {1, 0, 0, 0}), VERDICT_SILENT);
}

static void what_is_no_number_is_silent(void **state)
{
  assert_int_equal(VERDICT({0, 0, 1, 1}, {1, NAN, 1, 1}), VERDICT_SILENT);
  assert_int_equal(VERDICT({0, 0, 1, 1}, {1, NAN, INFINITY, INFINITY}), VERDICT_SILENT);
}

static void the_worst_point_is_the_one_farthest_beyond_its_bound(void **state)
{
  const StabilityPoint points[] = {
      {0, 0.5, 1, 1}, {1, 0.9, INFINITY, INFINITY}, {2, 0.4, 0.2, 0.2}, {3, 0.1, 0.2, 0.2}};
  const StabilityPoint zeros[] = {{0, 0.5, 1, 1}, {1, 1e-3, 0, 0}, {2, 0, 0, 0}};
  assert_int_equal(stability_worst(points, 4), 2);
  assert_int_equal(stability_worst(zeros, 3), 1);
}

// Names are names of files and values of --only; a quick run has the control and something to compare with it.
static void rows_are_whole_and_named_apart(void **state)
{
  const char *names[256];
  uint32_t count = 0;
  for (int t = 0; t < STABILITY_TABLES; t++) {
    const StabilityTable *table = stability_tables[t];
    for (uint32_t i = 0; i < table->row_count; i++) {
      const StabilityRow *row = &table->rows[i];
      assert_true(row->name && row->failure && row->scene && row->parameter && row->quantity && row->bound);
      assert_int_equal(strspn(row->name, "abcdefghijklmnopqrstuvwxyz-"), strlen(row->name));
      assert_non_null(row->measure);
      assert_in_range(row->sweep.count, 3, STABILITY_POINTS_MOST);
      if (!(row->sweep.quick & (row->sweep.quick - 1))) fail_msg("%s: one value alone is quick", row->name);
      if (row->sweep.quick >> row->sweep.count) fail_msg("%s: quick has bits beyond the values", row->name);
      for (uint32_t k = 0; k < count; k++) assert_string_not_equal(row->name, names[k]);
      assert_string_not_equal(row->name, table->name);
      names[count++] = row->name;
    }
  }
  assert_true(count >= 24);
}

static json_t *report_of(const CliRun *run)
{
  json_error_t error;
  json_t *report = json_loads(run->out, 0, &error);
  if (!report) fail_msg("no JSON: %s", error.text);
  return report;
}

// The methods of today on the machine of today: nothing fails without a word. What is known to fail is seen to.
static void a_quick_run_finds_no_silent_row(void **state)
{
  if (effort_is_quick()) {
    fprintf(stderr, "SKIPPED: the whole catalogue: a build that is slow itself\n");
    skip();
  }
  CliRun run = cli_run("stability", "--quick", "--json", NULL);
  if (run.exit_code != 0) fail_msg("exit code %d: %s", run.exit_code, run.err);
  json_t *report = report_of(&run), *row;
  size_t index, beyond = 0, measured = 0;
  assert_int_equal(json_integer_value(json_object_get(report, "silent")), 0);
  json_array_foreach(json_object_get(report, "rows"), index, row)
  {
    json_t *point, *points = json_object_get(row, "points");
    size_t k;
    const char *verdict = json_string_value(json_object_get(row, "verdict"));
    if (strcmp(verdict, "holds") != 0) assert_string_equal(verdict, "says so");
    beyond += strcmp(verdict, "holds") != 0;
    assert_true(json_array_size(points) >= 2);
    json_array_foreach(points, k, point) measured += json_number_value(json_object_get(point, "measured")) > 0;
  }
  assert_true(index >= 50);
  assert_true(beyond >= 4);     // a grazing light by each kind of map, and faces in one plane
  assert_true(measured >= 20);  // the scenes trigger what they are made for
  json_decref(report);
  cli_free(&run);
}

static const char *fault = "FRUGAL_FAULT=stability:1";

static void a_wrong_picture_makes_a_row_silent(void **state)
{
  cli_setting.environment[0] = fault;
  CliRun run = cli_run("stability", "--quick", "--only", "acne", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.out, "silent"));
  assert_null(strstr(run.out, "holds"));
  int silent = 0, all = 0;
  assert_int_equal(sscanf(run.err, "frugal: stability: %d of %d rows are silent", &silent, &all), 2);
  assert_true(silent == all && all >= 4);  // a row of each method
  cli_free(&run);
}

static void json_tells_of_a_silent_row_and_exits_so(void **state)
{
  cli_setting.environment[0] = fault;
  CliRun run = cli_run("stability", "--quick", "--only", "near-caster", "--json", NULL);
  assert_int_equal(run.exit_code, 1);
  json_t *report = report_of(&run), *rows = json_object_get(report, "rows"), *row = json_array_get(rows, 0);
  assert_int_equal(json_integer_value(json_object_get(report, "silent")), json_array_size(rows));
  assert_string_equal(json_string_value(json_object_get(row, "name")), "near-caster");
  assert_string_equal(json_string_value(json_object_get(row, "method")), "map");
  assert_string_equal(json_string_value(json_object_get(row, "verdict")), "silent");
  json_decref(report);
  cli_free(&run);
}

static void the_worst_case_comes_as_pictures(void **state)
{
  static const char *const names[] = {"acne-rays.png", "acne-rays-reference.png", "acne-rays-difference.png"};
  size_t sizes[3];
  CliRun run = cli_run("stability", "--quick", "--only", "acne", "-o", cli_path("worst"), NULL);
  assert_int_equal(run.exit_code, 0);
  cli_free(&run);
  for (int i = 0; i < 3; i++) {
    char *bytes = cli_load(cli_path("worst/%s", names[i]), &sizes[i]);
    assert_non_null(bytes);
    assert_memory_equal(bytes, "\x89PNG", 4);
    free(bytes);
  }
  // A wrong picture is another one, and its difference is not black.
  cli_setting.environment[0] = fault;
  run = cli_run("stability", "--quick", "--only", "acne", "-o", cli_path("worst_wrong"), NULL);
  assert_int_equal(run.exit_code, 1);
  cli_free(&run);
  for (int i = 0; i < 3; i += 2) {
    size_t size, before;
    char *bytes = cli_load(cli_path("worst_wrong/%s", names[i]), &size),
         *right = cli_load(cli_path("worst/%s", names[i]), &before);
    assert_non_null(bytes);
    assert_false(size == before && !memcmp(bytes, right, size));
    free(bytes);
    free(right);
  }
}

static void rows_are_listed_and_chosen_by_name(void **state)
{
  CliRun run = cli_run("stability", "--list", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "shadows    acne "));
  assert_non_null(strstr(run.out, "geometry   slivers "));
  cli_free(&run);
  run = cli_run("stability", "--list", "--only", "geometry", NULL);
  assert_null(strstr(run.out, "acne"));
  cli_free(&run);
}

static void wrong_usage_says_what_is_right(void **state)
{
  CLI_EXPECT(2, "did you mean 'acne'", "stability", "--only", "acme");
  CLI_EXPECT(2, "no such device", "stability", "--only", "acne", "--device", "none of that name");
  CLI_EXPECT(5, "no folder", "stability", "--only", "acne", "-o", cli_path("out/old.png"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_row_holds_where_all_is_within_its_bound),
      cmocka_unit_test(one_point_beyond_without_a_warning_is_silent),
      cmocka_unit_test(a_warning_counts_where_it_covers_the_error),
      cmocka_unit_test(a_warning_beyond_four_times_the_error_is_silent),
      cmocka_unit_test(the_easy_control_must_hold),
      cmocka_unit_test(what_is_no_number_is_silent),
      cmocka_unit_test(the_worst_point_is_the_one_farthest_beyond_its_bound),
      cmocka_unit_test(rows_are_whole_and_named_apart),
      cmocka_unit_test(a_quick_run_finds_no_silent_row),
      cmocka_unit_test(a_wrong_picture_makes_a_row_silent),
      cmocka_unit_test(json_tells_of_a_silent_row_and_exits_so),
      cmocka_unit_test(the_worst_case_comes_as_pictures),
      cmocka_unit_test(rows_are_listed_and_chosen_by_name),
      cmocka_unit_test(wrong_usage_says_what_is_right),
  };
  return cmocka_run_group_tests_name("stability", tests, cli_set_up, cli_tear_down);
}
