// `frugal devices` and `frugal info` tell what is there, what works and what is missing.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>
#include <jansson.h>

#include "device/diagnose.h"
#include "support/cli.h"
#include "support/gltf_build.h"
#include "support/test_device.h"

// What a run prints as JSON, with the exit code that is expected, or -1 for any; frees the run.
static json_t *printed(CliRun run, int exit_code)
{
  json_error_t error;
  json_t *json = json_loads(run.out, 0, &error);
  if ((exit_code >= 0 && run.exit_code != exit_code) || !json)
    fail_msg("exit code %d: %s%s", run.exit_code, run.out, run.err);
  cli_free(&run);
  return json;
}

static json_t *member(const json_t *json, const char *name)
{
  json_t *found = json_is_array(json) ? json_array_get(json, strtoul(name, NULL, 10)) : json_object_get(json, name);
  if (!found) fail_msg("no %s", name);
  return found;
}

static void each_device_renders_a_known_picture(void **state)
{
  json_t *report = printed(cli_run("devices", "--json", NULL), 0);
  const json_t *device = member(member(report, "devices"), "0"), *test = member(device, "self_test");
  assert_true(json_is_true(member(test, "passed")));
  assert_string_equal(json_string_value(member(test, "message")), "");
  assert_true(*json_string_value(member(device, "name")) && *json_string_value(member(device, "driver")));
  assert_true(json_integer_value(member(device, "memory_bytes")) > 1 << 20);
  assert_true(json_array_size(member(report, "platforms")) > 0);
  json_decref(report);

  CliRun run = cli_run("devices", "--no-self-test", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_int_equal(strncmp(run.out, "0  ", 3), 0);
  assert_null(strstr(run.out, "self-test"));
  cli_free(&run);
}

// A wrong number in what comes back fails it, wherever it is: in counts, colours, distances or objects.
static void a_device_that_computes_wrong_fails(void **state)
{
  for (int i = 1; i <= 5; i++) {
    char fault[40];
    snprintf(fault, sizeof fault, "FRUGAL_FAULT=corrupt:%d", i);
    cli_setting.environment[0] = fault;
    CliRun run = cli_run("devices", "--json", NULL);
    int exit_code = run.exit_code;
    json_t *report = printed(run, -1);
    const json_t *devices = member(report, "devices"), *test = member(member(devices, "0"), "self_test");
    assert_int_equal(exit_code, json_array_size(devices) == 1 ? 3 : 0);  // the fault meets the first alone
    assert_true(json_is_false(member(test, "passed")));
    const char *message = json_string_value(member(test, "message"));
    if (!strstr(message, i < 3 ? "it computes wrong" : "is right: update its driver")) fail_msg("%d: %s", i, message);
    json_decref(report);
  }
}

static void without_a_device_it_says_what_to_install(void **state)
{
  if (test_skips_on_gpu("a machine without a device")) return;
  char vendors[600];
  snprintf(vendors, sizeof vendors, "OCL_ICD_VENDORS=%s", cli_path("vendors"));
  mkdir(cli_path("vendors"), 0777);
  cli_setting.environment[0] = vendors;
  CliRun run = cli_run("devices", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.out,
                         "vendors: no OpenCL runtime is installed: install pocl-opencl-icd (any CPU); nvidia-opencl-"
                         "icd"));
  assert_non_null(strstr(run.err, "frugal: OpenCL: no device: install an OpenCL runtime"));
  cli_free(&run);
  cli_setting.environment[0] = vendors;
  CLI_EXPECT(3, "frugal: OpenCL: no device: install", "render", cli_scene(), "-o", cli_path("a.png"));
}

static bool finds(const Diagnosis *diagnosis, const char *text)
{
  for (uint32_t i = 0; i < diagnosis->count; i++)
    if (strstr(diagnosis->findings[i], text)) return true;
  return false;
}

static void save_line(const char *path, const char *line) { cli_save(path, line, strlen(line)); }

static void broken_runtimes_and_lone_gpus_are_named(void **state)
{
  mkdir(cli_path("icd"), 0777);
  mkdir(cli_path("pci"), 0777);
  save_line(cli_path("icd/broken.icd"), "libno-such-runtime.so.1\n");
  save_line(cli_path("icd/empty.icd"), "\n");
  save_line(cli_path("icd/fine.icd"), "libm.so.6\n");
  save_line(cli_path("icd/notes.txt"), "libnotes.so\n");
  static const char *const cards[][3] = {{"0000:01:00.0", "0x030200\n", "0x10de\n"},
                                         {"0000:02:00.0", "0x030000\n", "0x1002\n"},
                                         {"0000:03:00.0", "0x020000\n", "0x8086\n"},
                                         {"0000:04:00.0", "0x030000\n", "0x1a03\n"}};
  for (int i = 0; i < 4; i++) {
    mkdir(cli_path("pci/%s", cards[i][0]), 0777);
    save_line(cli_path("pci/%s/class", cards[i][0]), cards[i][1]);
    save_line(cli_path("pci/%s/vendor", cards[i][0]), cards[i][2]);
  }
  Diagnosis diagnosis;
  DiagnosisPlaces places = {cli_path("icd"), cli_path("pci")};
  device_diagnose(&diagnosis, &places);
  assert_true(finds(&diagnosis, "broken.icd: libno-such-runtime.so.1: cannot open shared object file"));
  assert_true(finds(&diagnosis, "empty.icd: names no library"));
  assert_false(finds(&diagnosis, "fine.icd") || finds(&diagnosis, "notes"));
  bool has_nvidia = false;
  for (uint32_t i = 0; i < diagnosis.platform_count; i++)
    has_nvidia |= strstr(diagnosis.platforms[i], "NVIDIA") != NULL;
  assert_true(finds(&diagnosis, "NVIDIA GPU (0000:01:00.0): no OpenCL for it: install nvidia-opencl-icd") !=
              has_nvidia);
  assert_true(finds(&diagnosis, "AMD GPU (0000:02:00.0): no OpenCL for it: install mesa-opencl-icd"));
  assert_false(finds(&diagnosis, "Intel") || finds(&diagnosis, "0000:04"));  // a network card; a server's own display
}

static void no_such_device_names_what_there_is(void **state)
{
  CLI_EXPECT(2, "--device no-such: no such device: `frugal devices` lists ", "render", cli_scene(), "-o",
             cli_path("a.png"), "--device", "no-such");
  CLI_EXPECT(2, "--device 99: no such device", "render", cli_scene(), "-o", cli_path("a.png"), "--device", "99");
}

// Counted by hand: a square drawn three times, a triangle once. Without normals of their own their corners are
// unshared.
static const char *counted_scene(void)
{
  static const uint16_t corners[6] = {0, 1, 2, 0, 2, 3};
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 4, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0);
  gltf_array(&build, 5123, "SCALAR", corners, sizeof corners, 6, "");
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  return gltf_save(
      &build,
      "'scene':0,'scenes':[{'nodes':[0,1,2,3,4,5]}],"
      "'nodes':[{'mesh':0},{'mesh':0,'translation':[10,0,0]},{'mesh':0,'translation':[0,-5,2]},{'mesh':1},"
      "{'name':'eye','camera':0},{'extensions':{'KHR_lights_punctual':{'light':0}}}],"
      "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1,'material':0}]},"
      "{'primitives':[{'attributes':{'POSITION':2}}]}],"
      "'materials':[{'alphaMode':'MASK'}],"
      "'cameras':[{'type':'perspective','perspective':{'yfov':0.5,'znear':1}}],"
      "'animations':[{'channels':[],'samplers':[]}],"
      "'extensionsUsed':['KHR_lights_punctual','KHR_materials_sheen'],'extensionsRequired':['KHR_lights_punctual'],"
      "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{},'intensity':7,'name':'lamp'}]}}");
}

static void assert_number(const json_t *json, double expected)
{
  assert_true(json_is_number(json) && fabs(json_number_value(json) - expected) < 1e-6);
}

static void info_counts_what_is_drawn(void **state)
{
  json_t *info = printed(cli_run("info", counted_scene(), "--json", NULL), 0);
  assert_number(member(info, "objects"), 4);
  assert_number(member(info, "meshes"), 2);
  assert_number(member(info, "primitives"), 2);
  assert_number(member(member(info, "triangles"), "stored"), 3);
  assert_number(member(member(info, "triangles"), "drawn"), 7);
  assert_number(member(member(member(info, "bounds"), "low"), "1"), -5);
  assert_number(member(member(member(info, "bounds"), "high"), "0"), 11);
  assert_number(member(member(member(info, "bounds"), "high"), "2"), 2);
  assert_string_equal(json_string_value(member(member(member(info, "cameras"), "0"), "name")), "eye");
  assert_number(member(member(member(info, "cameras"), "0"), "yfov_rad"), 0.5);
  assert_string_equal(json_string_value(member(member(member(info, "lights"), "0"), "kind")), "spot");
  assert_number(member(member(member(info, "lights"), "0"), "intensity"), 7);
  const json_t *file = member(info, "file");
  assert_number(member(file, "nodes"), 6);
  assert_number(member(file, "animations"), 1);
  assert_number(member(file, "skins"), 0);
  assert_true(json_is_true(member(member(member(file, "extensions"), "0"), "required")));
  assert_true(json_is_false(member(member(member(file, "extensions"), "1"), "required")));
  json_decref(info);
}

// The same lines that a render would print.
static void info_warns_as_render_does(void **state)
{
  const char *scene = counted_scene();
  json_t *info = printed(cli_run("info", scene, "--json", NULL), 0);
  CliRun run = cli_run("render", scene, "--list-cameras", NULL);
  const json_t *warnings = member(info, "warnings");
  size_t lines = 0;
  for (const char *c = run.err; *c; c++) lines += *c == '\n';
  assert_int_equal(json_array_size(warnings), lines);
  assert_true(lines >= 2);  // the animation and the extension
  for (size_t i = 0; i < lines; i++) assert_non_null(strstr(run.err, json_string_value(json_array_get(warnings, i))));
  assert_non_null(strstr(run.err, "uses the extension KHR_materials_sheen, which is ignored"));
  cli_free(&run);
  run = cli_run("info", scene, NULL);
  assert_int_equal(run.exit_code, 0);
  assert_string_equal(run.err, "");
  assert_non_null(
      strstr(run.out, "draws       7 triangles (3 stored, 9 vertices) in 4 objects of 2 meshes, 2 primitives\n"));
  cli_free(&run);
  json_decref(info);
}

// By index, name, length and what moves; a bad one is listed and warned of.
static void info_lists_animations(void **state)
{
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  GLTF_FLOATS(&build, "SCALAR", 2, 0.5f, 2.5f);
  GLTF_FLOATS(&build, "VEC3", 2, 0, 0, 0, 1, 1, 1);
  const char *
      scene = gltf_save(&build, ONE_NODE
                        ",'meshes':[{'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':0}]}]}],'"
                        "animations':[{"
                        "'name':'sway','samplers':[{'input':1,'output':2},{'input':1,'output':1}],'channels':"
                        "[" GLTF_TRACK(0, 0, "scale") "," GLTF_TRACK(0, 0, "translation") "," GLTF_TRACK(
                            1,
                            0, "weights") "]},{'name':'bad','samplers':[{'input':2,'output':2}],'channels':"
                                          "[" GLTF_TRACK(0, 0, "scale") "]}]");
  json_t *info = printed(cli_run("info", scene, "--json", NULL), 0);
  const json_t *sway = member(member(info, "animations"), "0"), *bad = member(member(info, "animations"), "1");
  assert_string_equal(json_string_value(member(sway, "name")), "sway");
  assert_number(member(sway, "length_s"), 2.5);
  assert_number(member(sway, "nodes_moved"), 1);
  assert_number(member(sway, "nodes_morphed"), 1);
  assert_true(json_is_null(member(bad, "length_s")));
  json_decref(info);
  CliRun run = cli_run("info", scene, NULL);
  assert_non_null(strstr(run.out, "animations  0 'sway', 2.5 s, moves 1 nodes, morphs 1\n"));
  assert_non_null(strstr(run.out, "            1 'bad', cannot be followed\n"));
  assert_non_null(strstr(run.out, ": 2 animations: the pose at rest is drawn: add --frames to see them move\n"));
  assert_non_null(strstr(run.out, ": animations[1] 'bad' channels[0]: accessors[2] has 3 components, not 1: repair"));
  cli_free(&run);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_device_renders_a_known_picture),
      cmocka_unit_test(a_device_that_computes_wrong_fails),
      cmocka_unit_test(without_a_device_it_says_what_to_install),
      cmocka_unit_test(broken_runtimes_and_lone_gpus_are_named),
      cmocka_unit_test(no_such_device_names_what_there_is),
      cmocka_unit_test(info_counts_what_is_drawn),
      cmocka_unit_test(info_warns_as_render_does),
      cmocka_unit_test(info_lists_animations),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
