// Bad input: one line that names the file, the cause and what to do, the right exit code, and nothing left behind.
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/cli.h"
#include "support/gltf_build.h"

enum { USAGE = 2, INPUT = 4, OUTPUT = 5, NOBODY = 65534 };

// Renders `scene` into out/old.png, which is there already, and expects a failure that leaves it as it is, alone.
static void render_fails(int exit_code, const char *message, const char *scene)
{
  const char *old = cli_path("out/old.png");
  CLI_EXPECT(exit_code, message, "render", scene, "-o", old, "-s", "64x48");
  cli_old_check();
}

static const char *saved(const char *name, const char *text)
{
  const char *path = cli_path("%s", name);
  cli_save(path, text, strlen(text));
  return path;
}

// Permissions stop no root: has the next run take place as nobody. False, and a line, where nobody cannot run it.
static bool as_somebody_else(void)
{
  if (geteuid() != 0) return true;
  cli_setting.user = NOBODY;
  CliRun run = cli_run("--version", NULL);
  bool works = run.exit_code == 0;
  cli_free(&run);
  if (works)
    cli_setting.user = NOBODY;
  else
    fprintf(stderr, "SKIPPED: files without permission: nobody may not run the program here\n");
  return works;
}

static void files_that_are_not_there_or_not_readable(void **state)
{
  render_fails(INPUT, "none.glb: No such file or directory: check the name", cli_path("none.glb"));
  render_fails(INPUT, ": is a folder: name a file", cli_folder);
  render_fails(INPUT, "/dev/null: is not a regular file: name a file", "/dev/null");
  render_fails(INPUT, "scene.glb/x: Not a directory: check the name", cli_path("%s/x", strrchr(cli_scene(), '/') + 1));
  mkfifo(cli_path("pipe.glb"), 0666);
  render_fails(INPUT, "pipe.glb: is not a regular file", cli_path("pipe.glb"));
  CLI_EXPECT(INPUT, "none.glb: No such file", "info", cli_path("none.glb"));
  chmod(saved("secret.glb", "x"), geteuid() == 0 ? 0600 : 0);
  if (!as_somebody_else()) return;
  CLI_EXPECT(INPUT, "secret.glb: Permission denied: check the name and its permissions", "info",
             cli_path("secret.glb"));
}

static void files_that_are_no_gltf(void **state)
{
  render_fails(INPUT, "empty.glb: is empty", saved("empty.glb", ""));
  render_fails(INPUT, "text.gltf: ", saved("text.gltf", "Dear reader,\nthis is a letter.\n"));
  render_fails(INPUT, "list.gltf: ", saved("list.gltf", "[1, 2, 3]"));
  render_fails(INPUT, "old.gltf: ", saved("old.gltf", "{\"asset\":{\"version\":\"1.0\"}}"));
  render_fails(INPUT, "more.gltf: ",
               saved("more.gltf",
                     "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":"
                     "[\"KHR_draco_mesh_compression\"]}"));
  char deep[4001];
  memset(deep, '[', sizeof deep - 1);
  deep[sizeof deep - 1] = 0;
  render_fails(INPUT, "deep.gltf: ", saved("deep.gltf", deep));
}

// Cut at every 37th byte: never a crash, always a message.
static void truncated_files(void **state)
{
  size_t size = 0;
  char *bytes = cli_load(cli_scene(), &size);
  for (size_t length = 1; length < size; length += 37) {
    cli_save(cli_path("cut.glb"), bytes, length);
    CLI_EXPECT(INPUT, "cut.glb: ", "info", cli_path("cut.glb"));
  }
  cli_save(cli_path("cut.glb"), bytes, size / 2);
  render_fails(INPUT, "cut.glb: is a GLB file that was cut off: copy it again", cli_path("cut.glb"));
  free(bytes);
}

static void indices_out_of_range(void **state)
{
  static const uint16_t high[3] = {0, 1, 3};
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  gltf_array(&build, 5123, "SCALAR", high, sizeof high, 3, "");
  render_fails(INPUT, "accessors[1] holds the index 3, the limit is 3: repair the file",
               gltf_save(&build, "%s,'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}]", ONE_NODE));
  render_fails(
      INPUT, "test.glb: ", gltf_save(&build, "%s,'meshes':[{'primitives':[{'attributes':{'POSITION':7}}]}]", ONE_NODE));
  render_fails(INPUT, "test.glb: ", gltf_save(&build, "'scene':0,'scenes':[{'nodes':[9]}],'nodes':[{}]"));
  build = (GltfBuild){0};
  int view = gltf_view(&build, (float[]){TRIANGLE}, 36, 0);
  gltf_accessor(&build, "{'bufferView':%d,'componentType':5126,'type':'VEC3','count':300}", view);
  render_fails(INPUT, "test.glb: accessors[0]",
               gltf_save(&build, "%s,'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]", ONE_NODE));
}

static void nodes_in_a_circle(void **state)
{
  GltfBuild build = {0};
  render_fails(INPUT, "test.glb: ",
               gltf_save(&build, "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'children':[1]},{'children':[0]}]"));
  render_fails(INPUT, "test.glb: ", gltf_save(&build, "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'children':[0]}]"));
}

static void nothing_to_draw(void **state)
{
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  render_fails(INPUT, "test.glb: draws no triangle: there is nothing to render: choose another scene",
               gltf_save(&build, "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{}]"));
  render_fails(INPUT, "test.glb: draws no triangle", gltf_save(&build, "'nodes':[]"));
  CLI_EXPECT(0, "", "info", gltf_save(&build, "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{}]"));
}

// Cameras that make no sense are left out, by name; asking for one is then asking for what is not there.
static void cameras_with_nonsense(void **state)
{
  static const char *const lenses[] = {
      "'type':'perspective','perspective':{'yfov':4,'znear':0.1}",
      "'type':'perspective','perspective':{'yfov':-1,'znear':0.1}",
      "'type':'perspective','perspective':{'yfov':1,'znear':0}",
      "'type':'perspective','perspective':{'yfov':1,'znear':2,'zfar':1}",
      "'type':'orthographic','orthographic':{'xmag':0,'ymag':0,'znear':0.1,'zfar':10}",
  };
  for (size_t i = 0; i < sizeof lenses / sizeof *lenses; i++) {
    GltfBuild build = {0};
    GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
    const char *scene = gltf_save(&build,
                                  "'scene':0,'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0},{'name':'odd','camera':0}],"
                                  "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],'cameras':[{%s}]",
                                  lenses[i]);
    CLI_EXPECT(USAGE, "test.glb: no camera 'odd': did you mean 'fit'?", "render", scene, "-o", cli_path("out/new.png"),
               "--camera", "odd");
    CLI_EXPECT(0, "", "info", scene);
  }
}

static void pictures_of_no_size_or_too_large(void **state)
{
  const char *old = cli_path("out/old.png");
  CLI_EXPECT(USAGE, "--size 0x0: not valid: expected WIDTHxHEIGHT", "render", cli_scene(), "-o", old, "-s", "0x0");
  CLI_EXPECT(USAGE, "--size 1000000x1000000: not valid", "render", cli_scene(), "-o", old, "-s", "1000000x1000000");
  CLI_EXPECT(INPUT, "65536x65536 pixels: need 343.6 GB, with --max-memory at", "render", cli_scene(), "-o", old, "-s",
             "65536x65536");
  CLI_EXPECT(INPUT, "64x48 pixels: need 0.0 GB, with --max-memory at 0.0", "render", cli_scene(), "-o", old, "-s",
             "64x48", "--max-memory", "100k");
  cli_old_check();
}

// Sizes that no map has, and maps that no memory has room for.
static void absurd_shadow_maps(void **state)
{
  static const char *const sizes[] = {"0", "-16", "8196", "1e9", "nan", "17"};
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
    CLI_EXPECT(USAGE, "not valid: expected", "render", cli_scene(), "-o", cli_path("s.png"), "--shadow-map-size",
               sizes[i]);
  CLI_EXPECT(0, "maps of 4 of 4 lights would take over", "render", "scenes/room.glb", "-o", cli_path("s.png"), "-s",
             "64x48", "--overwrite", "--shadows", "hybrid", "--shadow-map-size", "8192", "--threads", "1");
  static const char *const options[] = {"--light-radius", "--light-angle"};
  for (int i = 0; i < 2; i++) {
    CLI_EXPECT(USAGE, "not valid: expected", "render", cli_scene(), "-o", cli_path("s.png"), options[i], "nan");
    CLI_EXPECT(USAGE, "not valid: expected", "render", cli_scene(), "-o", cli_path("s.png"), options[i], "-1");
  }
}

static void memory_limits(void **state)
{
  CLI_EXPECT(INPUT, "scene.glb: the scene needs more memory than allowed: raise --max-memory", "info", cli_scene(),
             "--max-memory", "1k");
#ifdef __SANITIZE_ADDRESS__
  fprintf(stderr, "SKIPPED: a limited address space: the address checks need all of it\n");
#else
  cli_setting.address_space = 300 << 20;
  CLI_EXPECT(INPUT, "GB with OpenCL, where ulimit -v allows 0.31: raise it", "render", cli_scene(), "-o",
             cli_path("out/old.png"), "-s", "64x48");
#endif
}

static void outputs_that_cannot_be_written(void **state)
{
  CLI_EXPECT(OUTPUT, "none/a.png: No such file or directory: make the folder first", "render", cli_scene(), "-o",
             cli_path("none/a.png"));
  CLI_EXPECT(OUTPUT, "scene.glb/a.png: Not a directory: a part of the path is a file, not a folder", "render",
             cli_scene(), "-o", cli_path("scene.glb/a.png"));
  CLI_EXPECT(OUTPUT, "out: Is a directory", "render", cli_scene(), "-o", cli_path("out"), "--format", "png");
  CLI_EXPECT(OUTPUT, "s.json: No such file or directory: make the folder first", "render", cli_scene(), "-o",
             cli_path("a.png"), "--stats", cli_path("none/s.json"));
  CLI_EXPECT(OUTPUT, "t.json: No such file or directory", "render", cli_scene(), "-o", cli_path("a.png"), "--trace",
             cli_path("none/t.json"));
  assert_int_not_equal(access(cli_path("a.png"), F_OK), 0);
  cli_scene();
  mkdir(cli_path("locked"), 0555);
  if (!as_somebody_else()) return;
  CLI_EXPECT(OUTPUT, "locked/a.png: Permission denied", "render", cli_scene(), "-o", cli_path("locked/a.png"));
  assert_string_equal(cli_list(cli_path("locked")), "");
}

static void other_files_that_a_scene_needs(void **state)
{
  CLI_EXPECT(INPUT, "none.hdr: No such file or directory", "render", cli_scene(), "-o", cli_path("out/old.png"),
             "--environment", cli_path("none.hdr"));
  CLI_EXPECT(INPUT, "text.hdr: not a PNG, JPEG, EXR or HDR file: convert it to one", "render", cli_scene(), "-o",
             cli_path("out/old.png"), "--environment", saved("text.hdr", "hello"));
  CLI_EXPECT(
      INPUT, "refers to 'gone.bin': No such file or directory", "info",
      saved("gone.gltf", "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":4,\"uri\":\"gone.bin\"}]}"));
  CLI_EXPECT(INPUT, "outside its folder: move it there or give --allow-outside", "info",
             saved("out.gltf",
                   "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":4,\"uri\":\"../../etc/passwd\"}]}"));
}

// A name in a file must not steer the terminal that shows it.
static void names_with_control_characters(void **state)
{
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  const char *scene =
      gltf_save(&build,
                "'scene':0,'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0},{'camera':0}],"
                "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],"
                "'cameras':[{'name':'\\u001b[2J\\na','type':'perspective','perspective':{'yfov':1,'znear':1}}]");
  CliRun run = cli_run("render", scene, "--list-cameras", NULL);
  assert_int_equal(strncmp(run.out, "0\t?[2J?a\tperspective", 20), 0);
  cli_free(&run);
  run = cli_run("info", scene, NULL);
  assert_null(strchr(run.out, 0x1b));
  cli_free(&run);
  run = cli_run("render", scene, "-o", cli_path("out/old.png"), "--camera", "[2Ja", NULL);
  assert_int_equal(run.exit_code, USAGE);
  assert_non_null(strstr(run.err, "did you mean '?[2J"));
  assert_null(strchr(run.err, 0x1b));
  cli_free(&run);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(files_that_are_not_there_or_not_readable),
      cmocka_unit_test(files_that_are_no_gltf),
      cmocka_unit_test(truncated_files),
      cmocka_unit_test(indices_out_of_range),
      cmocka_unit_test(nodes_in_a_circle),
      cmocka_unit_test(nothing_to_draw),
      cmocka_unit_test(cameras_with_nonsense),
      cmocka_unit_test(pictures_of_no_size_or_too_large),
      cmocka_unit_test(absurd_shadow_maps),
      cmocka_unit_test(memory_limits),
      cmocka_unit_test(outputs_that_cannot_be_written),
      cmocka_unit_test(other_files_that_a_scene_needs),
      cmocka_unit_test(names_with_control_characters),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
