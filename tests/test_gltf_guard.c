// glTF import: what is wrong is refused, by name and with a hint; what is hostile breaks nothing.
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "support/gltf_build.h"

#define ASSET "'asset':{'version':'2.0'}"

// ---- files ---------------------------------------------------------------------------------------------------------

static void files_that_are_not_there(void **state)
{
  char path[256];
  snprintf(path, sizeof path, "%s/none.glb", gltf_folder);
  gltf_read_fails(path, STATUS_NOT_FOUND, "none.glb: No such file or directory: ");
  gltf_read_fails(gltf_folder, STATUS_NOT_FOUND, ": is a folder: ");
  gltf_read_fails("/dev/null", STATUS_NOT_FOUND, "/dev/null: is not a regular file: ");
  gltf_read_fails(gltf_save_bytes("empty.glb", "", 0), STATUS_BAD_SCENE, "empty.glb: is empty: ");
  snprintf(path, sizeof path, "%s/pipe.glb", gltf_folder);
  assert_int_equal(mkfifo(path, 0600), 0);
  gltf_read_fails(path, STATUS_NOT_FOUND, "pipe.glb: is not a regular file: ");
}

static void text_that_is_not_gltf(void **state)
{
  gltf_read_fails(gltf_save_text("hello"), STATUS_BAD_SCENE, "test.gltf: is not glTF: ");
  gltf_read_fails(gltf_save_text("  \n"), STATUS_BAD_SCENE, "is not glTF");
  gltf_read_fails(gltf_save_text("[1]"), STATUS_BAD_SCENE, "is not glTF");
  gltf_read_fails(gltf_save_text("{'asset':"), STATUS_BAD_SCENE, "is not valid JSON (line 1, column 9: ");
  gltf_read_fails(gltf_save_text("{'scenes':[]}"), STATUS_BAD_SCENE, "is JSON, but not glTF (no asset.version)");
  gltf_read_fails(gltf_save_text("{'asset':{'version':'1.0'}}"), STATUS_UNSUPPORTED, "is glTF 1.0: convert");
  gltf_read_fails(gltf_save_text("{'asset':{'version':'2.0','minVersion':'2.1'}}"), STATUS_UNSUPPORTED, "is glTF 2.1");
  gltf_read_fails(gltf_save_bytes("bad.gltf", "{\"asset\":{\"version\":\"2.0\xff\"}}", 29), STATUS_BAD_SCENE,
                  "not valid JSON");
}

static size_t file_load(uint8_t **bytes, const char *path)
{
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  *bytes = malloc(1 << 17);
  size_t size = fread(*bytes, 1, 1 << 17, file);
  fclose(file);
  return size;
}

// A file that uses most of what is read.
static size_t rich_file(uint8_t **bytes)
{
  const uint8_t joints[12] = {0}, indices[] = {0, 1, 2}, sparse_index[] = {1};
  const float weights[] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0},
              bind[] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  gltf_array(&build, 5121, "SCALAR", indices, sizeof indices, 3, "");
  gltf_array(&build, 5121, "VEC4", joints, sizeof joints, 3, "");
  gltf_array(&build, 5126, "VEC4", weights, sizeof weights, 3, "");
  gltf_array(&build, 5126, "MAT4", bind, sizeof bind, 1, "");
  int at = gltf_view(&build, sparse_index, sizeof sparse_index, 0), to = gltf_view(&build, bind, 12, 0);
  gltf_accessor(&build,
                "{'componentType':5126,'type':'VEC3','count':3,'sparse':{'count':1,'indices':{'bufferView':%d,"
                "'componentType':5121},'values':{'bufferView':%d}}}",
                at, to);
  GLTF_FLOATS(&build, "SCALAR", 2, 0, 1);
  GLTF_FLOATS(&build, "VEC3", 2, 1, 1, 1, 2, 2, 2);
  const char *path = gltf_save(
      &build,
      "'extensionsUsed':['KHR_lights_punctual','EXT_mesh_gpu_instancing','KHR_texture_transform'],'extensions':{"
      "'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{}}]}},'scene':0,'scenes':[{'nodes':[0,1]}],'nodes':["
      "{'mesh':0,'skin':0,'children':[2]},{'camera':0,'extensions':{'KHR_lights_punctual':{'light':0}}},{'mesh':1,"
      "'weights':[1],'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':0}}}}],'cameras':[{'type':"
      "'perspective','perspective':{'yfov':1,'znear':1}}],'skins':[{'joints':[1],'inverseBindMatrices':4}],'meshes':["
      "{'primitives':[{'indices':1,'attributes':{'POSITION':0,'JOINTS_0':2,'WEIGHTS_0':3},'material':0}]},{'primitives'"
      ":["
      "{'attributes':{'POSITION':0,'NORMAL':5,'COLOR_0':0},'targets':[{'POSITION':5}]}]}],'materials':[{"
      "'emissiveFactor':[1,1,1],'alphaMode':'BLEND'}],'animations':[{'channels':[{'sampler':0,'target':{'node':1,"
      "'path':'scale'}},{'sampler':1,'target':{'node':2,'path':'weights'}}],'samplers':[{'input':6,'output':7},{"
      "'input':6,'output':6}]}],'extras':[{}]");
  return file_load(bytes, path);
}

static void cut_off_files(void **state)
{
  uint8_t *bytes;
  size_t size = rich_file(&bytes);
  for (size_t length = 1; length < size; length += length < 64 ? 1 : 13) {
    gltf_read_fails(gltf_save_bytes("cut.glb", bytes, length), STATUS_BAD_SCENE,
                    length < 4 ? "is not glTF" : "cut off");
  }
  bytes[4] = 1;
  gltf_read_fails(gltf_save_bytes("old.glb", bytes, size), STATUS_UNSUPPORTED, "is a GLB file of version 1");
  bytes[4] = 2;
  uint8_t length = bytes[14];
  bytes[14] = 0xff;
  gltf_read_fails(gltf_save_bytes("long.glb", bytes, size), STATUS_BAD_SCENE, "chunk 0 was cut off");
  bytes[14] = length;
  bytes[16] = 'X';
  gltf_read_fails(gltf_save_bytes("none.glb", bytes, size), STATUS_BAD_SCENE, "without a JSON chunk");
  free(bytes);
}

// Any status will do; the sanitizers and the return itself are the test.
static void damaged_files_break_nothing(void **state)
{
  uint8_t *bytes;
  size_t size = rich_file(&bytes);
  uint32_t seed = 1, fine = 0;
  Log silent;
  for (int round = 0; round < 4000; round++) {
    uint8_t kept[4];
    size_t places[4];
    for (int i = 0; i < 4; i++) {
      places[i] = (seed = seed * 1664525u + 1013904223u) % size;
      kept[i] = bytes[places[i]];
      bytes[places[i]] = round % 2 ? (uint8_t)("0123456789-.,:[]{}\"e"[seed >> 24 & 15]) : (uint8_t)(seed >> 24);
      if (i >= 1 + round % 4) bytes[places[i]] = kept[i];
    }
    Scene scene = {0};
    GltfOptions options = {.scene = NONE, .max_memory_bytes = 1 << 26};
    silent = (Log){0};
    const char *path = gltf_save_bytes("damaged.glb", bytes, size);
    GltfMotion *motion = NULL;
    Status status = round & 2 ? gltf_motion_open(&motion, &scene, path, &options, NULL, NULL, &silent)
                              : gltf_read(&scene, path, &options, NULL, &silent);
    if (motion) gltf_motion_pose(motion, &scene, 0.5, &silent);
    gltf_motion_close(motion);
    fine += status == STATUS_OK;
    scene_free(&scene);
    for (int i = 3; i >= 0; i--) bytes[places[i]] = kept[i];
  }
  assert_true(fine > 100 && fine < 3900);
  free(bytes);
}

static void hostile_nesting(void **state)
{
  enum { DEPTH = 100000 };
  const char head[] = "{\"asset\":{\"version\":\"2.0\"},\"extras\":";
  char *text = malloc(8 * DEPTH);
  for (int kind = 0; kind < 2; kind++) {
    size_t length = (size_t)sprintf(text, "%s", head);
    for (int i = 0; i < DEPTH; i++) length += (size_t)sprintf(text + length, kind ? "[" : "{\"\\\"\":");
    gltf_read_fails(gltf_save_bytes("deep.gltf", text, length), STATUS_BAD_SCENE, "nested deeper than 128 levels");
  }
  free(text);
}

static void nesting_within_the_limit_is_read(void **state)
{
  char text[1024] = "{\"asset\":{\"version\":\"2.0\"},\"extras\":";
  for (int i = 0; i < 127; i++) strcat(text, "[");
  strcat(text, "\"[[[[\\\"{{{{\"");
  for (int i = 0; i < 127; i++) strcat(text, "]");
  strcat(text, "}");
  Scene scene = gltf_read_fine(gltf_save_bytes("nested.gltf", text, strlen(text)));
  scene_free(&scene);
}

// ---- what the JSON says --------------------------------------------------------------------------------------------

static void json_that_breaks_the_rules(void **state)
{
  const struct {
    const char *json, *message;
  } cases[] = {
      {"'nodes':{}", "nodes is not an array"},
      {"'nodes':[7]", "nodes[0] is not an object"},
      {"'nodes':[{'mesh':0}]", "nodes[0].mesh is 0, but the file has 0 meshes"},
      {"'nodes':[{'mesh':-1}],'meshes':[{}]", "nodes[0].mesh is -1, but the file has 1 meshes"},
      {"'nodes':[{'mesh':0.5}],'meshes':[{}]", "nodes[0].mesh is not an index"},
      {"'nodes':[{'mesh':'0'}],'meshes':[{}]", "nodes[0].mesh is not an index"},
      {"'nodes':[{'skin':3}]", "nodes[0].skin is 3"},
      {"'nodes':[{'camera':3}]", "nodes[0].camera is 3"},
      {"'nodes':[{'extensions':{'KHR_lights_punctual':{'light':1}}}]", "light is 1, but the file has 0 lights"},
      {"'nodes':[{'extensions':{'KHR_lights_punctual':{}}}]", "KHR_lights_punctual.light is missing"},
      {"'nodes':[{'matrix':[1,2,3]}]", "nodes[0].matrix is not an array of 16 numbers"},
      {"'nodes':[{'rotation':[1,2,3,'4']}]", "nodes[0].rotation is not an array of 4 numbers"},
      {"'nodes':[{'name':5}]", "nodes[0].name is not a string"},
      {"'scene':1,'scenes':[{}]", "scene is 1, but the file has 1 scenes"},
      {"'scenes':[{'nodes':[4]}]", "scenes[0].nodes[0] is 4, but the file has 0 nodes"},
      {"'meshes':[{'primitives':[{}]}]", "meshes[0].primitives[0].attributes is missing"},
      {"'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]",
       "attributes.POSITION is 0, but the file has 0 accessors"},
      {"'meshes':[{'primitives':[{'attributes':{},'material':9}]}]", "primitives[0].material is 9"},
      {"'meshes':[{'primitives':[{'attributes':{},'indices':9}]}]", "primitives[0].indices is 9"},
      {"'meshes':[{'primitives':[{'attributes':{},'targets':[{'POSITION':1}]}]}]", "targets[0].POSITION is 1"},
      {"'textures':[{'source':0}]", "textures[0].source is 0, but the file has 0 images"},
      {"'textures':[{'sampler':0}]", "textures[0].sampler is 0, but the file has 0 samplers"},
      {"'materials':[{'normalTexture':{}}]", "materials[0].normalTexture.index is missing"},
      {"'materials':[{'emissiveTexture':{'index':2}}]", "emissiveTexture.index is 2, but the file has 0 textures"},
      {"'materials':[{'alphaMode':'MIST'}]", "alphaMode is 'MIST', not one of: OPAQUE MASK BLEND"},
      {"'cameras':[{'type':'fisheye'}]", "cameras[0].type is 'fisheye'"},
      {"'cameras':[{'type':'perspective','perspective':{'yfov':1}}]", "cameras[0].perspective.znear is missing"},
      {"'cameras':[{'type':'perspective'}]", "Perspective camera description not found"},
      {"'extensions':{'KHR_lights_punctual':{'lights':[{'type':'area'}]}}", "lights[0].type is 'area'"},
      {"'skins':[{'joints':[0]}]", "skins[0].joints[0] is 0, but the file has 0 nodes"},
      {"'animations':[{'samplers':[{'input':0}]}]",
       "animations[0].samplers[0].input is 0, but the file has 0 accessors"},
      {"'animations':[{'samplers':[{}]}]", "animations[0].samplers[0].input is missing"},
      {"'animations':[{'channels':[{'sampler':0,'target':{'path':'scale'}}]}]",
       "animations[0].channels[0].sampler is 0, but the animation has 0 samplers"},
      {"'animations':[{'channels':[{'target':{'path':'scale'}}]}]", "animations[0].channels[0].sampler is missing"},
      {"'animations':[{'channels':[{'sampler':0}]}]", "animations[0].channels[0].target is missing"},
      {"'animations':[{'channels':[{'sampler':0,'target':{}}]}]", "animations[0].channels[0].target.path is missing"},
      {"'animations':[{'channels':[{'sampler':0,'target':{'node':2,'path':'scale'}}]}]",
       "target.node is 2, but the file"},
      {"'animations':[{'name':3}]", "animations[0].name is not a string"},
      {"'buffers':[{}]", "buffers[0].byteLength is missing"},
      {"'bufferViews':[{'buffer':0,'byteLength':1}]", "bufferViews[0].buffer is 0, but the file has 0 buffers"},
      {"'accessors':[{'componentType':5126,'count':1,'type':'VEC9'}]", "accessors[0].type is 'VEC9'"},
      {"'accessors':[{'componentType':5126,'count':1,'type':'VEC2'}],'animations':[{'samplers':[{'input':0,'output':1}]"
       "}]",
       "animations[0].samplers[0].output is 1, but the file has 1 accessors"},
      {"'accessors':[{'componentType':5126,'count':1,'type':'VEC2'}],'animations':[{'samplers':[{'input':0,'output':0,"
       "'interpolation':'WAVE'}]}]",
       "interpolation is 'WAVE', not one of: LINEAR STEP CUBICSPLINE"},
      {"'accessors':[{'componentType':5130,'count':1,'type':'VEC2'}]", "accessors[0] has component type 5130"},
      {"'accessors':[{'componentType':5126,'count':0,'type':'VEC2'}]", "accessors[0] has a count of 0"},
      {"'accessors':[{'componentType':5126,'count':18446744073709551616,'type':'VEC2'}]", "not valid JSON"},
      {"'nodes':[{'children':[1]},{'children':[0]}]", "is its own ancestor"},
      {"'nodes':[{'children':[0]}]", "nodes[0] is its own ancestor"},
      {"'nodes':[{'children':[2]},{'children':[2]},{}]", "nodes[2] is a child twice, of nodes[0] and nodes[1]"},
      {"'nodes':[{'children':[1,1]},{}]", "nodes[1] is a child twice"},
      {"'nodes':[{'children':[1]},{}],'scenes':[{'nodes':[1]}]",
       "scenes[0].nodes[0] is a child of nodes[0], not a root"},
      {"'nodes':[{}],'scenes':[{'nodes':[0,0]}]", "scenes[0] lists nodes[0] twice"},
      {"'nodes':[{'scale':[1e200,1,1],'children':[1]},{'scale':[1e200,1,1]}]", "a transform that is not finite"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    gltf_read_fails(gltf_save_text("{" ASSET ",%s}", cases[i].json), STATUS_BAD_SCENE, cases[i].message);
}

static void required_extensions_that_are_unknown(void **state)
{
  gltf_read_fails(
      gltf_save_text("{" ASSET ",'extensionsRequired':['KHR_mesh_quantization','KHR_draco_mesh_compression']}"),
      STATUS_UNSUPPORTED, "requires the extension KHR_draco_mesh_compression: ");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(files_that_are_not_there),
      cmocka_unit_test(text_that_is_not_gltf),
      cmocka_unit_test(cut_off_files),
      cmocka_unit_test(damaged_files_break_nothing),
      cmocka_unit_test(hostile_nesting),
      cmocka_unit_test(nesting_within_the_limit_is_read),
      cmocka_unit_test(json_that_breaks_the_rules),
      cmocka_unit_test(required_extensions_that_are_unknown),
  };
  return cmocka_run_group_tests(tests, gltf_tests_begin, gltf_tests_end);
}
