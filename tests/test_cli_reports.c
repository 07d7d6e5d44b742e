// What the program reports of a render: --stats, --trace, --profile, --verify.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

#include "support/cli.h"

// On one thread: no second process compiles, beside the first, what others have not yet.
#define RENDER "render", "--threads", "1"
#define SIZE "64x48"
enum { WIDTH = 64 };

static json_t *json_member(json_t *object, const char *name)
{
  json_t *member = json_object_get(object, name);
  if (!member) fail_msg("no member %s", name);
  return member;
}

static void reports_are_json_and_a_table(void **state)
{
  CliRun run = cli_run(RENDER, cli_scene(), "-o", cli_path("r.png"), "-s", SIZE, "--stats", "-", "--trace",
                       cli_path("trace.json"), "--profile", NULL);
  cli_expect(&run, 0, "whole run", __FILE__, __LINE__);
  json_error_t error;
  json_t *stats = json_loads(run.out, 0, &error), *trace = json_load_file(cli_path("trace.json"), 0, &error);
  assert_non_null(stats);
  assert_non_null(trace);
  assert_string_equal(json_string_value(json_member(stats, "scene")), cli_scene());
  assert_int_equal(json_integer_value(json_array_get(json_member(stats, "size"), 0)), WIDTH);
  assert_int_equal(json_integer_value(json_member(json_member(stats, "counts"), "triangles")), 2);
  assert_true(json_array_size(json_member(stats, "passes")) > 5);
  assert_true(json_real_value(json_member(stats, "total_ms")) > 0);
  assert_true(json_array_size(json_member(trace, "traceEvents")) > 5);
  json_decref(stats);
  json_decref(trace);
  cli_free(&run);
}

// The maps judge, or hybrid shadows would be rays by another name. (At sizes from 640x360 on it is under 1 % here.)
static void hybrid_shadows_trace_few_rays_and_say_how_many(void **state)
{
  json_error_t error;
  CliRun run = cli_run(RENDER, "scenes/room.glb", "-o", cli_path("h.png"), "-s", "160x90", "--shadows", "hybrid",
                       "--shadow-map-size", "256", "--stats", "-", NULL);
  cli_expect(&run, 0, "", __FILE__, __LINE__);
  json_t *stats = json_loads(run.out, 0, &error), *maps = json_member(stats, "shadow_maps");
  json_int_t rays = json_integer_value(json_member(maps, "rays")),
             traced = json_integer_value(json_member(maps, "traced"));
  assert_true(rays > 160 * 90 && traced > 0);
  if (traced * 10 > rays) fail_msg("%d of %d rays are traced", (int)traced, (int)rays);
  json_decref(stats);
  cli_free(&run);
}

// Few samples are traced, many judged by maps, and what either was expected to cost is said.
static void shadows_are_chosen_by_what_they_cost(void **state)
{
  static const char *const samples[] = {"1", "16"}, *const methods[] = {"rays", "hybrid"};
  for (int i = 0; i < 2; i++) {
    json_error_t error;
    CliRun run = cli_run(RENDER, "scenes/room.glb", "-o", cli_path("a.png"), "-s", "320x180", "-n", samples[i],
                         "--overwrite", "--shadows", "auto", "--max-roughness", "0", "--stats", "-", NULL);
    cli_expect(&run, 0, "", __FILE__, __LINE__);
    json_t *stats = json_loads(run.out, 0, &error), *plan = json_member(stats, "plan");
    json_t *point = json_member(json_member(plan, "shadow_ms"), "point");
    assert_string_equal(json_string_value(json_member(plan, "shadows")), methods[i]);
    assert_string_equal(json_string_value(json_member(point, "method")), methods[i]);
    double rays = json_real_value(json_member(point, "rays")), hybrid = json_real_value(json_member(point, "hybrid"));
    assert_in_range(1e6 * json_real_value(json_member(point, "hybrid_kept")), 1, 1e6 * hybrid);
    assert_true(rays > 0 && hybrid > 0 && (hybrid < 0.5 * rays) == (i == 1));
    json_decref(stats);
    cli_free(&run);
  }
}

static void reflections_by_maps_say_how_many_rays_they_answered(void **state)
{
  json_error_t error;
  CliRun run = cli_run(RENDER, "scenes/room.glb", "-o", cli_path("r.png"), "-s", "160x90", "--reflections", "impostor",
                       "--cube-size", "64", "--max-roughness", "0", "--verify", "all", "--stats", "-", NULL);
  cli_expect(&run, 0, "stated by reflection maps", __FILE__, __LINE__);
  json_t *stats = json_loads(run.out, 0, &error), *maps = json_member(stats, "reflection_maps");
  json_int_t rays = json_integer_value(json_member(maps, "rays")),
             traced = json_integer_value(json_member(maps, "traced"));
  assert_string_equal(json_string_value(json_member(json_member(stats, "plan"), "reflections")), "impostor");
  assert_int_equal(json_integer_value(json_member(maps, "cubes")), 1);
  assert_int_equal(json_integer_value(json_array_get(json_member(maps, "size"), 0)), 64);
  if (rays < 200 || traced * 3 > rays) fail_msg("%d of %d rays are traced", (int)traced, (int)rays);
  json_t *predicted = json_member(maps, "predicted"), *reflectors = json_member(predicted, "reflectors");
  double off = json_real_value(json_member(json_member(json_member(stats, "verify"), "off"), "share"));
  double bound = json_real_value(json_member(json_member(predicted, "impostor"), "bound"));
  assert_int_equal(json_array_size(reflectors), 1);
  assert_true(json_real_value(json_member(json_array_get(reflectors, 0), "share")) > 0.01);
  assert_true(bound < json_real_value(json_member(json_member(predicted, "cube"), "bound")));
  static const char *const lists[] = {"snapshot", "mixed", "candidates", "hybrid", "planar"};
  for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
    assert_true(json_real_value(json_member(json_member(predicted, lists[i]), "bound")) < bound);
  assert_true(json_real_value(json_member(json_member(predicted, "hybrid"), "expected")) == 0);
  if (off > bound || bound > 10 * off) fail_msg("%g off, %g stated", off, bound);
  json_decref(stats);
  cli_free(&run);
}

// Hybrid reflections say when rays are quicker, and planar ones what is flat.
static void exact_reflections_say_what_they_are_made_of(void **state)
{
  json_error_t error;
  CliRun run = cli_run(RENDER, "scenes/room.glb", "-o", cli_path("h.png"), "-s", "160x90", "--reflections", "hybrid",
                       "--max-roughness", "0", "--stats", "-", NULL);
  cli_expect(&run, 0, "", __FILE__, __LINE__);
  json_t *stats = json_loads(run.out, 0, &error), *maps = json_member(stats, "reflection_maps");
  assert_int_equal(json_integer_value(json_member(maps, "without_gain")), 1);
  assert_int_equal(json_integer_value(json_member(maps, "cubes")), 0);
  json_t *ms = json_member(maps, "predicted_ms");
  assert_true(json_real_value(json_member(ms, "hybrid")) > json_real_value(json_member(ms, "rays")));
  json_decref(stats);
  cli_free(&run);
  run = cli_run(RENDER, "scenes/field.glb", "-o", cli_path("p.png"), "-s", "160x90", "--camera", "hill",
                "--reflections", "planar", "--max-roughness", "0", "--stats", "-", NULL);
  cli_expect(&run, 0, "", __FILE__, __LINE__);
  stats = json_loads(run.out, 0, &error);
  json_t *flat = json_member(stats, "flat_mirrors");
  json_int_t rays = json_integer_value(json_member(flat, "rays"));
  assert_int_equal(json_integer_value(json_member(flat, "planes")), 1);
  assert_true(rays > 300 && json_integer_value(json_member(flat, "traced")) * 20 < rays);
  double stated = json_real_value(json_member(json_member(json_member(flat, "predicted"), "planar"), "bound"));
  assert_true(stated > 0 && stated < 1e-4);
  json_decref(stats);
  cli_free(&run);
}

// Each object near a mirror with the method that finds it, and why that is not a snapshot.
static void what_is_near_a_mirror_is_named_with_its_method(void **state)
{
  json_error_t error;
  CliRun run = cli_run(RENDER, "scenes/chrome.glb", "-o", cli_path("n.png"), "-s", "160x90", "--reflections", "mixed",
                       "--snapshot-from", "1000", "--cube-size", "64", "--stats", "-", NULL);
  cli_expect(&run, 0, "", __FILE__, __LINE__);
  json_t *stats = json_loads(run.out, 0, &error), *near = json_member(json_member(stats, "reflection_maps"), "near");
  json_t *reflectors = json_member(near, "reflectors"), *target;
  json_t *targets = json_member(json_array_get(reflectors, 0), "targets");
  size_t index, snapshots = 0, mirrors = 0;
  assert_int_equal(json_array_size(reflectors), 2);
  assert_string_equal(json_string_value(json_member(json_array_get(reflectors, 0), "name")), "teapot");
  assert_true(json_array_size(targets) > 5);
  json_array_foreach(targets, index, target)
  {
    bool photographed = !strcmp(json_string_value(json_member(target, "method")), "snapshot");
    const char *reason = json_string_value(json_object_get(target, "reason"));
    bool is_complex = json_integer_value(json_member(target, "triangles")) >= 1000;
    if (photographed) assert_true(is_complex && !reason);
    if (!photographed && is_complex) assert_non_null(reason);
    snapshots += photographed;
    mirrors += reason && !strcmp(reason, "mirror");
  }
  assert_true(snapshots > 2 && mirrors == 1);
  assert_true(json_integer_value(json_member(near, "snapshots")) >= (json_int_t)snapshots);
  assert_true(json_integer_value(json_member(near, "listed")) > 0);
  assert_non_null(strstr(json_string_value(json_member(stats, "settings")), "--snapshot-from 1000"));
  json_decref(stats);
  cli_free(&run);
}

// Maps tell beforehand what they may get wrong, and that covers what is measured.
static void shadow_maps_state_their_error(void **state)
{
  json_error_t error;
  CliRun run = cli_run(RENDER, "scenes/room.glb", "-o", cli_path("m.png"), "-s", "160x90", "--shadows", "map",
                       "--shadow-map-size", "256", "--verify", "all", "--stats", "-", NULL);
  cli_expect(&run, 0, "% stated by their maps", __FILE__, __LINE__);
  json_t *stats = json_loads(run.out, 0, &error), *maps = json_member(stats, "shadow_maps");
  json_t *predicted = json_member(maps, "predicted"), *verify = json_member(stats, "verify");
  double bound = json_real_value(json_member(predicted, "bound")),
         expected = json_real_value(json_member(predicted, "expected")),
         measured = json_real_value(json_member(json_member(json_member(verify, "shadows"), "off"), "share"));
  if (!(measured > 0 && measured <= bound && expected < bound && bound < 8 * measured))
    fail_msg("measured %g, expected %g, bound %g", measured, expected, bound);
  json_t *edges = json_member(json_member(verify, "shadows"), "edges");
  json_int_t edge_pixels = json_integer_value(json_member(edges, "pixels"));
  assert_true(edge_pixels > 0 && edge_pixels < 160 * 90 / 2);
  assert_true(json_real_value(json_member(json_member(edges, "off"), "share")) > measured);
  json_decref(stats);
  cli_free(&run);
}

static void the_program_says_how_many_pixels_are_off(void **state)
{
  char *stats;
  CLI_EXPECT(0, "0 % of the pixels are off by more than 2/255 (all 3072 traced)", RENDER, cli_scene(), "-o",
             cli_path("v.png"), "-s", "64x48", "--environment", "none", "--verify", "all");
  CLI_EXPECT(0, "with 95 % confidence: 512 traced in 8 tiles)", RENDER, cli_scene(), "-o", cli_path("v.png"), "-s",
             "64x48", "--environment", "none", "--verify", "500", "--stats", cli_path("v.json"));
  stats = cli_load(cli_path("v.json"), NULL);
  assert_non_null(stats);
  assert_non_null(strstr(stats, "\"verify\""));
  assert_non_null(strstr(stats, "\"off\""));
  free(stats);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reports_are_json_and_a_table),
      cmocka_unit_test(hybrid_shadows_trace_few_rays_and_say_how_many),
      cmocka_unit_test(shadows_are_chosen_by_what_they_cost),
      cmocka_unit_test(exact_reflections_say_what_they_are_made_of),
      cmocka_unit_test(reflections_by_maps_say_how_many_rays_they_answered),
      cmocka_unit_test(what_is_near_a_mirror_is_named_with_its_method),
      cmocka_unit_test(shadow_maps_state_their_error),
      cmocka_unit_test(the_program_says_how_many_pixels_are_off),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
