// Frames of an animation: each is the picture that a run for it alone makes, and what did not move is not drawn again.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

#include "support/cli.h"
#include "support/effort.h"
#include "support/stage.h"

// A mirror that shows another one to its right, which is out of sight and shows what is above it: there a box moves.
// Neither is the box on the side of the first mirror's cube on which the second mirror is. To the left a spot light
// shines along the floor.
static const char *two_mirrors_save(void)
{
  static GltfBuild build;
  memset(&build, 0, sizeof build);
  stage_cube_add(&build);
  GLTF_FLOATS(&build, "SCALAR", 2, 0, 1);
  GLTF_FLOATS(&build, "VEC3", 2, 10, 15, -3, 10, 15, 3);
  GLTF_FLOATS(&build, "VEC3", 2, -4, 2, 9, 4, 2, 9);
  GLTF_FLOATS(&build, "VEC3", 2, -8, 1, 6, -7, 1, 7);
  return gltf_save(&build, "%s",
                   "'scene':0,'scenes':[{'nodes':[0,1,2,3,4,5,6]}],"
                   "'nodes':[{'name':'floor','mesh':0,'translation':[0,-0.1,0],'scale':[14,0.1,8]},"
                   "{'name':'mirror','mesh':1,'translation':[0,1.2,0],'rotation':[0,0.3826834,0,0.9238795]},"
                   "{'name':'other','mesh':1,'translation':[10,1.2,0],'rotation':[0,0,0.3826834,0.9238795]},"
                   "{'name':'box','mesh':0,'translation':[10,15,0],'scale':[1.5,1.5,1.5]},"
                   "{'name':'lamp','translation':[5,8,3],'extensions':{'KHR_lights_punctual':{'light':0}}},"
                   "{'name':'eye','translation':[0,2,9],'camera':0},"
                   "{'name':'spot','translation':[-8,1,6],'extensions':{'KHR_lights_punctual':{'light':1}}}],"
                   "'cameras':[{'type':'perspective','perspective':{'yfov':0.5,'znear':0.1}}],"
                   "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1,'material':0}]},"
                   "{'primitives':[{'attributes':{'POSITION':0},'indices':1,'material':1}]}],"
                   "'materials':[{'pbrMetallicRoughness':{'metallicFactor':0}},"
                   "{'pbrMetallicRoughness':{'metallicFactor':1,'roughnessFactor':0}}],"
                   "'extensionsUsed':['KHR_lights_punctual'],"
                   "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':400},"
                   "{'type':'spot','intensity':900,'spot':{'innerConeAngle':0.1,'outerConeAngle':0.3}}]}},"
                   "'animations':[" TRACK("box", 3, 3) "," TRACK("eye", 4, 5) "," TRACK("spot", 5, 6) "]");
}

// What was kept in the second frame.
typedef struct Kept {
  int still_views, moving_views;  // of maps of the lamp that stands still, and of the one that may move
  int faces, all_faces;
  int cubes, deep_cubes;
} Kept;

static int member(json_t *object, const char *name) { return (int)json_integer_value(json_object_get(object, name)); }

static Kept stats_read(const char *path)
{
  json_error_t error;
  json_t *stats = json_load_file(path, 0, &error);
  assert_non_null(stats);
  json_t *lights = json_object_get(json_object_get(stats, "shadow_maps"), "lights");
  json_t *maps = json_object_get(stats, "reflection_maps");
  Kept kept = {.still_views = member(json_array_get(lights, 0), "kept"),
               .moving_views = member(json_array_get(lights, 1), "kept"),
               .faces = member(maps, "faces_kept"),
               .all_faces = member(maps, "faces"),
               .cubes = member(maps, "cubes"),
               .deep_cubes = member(maps, "deep_cubes")};
  json_decref(stats);
  return kept;
}

typedef struct Methods {
  const char *shadows;  // of all lights, or NAME=METHOD,... of each
  const char *reflections, *deep_reflections;
} Methods;

// Renders frames 6 and 12 of 24 together, and the second alone, and fails unless that is the same bytes both times, and
// another picture than the first.
static Kept frames_render(const char *scene, const char *animation, Methods methods)
{
  static const char *const names[] = {"s06.png", "s12.png", "alone.png"};
  char *bytes[3];
  size_t sizes[3];
  const char *shadows = strchr(methods.shadows, '=') ? "--light-shadows" : "--shadows";
#define RENDER(...)                                                                                     \
  CLI_EXPECT(0, "", "render", scene, "--animation", animation, "-s", "96x64", shadows, methods.shadows, \
             "--reflections", methods.reflections, "--deep-reflections", methods.deep_reflections,      \
             "--shadow-map-size", "256", "--cube-size", "64", "--max-roughness", "0", "-q", __VA_ARGS__)
  RENDER("-o", cli_path("s{frame:02}.png"), "--frames", "6-12x6", "--stats", cli_path("stats{frame:02}.json"));
  const int count = effort_is_quick() ? 2 : 3;  // a slow build looks at what sequences do alone
  if (count == 3) RENDER("-o", cli_path("alone.png"), "--frames", "12");
  for (int i = 0; i < count; i++) {
    bytes[i] = cli_load(cli_path("%s", names[i]), &sizes[i]);
    assert_non_null(bytes[i]);
  }
  assert_true(sizes[0] != sizes[1] || memcmp(bytes[0], bytes[1], sizes[0]) != 0);
  if (count == 3 && (sizes[1] != sizes[2] || memcmp(bytes[1], bytes[2], sizes[1]) != 0))
    fail_msg("%s, shadows %s, reflections %s: a frame depends on those before it", animation, methods.shadows,
             methods.reflections);
  for (int i = 0; i < count; i++) free(bytes[i]);
  return stats_read(cli_path("stats12.json"));
}

// Maps look out from lamps, whatever the camera sees; cubes stand about what the camera sees.
static void a_moving_camera_keeps_all_maps(void **state)
{
  const char *scene = stage_save();
  Kept kept = frames_render(scene, "eye", (Methods){"pcf", "impostor", "environment"});
  assert_int_equal(kept.still_views, 6);
  assert_int_equal(kept.moving_views, 6);
  assert_true(kept.cubes > 0);
  assert_int_equal(kept.faces, kept.all_faces);
  kept = frames_render(scene, "eye", (Methods){"rays", "mixed", "rays"});
  assert_true(kept.cubes > 0);
  assert_int_equal(kept.faces, kept.all_faces);
}

static void a_moving_lamp_redraws_its_own_maps_alone(void **state)
{
  const char *scene = stage_save();
  Kept kept = frames_render(scene, "lamp", (Methods){"map", "cube", "environment"});
  assert_int_equal(kept.still_views, 6);
  assert_int_equal(kept.moving_views, 0);
  assert_int_equal(kept.faces, 0);
  kept = frames_render(scene, "lamp", (Methods){"rays", "box", "environment"});
  assert_int_equal(kept.faces, 0);
  kept = frames_render(scene, "lamp", (Methods){"hybrid", "rays", "rays"});
  assert_int_equal(kept.still_views, 6);
  assert_int_equal(kept.moving_views, 0);
}

static void lamps_keep_maps_by_their_own_methods(void **state)
{
  const char *scene = stage_save();
  Kept kept = frames_render(scene, "lamp", (Methods){"still=pcf,moving=hybrid", "cube", "environment"});
  assert_int_equal(kept.still_views, 6);
  assert_int_equal(kept.moving_views, 0);
  assert_int_equal(kept.faces, 0);
  kept = frames_render(scene, "box", (Methods){"still=hybrid,moving=pcf", "cube", "environment"});
  assert_int_equal(kept.still_views, 5);  // the box is in one view
  assert_in_range(kept.moving_views, 1, 5);
  assert_int_equal(kept.faces, 0);  // maps blur the edges of shadows
}

// The box is off to one side of lamps and mirror.
static void a_moving_box_redraws_the_faces_that_see_it(void **state)
{
  const char *scene = stage_save();
  Kept kept = frames_render(scene, "box", (Methods){"pcf", "cube", "environment"});
  assert_in_range(kept.still_views, 1, 5);
  assert_in_range(kept.moving_views, 1, 5);
  assert_int_equal(kept.faces, 0);  // maps blur the edges of shadows
  kept = frames_render(scene, "box", (Methods){"rays", "impostor", "environment"});
  assert_in_range(kept.faces, 1, kept.all_faces - 1);
  kept = frames_render(scene, "box", (Methods){"rays", "box", "rays"});
  assert_int_equal(kept.faces, 0);  // it may be seen by way of another mirror
  kept = frames_render(scene, "box", (Methods){"hybrid", "hybrid", "rays"});
  assert_in_range(kept.still_views, 1, 5);
  assert_in_range(kept.moving_views, 1, 5);
  assert_int_equal(kept.faces, 0);
  frames_render(scene, "box", (Methods){"pcss", "snapshot", "rays"});
}

// The box, by a scene file, casts no shadow.
static void what_casts_no_shadow_leaves_maps_as_they_are(void **state)
{
  static const char format[] = "{\"scene\": \"%s\", \"nodes\": {\"box\": {\"casts_shadow\": false}}}";
  char json[512];
  snprintf(json, sizeof json, format, strrchr(stage_save(), '/') + 1);
  const char *scene = cli_path("stage.json");
  cli_save(scene, json, strlen(json));
  char *path = strdup(scene);
  Kept kept = frames_render(path, "box", (Methods){"pcf", "impostor", "environment"});
  assert_int_equal(kept.still_views, 6);
  assert_int_equal(kept.moving_views, 6);
  kept = frames_render(path, "box", (Methods){"rays", "impostor", "environment"});
  assert_in_range(kept.faces, 1, kept.all_faces - 1);
  frames_render(path, "box", (Methods){"hybrid", "none", "none"});
  free(path);
}

// It is seen on one face of the mirror's cube, its shadow on another; the camera sees the shadow alone.
static void what_is_out_of_sight_moves_its_shadow(void **state)
{
  const char *scene = stage_save();
  Kept kept = frames_render(scene, "kite", (Methods){"rays", "cube", "environment"});
  assert_in_range(kept.faces, 1, kept.all_faces - 2);
  kept = frames_render(scene, "kite", (Methods){"hybrid", "none", "none"});
  assert_in_range(kept.still_views, 1, 5);
}

// The second mirror's cube is drawn anew, and the side of the first mirror's on which that is seen.
static void what_moves_in_a_mirror_in_a_mirror_is_followed(void **state)
{
  static const char *const methods[] = {"box", "impostor"};
  const char *scene = two_mirrors_save();
  for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) {
    Kept kept = frames_render(scene, "box", (Methods){"none", methods[i], methods[i]});
    assert_int_equal(kept.cubes, 2);
    assert_int_equal(kept.deep_cubes, 1);
    assert_in_range(kept.faces, 6, kept.all_faces - 3);
  }
  // From the left the second mirror is not seen.
  Kept kept = frames_render(scene, "eye", (Methods){"none", "box", "box"});
  assert_int_equal(kept.deep_cubes, 1);
}

// Of the first mirror's cube the sides that look to the left, ahead, and on the second mirror; of that one's the left.
static void a_moving_spot_light_redraws_the_faces_that_it_may_light(void **state)
{
  const char *scene = two_mirrors_save();
  assert_int_equal(frames_render(scene, "spot", (Methods){"rays", "box", "box"}).faces, 8);
  assert_int_equal(frames_render(scene, "spot", (Methods){"pcf", "cube", "environment"}).faces, 4);
  assert_int_equal(frames_render(scene, "spot", (Methods){"rays", "box", "rays"}).faces, 0);
}

static void frames_and_their_names_are_checked(void **state)
{
  const char *scene = stage_save();
#define REFUSED(message, ...) CLI_EXPECT(2, message, "render", scene, __VA_ARGS__)
  REFUSED("add --frames", "-o", cli_path("{frame}.png"));
  REFUSED("add --frames", "-o", cli_path("a.png"), "--fps", "30");
  REFUSED("add --frames", "-o", cli_path("a.png"), "--animation", "box");
  REFUSED("one name for many frames", "-o", cli_path("a.png"), "--frames", "0-1");
  REFUSED("one name for many frames", "-o", cli_path("a.png"), "--frames", "all");
  REFUSED("one name for many frames", "-o", cli_path("{frame}.png"), "--frames", "0-1", "--stats", cli_path("a.json"));
  REFUSED("unknown name in braces", "-o", cli_path("{frame}{view}.png"), "--frames", "0-1");
  REFUSED("no animation 'boxx'", "-o", cli_path("{frame}.png"), "--frames", "0", "--animation", "boxx");
  static const char *const ranges[] = {"",     "-1",    "1-",    "5-4",          "1x2",        "0-4x0", "0-4x",
                                       "0-4 ", "first", "1.5-2", "0-4294967296", "9999999999", "0--4",  "all4"};
  for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++)
    if (strcmp(ranges[i], "1x2") != 0) REFUSED("--frames", "-o", cli_path("{frame}.png"), "--frames", ranges[i]);
  REFUSED("in parts", "-o", cli_path("{frame}.png"), "--frames", "0-1000000");
  REFUSED("--fps 0", "-o", cli_path("{frame}.png"), "--frames", "0", "--fps", "0");
}

// A second at 4 frames a second, the one at its end included; a frame that is there already ends the run before any.
static void all_frames_are_those_of_the_animation(void **state)
{
  const char *scene = stage_save();
  CLI_EXPECT(0, "", "render", scene, "-o", cli_path("out/all{frame:03}.png"), "--frames", "all", "--fps", "4", "-s",
             "16x16", "-q");
  assert_string_equal(cli_list(cli_path("out")), "all000.png all001.png all002.png all003.png all004.png old.png");
  CLI_EXPECT(5, "is there already", "render", scene, "-o", cli_path("out/all{frame:03}.png"), "--frames", "2-7",
             "--no-clobber", "-s", "16x16", "-q");
  assert_string_equal(cli_list(cli_path("out")), "all000.png all001.png all002.png all003.png all004.png old.png");
}

// What rises by ten times its size is in the view of all from first to last.
static void a_view_of_all_holds_what_moves(void **state)
{
  static GltfBuild build;
  memset(&build, 0, sizeof build);
  stage_cube_add(&build);
  GLTF_FLOATS(&build, "SCALAR", 2, 0, 1);
  GLTF_FLOATS(&build, "VEC3", 2, 0, 0, 0, 0, 20, 0);
  const char *scene = gltf_save(
      &build, "%s",
      "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},"
      "'indices':1}]}],'animations':[" TRACK("rise", 3, 0) "]");
  CliRun run = cli_run("render", scene, "-o", cli_path("rise{frame}.png"), "--frames", "0-24x6", "-s", "64x64", NULL);
  cli_expect(&run, 0, "", __FILE__, __LINE__);
  assert_null(strstr(run.err, "shows no surface"));
  cli_free(&run);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_moving_camera_keeps_all_maps),
      cmocka_unit_test(a_moving_lamp_redraws_its_own_maps_alone),
      cmocka_unit_test(lamps_keep_maps_by_their_own_methods),
      cmocka_unit_test(a_moving_box_redraws_the_faces_that_see_it),
      cmocka_unit_test(what_casts_no_shadow_leaves_maps_as_they_are),
      cmocka_unit_test(what_is_out_of_sight_moves_its_shadow),
      cmocka_unit_test(what_moves_in_a_mirror_in_a_mirror_is_followed),
      cmocka_unit_test(a_moving_spot_light_redraws_the_faces_that_it_may_light),
      cmocka_unit_test(frames_and_their_names_are_checked),
      cmocka_unit_test(a_view_of_all_holds_what_moves),
      cmocka_unit_test(all_frames_are_those_of_the_animation),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
