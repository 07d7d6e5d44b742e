// Scene files: what is read of them, what is refused, and how that is said.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>
#include <jansson.h>

#include "app/options.h"
#include "scene/gltf.h"
#include "support/cli.h"
#include "support/gltf_build.h"

static Log test_log;

// Saves `text`, in which ' stands for ", as scene.json beside scene.glb.
static const char *saved(const char *text)
{
  char quoted[4096];
  snprintf(quoted, sizeof quoted, "%s", text);
  for (char *c = quoted; *c; c++)
    if (*c == '\'') *c = '"';
  const char *path = cli_path("scene.json");
  cli_scene();
  cli_save(path, quoted, strlen(quoted));
  return path;
}

// Parses `frugal render scene.json -o out.exr WORDS`.
static Status parse(RenderOptions *out, const char *path, const char *words)
{
  char text[256];
  char *arguments[16] = {"render", (char *)path, "-o", "out.exr"};
  int count = 4;
  snprintf(text, sizeof text, "%s", words);
  for (char *rest = NULL, *word = strtok_r(text, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
    arguments[count++] = word;
  test_log = (Log){0};
  return render_options_parse(out, count, arguments, &test_log);
}

// The caller frees the options.
static RenderOptions parsed(const char *json, const char *words)
{
  RenderOptions options;
  Status status = parse(&options, saved(json), words);
  if (status) fail_msg("%s %s: %s", json, words, test_log.error);
  return options;
}

static void refused(const char *json, Status expected, const char *message)
{
  RenderOptions options;
  Status status = parse(&options, saved(json), "");
  if (status != expected || strncmp(test_log.error, cli_folder, strlen(cli_folder)) != 0 ||
      !strstr(test_log.error, message))
    fail_msg("%s gives %d, %s; expected %d: %s", json, (int)status, test_log.error, (int)expected, message);
  render_options_free(&options);
}

static void keys_are_options_and_the_command_line_wins(void **state)
{
  const char *json =
      "{'$schema':'../scene.schema.json','scene':'scene.glb','size':[320,180],'samples':4,'lighting':'phong',"
      "'no-key-light':true,'exposure':-1.5,'aov':['depth','normal'],'light-angle':90e-1,'camera':1,'crop':'0,0,8,4',"
      "'environment':'#ffffff','seed':4294967295}";
  RenderOptions o = parsed(json, "");
  assert_int_equal(o.settings.width, 320);
  assert_int_equal(o.settings.height, 180);
  assert_int_equal(o.settings.samples, 4);
  assert_int_equal(o.settings.lighting, LIGHTING_PHONG);
  assert_false(o.key_light);
  assert_true(o.exposure.ev == -1.5f);
  assert_int_equal(o.picture.aovs, 5);
  assert_true(fabs(o.settings.shadow_options.light_angle_rad - M_PI / 20) < 1e-12);
  assert_string_equal(o.camera, "1");
  assert_int_equal(o.crop.height, 4);
  assert_true(o.environment.choice == ENVIRONMENT_COLOR && o.environment.color[0] == 1);
  assert_int_equal(o.seed, UINT32_MAX);
  assert_true(!strcmp(strrchr(o.gltf_path, '/'), "/scene.glb") && !strcmp(strrchr(o.scene_path, '/'), "/scene.json"));
  render_options_free(&o);

  o = parsed(json, "--size 64x48 --lighting pbr --camera front --exposure auto");
  assert_int_equal(o.settings.width, 64);
  assert_int_equal(o.settings.samples, 4);
  assert_int_equal(o.settings.lighting, LIGHTING_PBR);
  assert_string_equal(o.camera, "front");
  assert_true(o.exposure.is_auto);
  render_options_free(&o);

  o = parsed("{'scene':'scene.glb','no-key-light':false,'exposure':'auto'}", "");
  assert_true(o.key_light && o.exposure.is_auto);
  render_options_free(&o);
  json = "{'scene':'scene.glb','light-shadows':{'lamp, left':'pcf','#2':'none'}}";
  o = parsed(json, "");
  assert_string_equal(o.light_shadows, "lamp, left=pcf,#2=none");
  render_options_free(&o);
  o = parsed(json, "--light-shadows lamp=map");
  assert_string_equal(o.light_shadows, "lamp=map");
  render_options_free(&o);
  o = parsed("\xef\xbb\xbf{'scene':'./scene.glb'}", "");
  assert_int_equal(o.settings.width, 1280);
  render_options_free(&o);
}

static void mistakes_are_named(void **state)
{
  refused("{'scene':'scene.glb','samlpes':4}", STATUS_BAD_SCENE, "samlpes: no such key: did you mean 'samples'?");
  refused("{'scene':'scene.glb','node':{}}", STATUS_BAD_SCENE, "node: no such key: did you mean 'nodes'?");
  refused("{'scene':'scene.glb','':1}", STATUS_BAD_SCENE, ": no such key");
  refused("{'scene':'scene.glb','output':'a.png'}", STATUS_BAD_SCENE,
          "output: says how to run, not what to show: give --output on the command line");
  refused("{'scene':'scene.glb','help':true}", STATUS_BAD_SCENE, "help: says how to run");
  refused("{'scene':'scene.glb','allow-outside':true}", STATUS_BAD_SCENE, "allow-outside: says how to run");
  refused("{'scene':'scene.glb','samples':'4'}", STATUS_BAD_SCENE, "samples \"4\": not valid: expected a number");
  refused("{'scene':'scene.glb','samples':null}", STATUS_BAD_SCENE, "samples null: not valid: expected a number");
  refused("{'scene':'scene.glb','samples':1.5}", STATUS_BAD_SCENE, "samples 1.5: not valid: expected a whole number");
  refused("{'scene':'scene.glb','samples':0}", STATUS_BAD_SCENE,
          "samples 0: not valid: expected a whole number from 1 to 1048576");
  refused("{'scene':'scene.glb','no-key-light':1}", STATUS_BAD_SCENE,
          "no-key-light 1: not valid: expected true or false");
  refused("{'scene':'scene.glb','size':[64]}", STATUS_BAD_SCENE, "size 64: not valid: expected WIDTHxHEIGHT");
  refused("{'scene':'scene.glb','size':['64',48]}", STATUS_BAD_SCENE,
          "size [\"64\",48]: not valid: expected a text or a list of numbers");
  refused("{'scene':'scene.glb','size':[[64,48]]}", STATUS_BAD_SCENE,
          "not valid: expected a text or a list of numbers");
  refused("{'scene':'scene.glb','aov':['depth,normal']}", STATUS_BAD_SCENE, "expected a text or a list of texts");
  refused("{'scene':'scene.glb','aov':['depht']}", STATUS_BAD_SCENE, "aov depht: no such value: did you mean 'depth'?");
  refused("{'scene':'scene.glb','lighting':'fong'}", STATUS_BAD_SCENE,
          "lighting fong: no such value: did you mean 'phong'?");
  refused("{'scene':'scene.glb','camera':''}", STATUS_BAD_SCENE, "camera : not valid: expected a name");
  refused("{'scene':'scene.glb','light-shadows':{}}", STATUS_BAD_SCENE,
          "light-shadows : not valid: expected NAME=METHOD");
  refused("{'scene':'scene.glb','light-shadows':{'lamp':'soft'}}", STATUS_BAD_SCENE,
          "light-shadows soft: no such value: did you mean ");
  refused("{'scene':'scene.glb','light-shadows':{'lamp':1}}", STATUS_BAD_SCENE,
          "light-shadows {\"lamp\":1}: not valid: expected a text or an object of texts by name");
  refused("{'scene':'scene.glb','light-shadows':{'a=map':'pcf'}}", STATUS_BAD_SCENE, "an object of texts by name");
  refused("{'scene':'scene.glb','light-shadows':{'':'pcf'}}", STATUS_BAD_SCENE, "an object of texts by name");
  refused("{'scene':'scene.glb','light-shadows':{'lamp':'pcf,#2=map'}}", STATUS_BAD_SCENE,
          "an object of texts by name");
  refused("{'scene':'scene.glb','light-shadows':'lamp'}", STATUS_BAD_SCENE, "light-shadows lamp: not valid: expected");
  refused("{'scene':'scene.glb','samples':{'a':'b'}}", STATUS_BAD_SCENE, "samples {\"a\":\"b\"}: not valid: expected");
}

static void files_that_are_none(void **state)
{
  refused("", STATUS_BAD_SCENE, "scene.json: is not a scene file");
  refused(" \n", STATUS_BAD_SCENE, "is not a scene file");
  refused("[]", STATUS_BAD_SCENE, "is not a scene file");
  refused("{'scene':'scene.glb',\n 'samples':}", STATUS_BAD_SCENE,
          "is not valid JSON (line 2, column 12: unexpected token near '}'");
  refused("{'scene':'scene.glb','samples':1,\n'samples':2}", STATUS_BAD_SCENE,
          "(line 2, column 9: duplicate object key near '\"samples\"')");
  refused("{'scene':'scene.glb','camera':'\xff'}", STATUS_BAD_SCENE, "(line 1, column 31: unable to decode byte 0xff");
  refused("{'scene':'scene.glb','camera':'\\u0000'}", STATUS_BAD_SCENE, "is not valid JSON");
  refused("{'scene':'scene.glb','samples':1e999}", STATUS_BAD_SCENE, "is not valid JSON");
  refused("{}", STATUS_BAD_SCENE, "names no scene: add \"scene\"");
  refused("{'scene':7}", STATUS_BAD_SCENE, "names no scene");
  refused("{'scene':''}", STATUS_BAD_SCENE, "names no scene");
  refused("{'asset':{'version':'2.0'}}", STATUS_BAD_SCENE, "is glTF, and no scene file: end its name in .gltf");

  char deep[3000] = "{'scene':'scene.glb','aov':";
  memset(deep + strlen(deep), '[', 1000);
  refused(deep, STATUS_BAD_SCENE, "JSON nested deeper than 128 levels");

  const char *path = saved("{}");
  RenderOptions options;
  assert_int_equal(truncate(path, 20 << 20), 0);
  assert_int_equal(parse(&options, path, ""), STATUS_TOO_LARGE);
  assert_non_null(strstr(test_log.error, "scene.json: is 21.0 MB long, where a scene file has at most 16"));
  assert_int_equal(parse(&options, cli_path("none.json"), ""), STATUS_NOT_FOUND);
  mkdir(cli_path("folder.json"), 0777);
  assert_int_equal(parse(&options, cli_path("folder.json"), ""), STATUS_NOT_FOUND);
}

static void what_it_names_lies_in_its_folder(void **state)
{
  refused("{'scene':'none.glb'}", STATUS_NOT_FOUND, "scene.json: refers to 'none.glb': No such file or directory");
  refused("{'scene':'../scene.glb'}", STATUS_BAD_SCENE, "outside its folder: move it there or give --allow-outside");
  refused("{'scene':'/etc/passwd'}", STATUS_BAD_SCENE, "outside its folder");
  refused("{'scene':'scene.glb','environment':'../sky.hdr'}", STATUS_BAD_SCENE, "outside its folder");
  refused("{'scene':'scene.glb','environment':'none.hdr'}", STATUS_NOT_FOUND, "refers to 'none.hdr'");
  assert_int_equal(symlink("/etc/passwd", cli_path("link.glb")), 0);
  refused("{'scene':'link.glb'}", STATUS_BAD_SCENE, "'link.glb' is a link that leaves its folder");

  mkdir(cli_path("within"), 0777);
  cli_save(cli_path("within/sky.hdr"), "", 0);
  RenderOptions o = parsed("{'scene':'scene.glb','environment':'within/sky.hdr'}", "");
  assert_true(o.environment.choice == ENVIRONMENT_FILE && o.environment.text[0] == '/' &&
              !strcmp(strrchr(o.environment.text, '/'), "/sky.hdr"));
  render_options_free(&o);
  char json[512];
  snprintf(json, sizeof json, "{'scene':'../%s/scene.glb'}", strrchr(cli_folder, '/') + 1);
  o = parsed(json, "--allow-outside");
  render_options_free(&o);
}

static void nodes_are_found_by_name(void **state)
{
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0);
  const char *gltf = gltf_save(&build,
                               "'scene':0,'scenes':[{'nodes':[0,1,2,3]}],'meshes':[{'name':'sheet','primitives':"
                               "[{'attributes':{'POSITION':0}}]}],'nodes':[{'name':'leaf','mesh':0},{'mesh':0},"
                               "{'name':'leaf','mesh':0,'children':[4]},{'name':'empty'},{'name':'twig','mesh':0}]");
  assert_int_equal(rename(gltf, cli_path("leaves.glb")), 0);
  SceneFile file = {0};
  test_log = (Log){0};
  assert_int_equal(scene_file_read(&file,
                                   saved("{'scene':'leaves.glb','nodes':{'leaf':{'casts_shadow':false},'twig':{},"
                                         "'sheet':{'casts_shadow':true}}}"),
                                   false, &test_log),
                   STATUS_OK);
  gltf_options.changes = &file;
  Scene scene = gltf_read_fine(file.scene_path);
  assert_int_equal(scene.object_count, 4);
  for (uint32_t i = 0; i < 4; i++)
    assert_int_equal(scene.objects[i].shadowless, !strcmp(scene.objects[i].name, "leaf"));
  scene_free(&scene);
  scene_file_free(&file);

  static const char *const wrong[][2] = {
      {"'leef':{'casts_shadow':false}", "nodes: none that draws is named 'leef': did you mean 'leaf'?"},
      {"'empty':{'casts_shadow':false}", "nodes: none that draws is named 'empty'"},
      {"'leaf':{'cast_shadow':false}", "nodes: 'leaf': cast_shadow: no such key: did you mean 'casts_shadow'?"},
      {"'leaf':{'casts_shadow':0}", "nodes: 'leaf': casts_shadow: not valid: expected true or false"},
      {"'leaf':false", "nodes: 'leaf': not valid: expected {\"casts_shadow\": false}"},
  };
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
    char json[256];
    snprintf(json, sizeof json, "{'scene':'leaves.glb','nodes':{%s}}", wrong[i][0]);
    CLI_EXPECT(4, wrong[i][1], "render", saved(json), "-o", cli_path("out/no.png"));
    CLI_EXPECT(4, wrong[i][1], "info", saved(json));
  }
  CLI_EXPECT(4, "nodes: not valid: expected an object of nodes by name", "info",
             saved("{'scene':'leaves.glb','nodes':['leaf']}"));
}

// A picture by a scene file is the one by the same options.
static void the_program_renders_one(void **state)
{
  size_t size = 0;
  const char *json = "{'scene':'scene.glb','size':'64x48','samples':2,'camera':'flat'}", *path = saved(json);
  CLI_EXPECT(0, "", "render", path, "-o", cli_path("by_file.exr"));
  CLI_EXPECT(0, "", "render", cli_scene(), "-o", cli_path("by_words.exr"), "-s", "64x48", "-n", "2", "--camera",
             "flat");
  CLI_EXPECT(0, "", "compare", cli_path("by_words.exr"), cli_path("by_file.exr"), "--fail-over", "max=0");
  char *bytes = cli_load(cli_path("by_file.exr"), &size);
  bool is_named = memmem(bytes, size, "frugal render scene.json", 24) != NULL;
  free(bytes);
  assert_true(is_named);
  path = saved("{'scene':'scene.glb','size':'64x48','light-shadows':{'lamp':'none'}}");
  CLI_EXPECT(0, "", "render", path, "-o", cli_path("light.exr"), "--stats", cli_path("light.json"));
  json_t *stats = json_load_file(cli_path("light.json"), 0, NULL),
         *light = json_array_get(json_object_get(stats, "lights"), 0);
  assert_string_equal(json_string_value(json_object_get(light, "name")), "lamp");
  assert_string_equal(json_string_value(json_object_get(light, "shadows")), "none");
  assert_non_null(strstr(json_string_value(json_object_get(stats, "settings")), " --light-shadows lamp=none "));
  json_decref(stats);
  CLI_EXPECT(2, "--light-shadows: no light is called 'sun': lights are: #1 'lamp'", "render", cli_scene(), "-o",
             cli_path("out/no.png"), "--light-shadows", "sun=pcf");
  cli_old_check();
  path = saved(json);
  CLI_EXPECT(0, "", "render", path, "--list-cameras");
  CLI_EXPECT(0, "", "info", path);
  CLI_EXPECT(4, "scene.json: siez: no such key: did you mean 'size'?", "info",
             saved("{'scene':'scene.glb','siez':'64x48'}"));
  CLI_EXPECT(2, "no camera 'none'", "render", saved("{'scene':'scene.glb','camera':'none'}"), "-o", cli_path("n.png"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(keys_are_options_and_the_command_line_wins),
      cmocka_unit_test(mistakes_are_named),
      cmocka_unit_test(files_that_are_none),
      cmocka_unit_test(what_it_names_lies_in_its_folder),
      cmocka_unit_test(nodes_are_found_by_name),
      cmocka_unit_test(the_program_renders_one),
  };
  return cmocka_run_group_tests(tests, cli_set_up, cli_tear_down);
}
