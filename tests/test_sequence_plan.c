// What a plan knows of a sequence before its first frame: --shadows auto.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

#include "support/cli.h"
#include "support/stage.h"
#include "support/test_device.h"

// Renders frames so small that hybrid shadows gain only where their maps are kept; the "plan" of the frame `last`.
static json_t *plan_of(const char *scene, const char *frames, const char *last, const char *option, const char *value)
{
  json_error_t error;
  CLI_EXPECT(0, "", "render", scene, "-s", "48x32", "--shadows", "auto", "--reflections", "none", "-q", "-o",
             cli_path("f{frame}.png"), "--stats", cli_path("f{frame}.json"), "--frames", frames, option, value);
  json_t *stats = json_load_file(cli_path("f%s.json", last), 0, &error);
  assert_non_null(stats);
  json_t *plan = json_incref(json_object_get(stats, "plan"));
  json_decref(stats);
  return plan;
}

// Fails unless the plan is for so many frames, of whose views between two shares stay, and takes this method.
static void plan_expect(json_t *plan, const char *lights, int frames, double least, double most, const char *method)
{
  json_t *costs = json_object_get(json_object_get(plan, "shadow_ms"), lights);
  const double kept = json_number_value(json_object_get(costs, "kept"));
  const double sequence = json_number_value(json_object_get(costs, "hybrid_sequence")),
               rays = json_number_value(json_object_get(costs, "rays"));
  assert_int_equal(json_integer_value(json_object_get(plan, "sequence")), frames);
  assert_true(kept >= least && kept <= most);
  assert_string_equal(json_string_value(json_object_get(costs, "method")), method);
  assert_string_equal(json_string_value(json_object_get(plan, "shadows")), method);
  assert_true(sequence > 0 && (sequence < 0.5 * rays) == (strcmp(method, "hybrid") == 0));
  json_decref(plan);
}

// What is chosen for a small picture where most is kept: a launch alone takes a GPU longer than such a picture's rays.
static const char *choice_of_small(void) { return test_on_gpu() ? "rays" : "hybrid"; }

static void auto_counts_what_will_be_kept(void **state)
{
  const char *scene = stage_save();
  plan_expect(plan_of(scene, "3", "3", "--animation", "eye"), "point", 25, 0, 0, "rays");
  plan_expect(plan_of(scene, "0-1", "1", "--fps", "1"), "point", 2, 0.3, 0.99, "rays");  // too few to gain
}

// Whichever frames are rendered, all are by the same plan, and to the same bytes. Some of the lamps' views see the
// kite.
static void parts_of_a_sequence_choose_as_the_whole(void **state)
{
  size_t sizes[2];
  const char *scene = stage_save();
  json_t *two = plan_of(scene, "6-12x6", "12", "--animation", "kite");
  char *in_two = cli_load(cli_path("f12.png"), &sizes[0]);
  json_t *alone = plan_of(scene, "12", "12", "--animation", "kite");
  char *by_itself = cli_load(cli_path("f12.png"), &sizes[1]);
  assert_non_null(in_two);
  assert_non_null(by_itself);
  assert_true(json_equal(two, alone));
  assert_true(sizes[0] == sizes[1] && memcmp(in_two, by_itself, sizes[0]) == 0);
  free(in_two);
  free(by_itself);
  json_decref(alone);
  plan_expect(two, "point", 25, 0.5, 0.99, choice_of_small());
}

// Without an animation there is no whole but the frames that are asked for.
static void auto_counts_the_frames_of_a_still_scene(void **state)
{
  static GltfBuild build;
  memset(&build, 0, sizeof build);
  stage_cube_add(&build);
  const char *scene = gltf_save(&build, "%s",
                                "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],'meshes':[{'primitives':"
                                "[{'attributes':{'POSITION':0},'indices':1}]}]");
  plan_expect(plan_of(scene, "4-8", "8", "-s", "16x16"), "directional", 5, 1, 1, choice_of_small());
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(auto_counts_what_will_be_kept),
      cmocka_unit_test(parts_of_a_sequence_choose_as_the_whole),
      cmocka_unit_test(auto_counts_the_frames_of_a_still_scene),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
