// glTF import: arrays stay within their views, views within their buffers, buffers within the file's folder, and all
// of it within the memory allowed.
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "support/gltf_build.h"

#define ASSET "'asset':{'version':'2.0'}"
#define ONE_MESH "'meshes':[{'name':'leg','primitives':[{'attributes':{'POSITION':0}}]}]"

// ---- bounds --------------------------------------------------------------------------------------------------------

static void views_and_accessors_stay_in_bounds(void **state)
{
  const struct {
    const char *view, *accessor, *message;
  } cases[] = {
      {"'byteLength':37", "'count':3", "bufferViews[0] leaves its buffer of 36 bytes"},
      {"'byteLength':36,'byteOffset':4", "'count':3", "bufferViews[0] leaves its buffer"},
      {"'byteLength':9007199254740992,'byteOffset':9007199254740992", "'count':3", "bufferViews[0] leaves its buffer"},
      {"'byteLength':36,'byteStride':2", "'count':3", "bufferViews[0].byteStride is 2, not 4 to 252"},
      {"'byteLength':36", "'count':4", "accessors[0] with 4 elements leaves its view"},
      {"'byteLength':36", "'count':3,'byteOffset':1", "accessors[0] with 3 elements leaves its view"},
      {"'byteLength':36,'byteStride':16", "'count':3", "accessors[0] with 3 elements leaves its view"},
      {"'byteLength':36", "'count':2147483647,'byteOffset':9007199254740992", "leaves its view"},
      {"'byteLength':36", "'count':9007199254740992", "accessors[0] has a count of 9007199254740992"},
      {"'byteLength':36",
       "'count':3,'sparse':{'count':4,'indices':{'bufferView':0,'componentType':5121},'values':{'bufferView':0}}",
       "accessors[0].sparse with 4 elements is out of bounds"},
      {"'byteLength':36",
       "'count':3,'sparse':{'count':3,'indices':{'bufferView':0,'componentType':5125,'byteOffset':28},'values':{"
       "'bufferView':0}}",
       "accessors[0].sparse with 3 elements is out of bounds"},
      {"'byteLength':36",
       "'count':3,'sparse':{'count':1,'indices':{'bufferView':0,'componentType':5126},'values':{'bufferView':0}}",
       "accessors[0].sparse.indices has component type 5126"},
      {"'byteLength':36",
       "'count':3,'sparse':{'count':1,'indices':{'bufferView':0,'byteOffset':14,'componentType':5121},'values':{"
       "'bufferView':0}}",
       "accessors[0].sparse replaces element 128 of 3"},
  };
  GltfBuild bytes = {0};
  gltf_view(&bytes, (const float[]){TRIANGLE}, 36, 0);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    GltfBuild build = bytes;
    snprintf(build.views, sizeof build.views, "{'buffer':0,%s}", cases[i].view);
    gltf_accessor(&build, "{'bufferView':0,'componentType':5126,'type':'VEC3',%s}", cases[i].accessor);
    gltf_read_fails(gltf_save(&build, ONE_NODE "," ONE_MESH), STATUS_BAD_SCENE, cases[i].message);
  }
}

static void attributes_that_do_not_fit(void **state)
{
  const uint8_t far[] = {0, 1, 3};
  const float holes[] = {0, 0, 0, 1, 0, 0, 0, 0.0f / 0.0f, 0}, ends[] = {0, 0, 0, 1, 0, 0, 0, 1, 1.0f / 0.0f};
  const struct {
    const char *primitive, *message;
  } cases[] = {
      {"'attributes':{'POSITION':1}", "meshes[0] '' primitives[0]: accessors[1] has 2 components, not 3"},
      {"'attributes':{'POSITION':0,'NORMAL':2}", "accessors[2] has 2 elements, not 3"},
      {"'attributes':{'POSITION':0},'indices':3", "accessors[3] holds the index 3, the limit is 3"},
      {"'attributes':{'POSITION':0},'indices':0", "accessors[0] has 3 components, not 1"},
      {"'attributes':{'POSITION':0},'indices':6", "accessors[6] holds indices that are not unsigned"},
      {"'attributes':{'POSITION':4}", "meshes[0] '' primitives[0]: accessors[4] element 2 is not a finite number"},
      {"'attributes':{'POSITION':5}", "accessors[5] element 2 is not a finite number"},
  };
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  GLTF_FLOATS(&build, "VEC2", 3, 0, 0, 0, 0, 0, 0);
  GLTF_FLOATS(&build, "VEC3", 2, 0, 0, 1, 0, 0, 1);
  gltf_array(&build, 5121, "SCALAR", far, sizeof far, 3, "");
  gltf_array(&build, 5126, "VEC3", holes, sizeof holes, 3, "");
  gltf_array(&build, 5126, "VEC3", ends, sizeof ends, 3, "");
  GLTF_FLOATS(&build, "SCALAR", 3, 0, 1, 2);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    gltf_read_fails(gltf_save(&build, ONE_NODE ",'meshes':[{'primitives':[{%s}]}]", cases[i].primitive),
                    STATUS_BAD_SCENE, cases[i].message);
}

// A few bytes of JSON that ask for 24 GiB, and a hundred meshes that share one accessor.
static void memory_is_bounded(void **state)
{
  GltfBuild build = {0};
  gltf_accessor(&build, "{'componentType':5126,'type':'VEC3','count':2147483647}");
  gltf_read_fails(gltf_save(&build, ONE_NODE "," ONE_MESH), STATUS_TOO_LARGE,
                  "meshes[0] 'leg' primitives[0] needs more memory than allowed: raise --max-memory");

  GltfBuild small = {0};
  char nodes[4096] = "{'mesh':0}";
  GLTF_FLOATS(&small, "VEC3", 3, TRIANGLE);
  for (int i = 0; i < 99; i++) strcat(nodes, ",{'mesh':0}");
  const char *path = gltf_save(&small, "'scenes':[{'nodes':[0,1,2]}],'nodes':[%s]," ONE_MESH, nodes);
  gltf_options.max_memory_bytes = 15000;
  gltf_read_fails(path, STATUS_TOO_LARGE, "needs more memory than allowed");
  gltf_options.max_memory_bytes = 0;
  Scene scene = gltf_read_fine(path);
  assert_int_equal(scene.object_count, 3);
  scene_free(&scene);
}

// ---- buffers and the files they may name ---------------------------------------------------------------------------

static const char *buffer_save(const char *uri)
{
  return gltf_save_text("{" ASSET
                        ",'buffers':[{'uri':'%s','byteLength':36}],'bufferViews':[{'buffer':0,'byteLength':36}],"
                        "'accessors':[{'bufferView':0,'componentType':5126,'type':'VEC3','count':3}]," ONE_NODE
                        "," ONE_MESH "}",
                        uri);
}

static void buffers_that_are_missing_or_short(void **state)
{
  gltf_save_bytes("short.bin", "12345", 5);
  gltf_read_fails(buffer_save("none.bin"), STATUS_NOT_FOUND, "refers to 'none.bin': No such file or directory");
  gltf_read_fails(buffer_save("short.bin"), STATUS_BAD_SCENE, "short.bin: is 5 bytes long where 36 are needed");
  gltf_read_fails(buffer_save("data:;base64,AAAA"), STATUS_BAD_SCENE, "buffers[0] holds 3 of its 36 bytes");
  gltf_read_fails(buffer_save("data:nothing"), STATUS_BAD_SCENE, "a data: URI has no comma");
  gltf_read_fails(buffer_save("data:,%0g"), STATUS_BAD_SCENE, "a data: URI is not valid percent-encoding");
  gltf_read_fails(buffer_save("."), STATUS_NOT_FOUND, "is a folder");
  gltf_read_fails(gltf_save_text("{" ASSET ",'buffers':[{'byteLength':1}]}"), STATUS_BAD_SCENE,
                  "buffers[0] holds 0 of its 1");
}

static void files_outside_the_folder_need_leave(void **state)
{
  const float positions[] = {TRIANGLE};
  char outside[] = "/tmp/test_gltf_outside_XXXXXX", path[256], target[300];
  assert_non_null(mkdtemp(outside));
  snprintf(path, sizeof path, "../%s/x.bin", strrchr(outside, '/') + 1);
  snprintf(target, sizeof target, "%s/%s", gltf_folder, path);
  FILE *file = fopen(target, "wb");
  assert_non_null(file);
  fwrite(positions, sizeof positions, 1, file);
  fclose(file);
  snprintf(target, sizeof target, "%s/link.bin", gltf_folder);
  assert_int_equal(symlink(outside, target), 0);
  snprintf(target, sizeof target, "%s/x.bin", outside);

  const char *const uris[] = {path, target, "link.bin/x.bin", "./a/..//../etc/passwd", "%2e%2e/x", "/none"};
  for (size_t i = 0; i < sizeof uris / sizeof *uris; i++)
    gltf_read_fails(buffer_save(uris[i]), STATUS_BAD_SCENE, "--allow-outside");
  for (size_t i = 0; i < 3; i++) {
    gltf_options.allow_outside = true;
    Scene scene = gltf_read_fine(buffer_save(uris[i]));
    assert_int_equal(scene_triangle_count(&scene), 1);
    scene_free(&scene);
  }
  gltf_read_fails(buffer_save("https://example.org/x.bin"), STATUS_UNSUPPORTED,
                  "refers to 'https://example.org/x.bin'");
  gltf_read_fails(buffer_save("a%00b"), STATUS_BAD_SCENE, "'a%00b' is not a valid URI");
  unlink(target);
  rmdir(outside);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(views_and_accessors_stay_in_bounds),
      cmocka_unit_test(attributes_that_do_not_fit),
      cmocka_unit_test(memory_is_bounded),
      cmocka_unit_test(buffers_that_are_missing_or_short),
      cmocka_unit_test(files_outside_the_folder_need_leave),
  };
  return cmocka_run_group_tests(tests, gltf_tests_begin, gltf_tests_end);
}
