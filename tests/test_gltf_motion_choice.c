// Animations of glTF files: which is chosen, what of it is not followed, and what is refused.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/gltf_build.h"
#include "support/scene_same.h"

#define ONE_MESH "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"

// ---- choice --------------------------------------------------------------------------------------------------------

// A triangle that three animations move, to 1, 2 and 3.
static const char *choices_save(void)
{
  GltfBuild build = gltf_targets_build();
  char animations[1024] = "";
  const char *const names[] = {"walk", "run", "2"};
  GLTF_FLOATS(&build, "SCALAR", 1, 0);
  for (int i = 0; i < 3; i++) {
    float value[3] = {(float)(i + 1)};
    int output = gltf_array(&build, 5126, "VEC3", value, sizeof value, 1, "");
    snprintf(animations + strlen(animations), sizeof animations - strlen(animations),
             "%s{'name':'%s','samplers':[{'input':3,'output':%d}],'channels':[" GLTF_TRACK(0, 0, "translation") "]}",
             i ? "," : "", names[i], output);
  }
  return gltf_save(&build, ONE_NODE "," ONE_MESH ",'animations':[%s]", animations);
}

static void animations_are_chosen_by_name_or_index(void **state)
{
  const struct {
    const char *choice;
    double x;
  } cases[] = {{NULL, 1}, {"walk", 1}, {"run", 2}, {"0", 1}, {"1", 2}, {"2", 3}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    Scene scene;
    GltfMotion *motion = gltf_motion_fine(&scene, choices_save(), cases[i].choice);
    assert_int_equal(strstr(gltf_warnings, "animation 0 'walk' of 3 is followed") != NULL, !cases[i].choice);
    gltf_pose_fine(motion, &scene, 0);
    assert_near(scene.objects[0].world_from_object.m[12], cases[i].x);
    gltf_motion_end(motion, &scene);
  }
  gltf_motion_fails(choices_save(), "rum", STATUS_USAGE, "no animation 'rum': did you mean 'run'?");
  gltf_motion_fails(choices_save(), "3", STATUS_USAGE, "no animation 3: the file has 3: ");
  gltf_motion_fails(choices_save(), "99999999999999999999999", STATUS_USAGE, "the file has 3");
  gltf_motion_fails("scenes/room.glb", "walk", STATUS_USAGE, "no animation 'walk': it has none");
  gltf_motion_fails("none.glb", NULL, STATUS_NOT_FOUND, "none.glb: ");
}

static void a_file_without_animations_stands_still(void **state)
{
  Scene scene, still = gltf_read_fine("scenes/room.glb");
  GltfMotion *motion = gltf_motion_fine(&scene, "scenes/room.glb", NULL);
  assert_string_equal(gltf_warnings, "");
  assert_true(gltf_motion_length_s(motion) == 0);
  gltf_pose_fine(motion, &scene, 3);
  assert_true(scenes_same(&scene, &still));
  gltf_motion_end(motion, &scene);
  scene_free(&still);
}

// ---- what is not followed, and what is refused ---------------------------------------------------------------------

// Opens a triangle below two nodes (1 has a matrix) whose accessors 3 to 6 are times and values of two keys.
static const char *sampled_save(const char *animation)
{
  GltfBuild build = gltf_targets_build();
  GLTF_FLOATS(&build, "SCALAR", 2, 0, 1);                  // 3
  GLTF_FLOATS(&build, "VEC3", 2, 0, 0, 0, 2, 2, 2);        // 4
  GLTF_FLOATS(&build, "SCALAR", 4, 0, 0, 1, 1);            // 5
  GLTF_FLOATS(&build, "VEC4", 2, 0, 0, 0, 1, 0, 0, 1, 0);  // 6
  GLTF_FLOATS(&build, "SCALAR", 2, 1, 1);                  // 7: does not rise
  GLTF_FLOATS(&build, "SCALAR", 2, 1, 0.5f);               // 8: falls
  GLTF_FLOATS(&build, "SCALAR", 2, -1, 1);                 // 9: begins before the beginning
  GLTF_FLOATS(&build, "SCALAR", 2, 0, INFINITY);           // 10
  GLTF_FLOATS(&build, "SCALAR", 2, NAN, 1);                // 11
  GLTF_FLOATS(&build, "VEC3", 2, 0, 0, 0, NAN, 2, 2);      // 12
  const uint16_t shorts[] = {0, 1, 2, 3};
  gltf_array(&build, 5123, "SCALAR", shorts, sizeof shorts, 4, "");                    // 13: not normalised
  gltf_array(&build, 5123, "SCALAR", shorts, sizeof shorts, 4, ",'normalized':true");  // 14
  GLTF_FLOATS(&build, "VEC3", 2, 0, 0, 0, 3e38f, 0, 0);                                // 15
  GLTF_FLOATS(&build, "SCALAR", 4, 0, 0, 3e38f, 3e38f);                                // 16
  return gltf_save(
      &build,
      "'extensionsUsed':['KHR_lights_punctual'],'extensions':{'KHR_lights_punctual':{'lights':[{'type':"
      "'point'}]}},'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0,'name':'thing'},{'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,"
      "0,0,1],'children':[2]},{'name':'bare','scale':[1e300,1e300,1e300],'children':[3]},{'name':'far',"
      "'extensions':{'KHR_lights_punctual':{'light':0}}}],'meshes':[{'primitives':[{'attributes':{'POSITION'"
      ":0},'targets':[{'POSITION':1},{'POSITION':1}]}]}]"
      ",'animations':[{'name':'it',%s}]",
      animation);
}

#define SAMPLER(input, output) "'samplers':[{'input':" #input ",'output':" #output "}]"

static void channels_that_are_not_followed_are_named(void **state)
{
  const struct {
    const char *animation, *warning;
    double x;
  } cases[] = {
      {SAMPLER(3, 4) ",'channels':[" GLTF_TRACK(0, 1, "translation") "]",
       "animations[0] 'it' channels[0], the translation of nodes[1], is not followed: the node has a matrix: give it",
       0},
      {SAMPLER(3, 5) ",'channels':[" GLTF_TRACK(0, 2, "weights") "]",
       "the weights of nodes[2], is not followed: it draws no morph targets", 0},
      {SAMPLER(3, 4) ",'channels':[" GLTF_TRACK(0, 0, "translation") "," GLTF_TRACK(0, 0, "translation") "]",
       "channels[1], the translation of nodes[0], is not followed: an earlier channel moves the same", 2},
      {SAMPLER(3, 4) ",'channels':[" GLTF_TRACK(0, 0, "pointer") "," GLTF_TRACK(0, 0, "translation") "]",
       "channels[0] is not followed: it moves 'pointer'", 2},
      {SAMPLER(3, 4) ",'channels':[{'sampler':0,'target':{'path':'pointer','extensions':{'KHR_animation_pointer':{"
                     "'pointer':'/nodes/0/translation'}}}}," GLTF_TRACK(0, 0, "translation") "]",
       "channels[0] is not followed: it moves 'pointer'", 2},
      {SAMPLER(3, 4) ",'channels':[{'sampler':0,'target':{'path':'translation'}}," GLTF_TRACK(0, 0, "translation") "]",
       "", 2},
      {SAMPLER(3, 7) ",'channels':[]", "", 0},
      {"'samplers':[],'channels':[]", "", 0},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    Scene scene;
    GltfMotion *motion = gltf_motion_fine(&scene, sampled_save(cases[i].animation), NULL);
    if (!strstr(gltf_warnings, cases[i].warning) || (*gltf_warnings && !*cases[i].warning))
      fail_msg("case %zu: '%s' without '%s'", i, gltf_warnings, cases[i].warning);
    gltf_pose_fine(motion, &scene, 1);
    assert_near(scene.objects[0].world_from_object.m[12], cases[i].x);
    gltf_motion_end(motion, &scene);
  }
}

static void bad_keys_are_refused_and_rest_is_drawn(void **state)
{
  const struct {
    const char *animation, *message;
  } cases[] = {
      {SAMPLER(7, 4), "animations[0] 'it' channels[0]: key 1, at 1 s, does not follow the one at 1 s: repair"},
      {SAMPLER(8, 4), "key 1, at 0.5 s, does not follow the one at 1 s"},
      {SAMPLER(9, 4), "channels[0]: its first key is at -1 s"},
      {SAMPLER(10, 4), "channels[0]: accessors[10] element 1 is not a finite number"},
      {SAMPLER(11, 4), "accessors[11] element 0 is not a finite number"},
      {SAMPLER(4, 4), "accessors[4] has 3 components, not 1"},
      {SAMPLER(14, 4), "accessors[14], its times, holds no floats"},
      {SAMPLER(3, 5), "accessors[5] has 1 components, not 3"},
      {SAMPLER(3, 6), "accessors[6] has 4 components, not 3"},
      {SAMPLER(3, 0), "accessors[0] has 3 elements, not 2"},
      {SAMPLER(3, 12), "accessors[12] element 1 is not a finite number"},
      {"'samplers':[{'input':3,'output':4,'interpolation':'CUBICSPLINE'}]", "accessors[4] has 2 elements, not 6"},
  };
  char text[512];
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    snprintf(text, sizeof text, "%s,'channels':[" GLTF_TRACK(0, 0, "translation") "]", cases[i].animation);
    gltf_motion_fails(sampled_save(text), NULL, STATUS_BAD_SCENE, cases[i].message);
    Scene scene = gltf_read_fine(sampled_save(text));
    assert_non_null(strstr(gltf_warnings, "1 animations: the pose at rest is drawn: add --frames to see them move"));
    scene_free(&scene);
  }
  gltf_motion_fails(sampled_save(SAMPLER(3, 7) ",'channels':[" GLTF_TRACK(0, 0, "weights") "]"), NULL, STATUS_BAD_SCENE,
                    "accessors[7] has 2 elements, not 4");
  gltf_motion_fails(sampled_save(SAMPLER(3, 13) ",'channels':[" GLTF_TRACK(0, 0, "weights") "]"), NULL,
                    STATUS_BAD_SCENE, "accessors[13] holds integers that are not normalized");
  gltf_motion_fails(sampled_save(SAMPLER(3, 4) ",'channels':[" GLTF_TRACK(0, 0, "rotation") "]"), NULL,
                    STATUS_BAD_SCENE, "accessors[4] has 3 components, not 4");
}

static void a_pose_that_leaves_all_numbers_is_refused(void **state)
{
  const struct {
    const char *animation, *message;
  } cases[] = {
      {SAMPLER(3, 15) ",'channels':[" GLTF_TRACK(0, 3, "scale") "]",
       "nodes[3] 'far' has a transform that is not finite"},
      {SAMPLER(3, 4) ",'channels':[" GLTF_TRACK(0, 3, "translation") "]", "the light 'far' goes to infinity"},
      {SAMPLER(3, 16) ",'channels':[" GLTF_TRACK(0, 0, "weights") "]",
       "meshes[0] '' primitives[0]: vertex 0 is not finite in its pose"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    Scene scene;
    GltfMotion *motion = gltf_motion_fine(&scene, sampled_save(cases[i].animation), NULL);
    gltf_pose_fine(motion, &scene, 0);
    gltf_pose_fails(motion, &scene, 1, STATUS_BAD_SCENE, cases[i].message);
    gltf_pose_fine(motion, &scene, 0);
    gltf_motion_end(motion, &scene);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(animations_are_chosen_by_name_or_index),
      cmocka_unit_test(a_file_without_animations_stands_still),
      cmocka_unit_test(channels_that_are_not_followed_are_named),
      cmocka_unit_test(bad_keys_are_refused_and_rest_is_drawn),
      cmocka_unit_test(a_pose_that_leaves_all_numbers_is_refused),
  };
  return cmocka_run_group_tests(tests, gltf_tests_begin, gltf_tests_end);
}
