// glTF import: each feature on a file small enough to know the answer by heart.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/gltf_build.h"

// ---- primitives ----------------------------------------------------------------------------------------------------

static void bare_triangle_gets_normals_material_and_names(void **state)
{
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  Scene scene =
      gltf_read_fine(gltf_save(&build, ONE_NODE ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"));
  const Primitive *primitive = &scene.meshes[0].primitives[0];
  const Material *material = &scene.materials[primitive->material];
  assert_int_equal(scene_triangle_count(&scene), 1);
  assert_string_equal(scene.objects[0].name, "thing");
  for (int i = 0; i < 3; i++) ASSERT_FLOATS(primitive->normals[i], 0, 0, 1);
  assert_null(primitive->tangents);
  assert_null(primitive->uvs[0]);
  assert_null(primitive->colors);
  assert_int_equal(scene.material_count, 1);
  ASSERT_FLOATS(material->base_color, 1, 1, 1, 1);
  assert_near(material->metallic, 1);
  assert_near(material->roughness, 1);
  assert_int_equal(material->base_color_slot.texture, NONE);
  assert_string_equal(gltf_warnings, "");
  scene_free(&scene);
}

static void strips_fans_and_lists_keep_their_winding(void **state)
{
  const uint16_t order[] = {4, 3, 2, 1, 0};
  const struct {
    int mode, first_accessor;
    uint32_t triangles[3][3], count;
  } cases[] = {
      {4, NONE, {{0, 1, 2}}, 1},  // two of five are left over
      {5, NONE, {{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}, 3},
      {6, NONE, {{1, 2, 0}, {2, 3, 0}, {3, 4, 0}}, 3},
      {4, 2, {{4, 3, 2}}, 1},
      {5, 2, {{4, 3, 2}, {3, 1, 2}, {2, 1, 0}}, 3},
      {6, 2, {{3, 2, 4}, {2, 1, 4}, {1, 0, 4}}, 3},
  };
  for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
    GltfBuild build = {0};
    GLTF_FLOATS(&build, "VEC3", 5, 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0);
    GLTF_FLOATS(&build, "VEC3", 5, 0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2);
    gltf_array(&build, 5123, "SCALAR", order, sizeof order, 5, "");
    Scene scene = gltf_read_fine(
        gltf_save(&build, ONE_NODE ",'meshes':[{'primitives':[{'mode':%d,'attributes':{'POSITION':0,'NORMAL':1}%s}]}]",
                  cases[c].mode, cases[c].first_accessor == NONE ? "" : ",'indices':2"));
    const Primitive *primitive = &scene.meshes[0].primitives[0];
    assert_int_equal(primitive->triangle_count, cases[c].count);
    assert_memory_equal(primitive->triangles, cases[c].triangles, cases[c].count * sizeof *primitive->triangles);
    ASSERT_FLOATS(primitive->normals[4], 0, 0, 1);
    scene_free(&scene);
  }
}

static void points_and_lines_are_left_out_by_name(void **state)
{
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  Scene scene = gltf_read_fine(gltf_save(&build,
                                         "'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0},{'mesh':1}],'meshes':["
                                         "{'name':'dots','primitives':[{'mode':0,'attributes':{'POSITION':0}}]},"
                                         "{'primitives':[{'mode':3,'attributes':{'POSITION':0}},"
                                         "{'attributes':{'POSITION':0}}]}]"));
  assert_int_equal(scene.object_count, 1);
  assert_int_equal(scene_triangle_count(&scene), 1);
  assert_non_null(strstr(gltf_warnings, "meshes[0] 'dots' primitives[0]: points or lines are not drawn"));
  scene_free(&scene);
}

static void every_component_type_decodes(void **state)
{
  const int8_t bytes[] = {-128, 127, 64, 0};
  const uint8_t ubytes[] = {255, 51, 0, 0};
  const int16_t shorts[] = {-32768, 32767, 100, 0};
  const uint16_t ushorts[] = {65535, 13107, 7, 0};
  const struct {
    int type;
    const void *data;
    size_t size;
    bool normalized;
    float expected[3];
  } cases[] = {
      {5120, bytes, sizeof bytes, false, {-128, 127, 64}},
      {5120, bytes, sizeof bytes, true, {-1, 1, 64 / 127.f}},
      {5121, ubytes, sizeof ubytes, false, {255, 51, 0}},
      {5121, ubytes, sizeof ubytes, true, {1, 0.2f, 0}},
      {5122, shorts, sizeof shorts, false, {-32768, 32767, 100}},
      {5122, shorts, sizeof shorts, true, {-1, 1, 100 / 32767.f}},
      {5123, ushorts, sizeof ushorts, false, {65535, 13107, 7}},
      {5123, ushorts, sizeof ushorts, true, {1, 0.2f, 7 / 65535.f}},
  };
  for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
    GltfBuild build = {0};
    uint8_t padded[24] = {0};
    memcpy(padded, cases[c].data, cases[c].size);
    // Three elements 8 bytes apart, of which the first counts: interleaved as well.
    int view = gltf_view(&build, padded, sizeof padded, 8);
    gltf_accessor(&build, "{'bufferView':%d,'componentType':%d,'type':'VEC3','count':3%s}", view, cases[c].type,
                  cases[c].normalized ? ",'normalized':true" : "");
    Scene scene = gltf_read_fine(gltf_save(&build,
                                           "'extensionsUsed':['KHR_mesh_quantization'],'extensionsRequired':["
                                           "'KHR_mesh_quantization']," ONE_NODE
                                           ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"));
    assert_floats(scene.meshes[0].primitives[0].positions[0], 3, cases[c].expected);
    ASSERT_FLOATS(scene.meshes[0].primitives[0].positions[1], 0, 0, 0);
    scene_free(&scene);
  }
}

static void indices_of_each_width(void **state)
{
  const uint8_t u8[] = {2, 0, 1};
  const uint16_t u16[] = {2, 0, 1};
  const uint32_t u32[] = {2, 0, 1}, expected[] = {2, 0, 1};
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  GLTF_FLOATS(&build, "VEC3", 3, 0, 0, 1, 0, 0, 1, 0, 0, 1);
  gltf_array(&build, 5121, "SCALAR", u8, sizeof u8, 3, "");
  gltf_array(&build, 5123, "SCALAR", u16, sizeof u16, 3, "");
  gltf_array(&build, 5125, "SCALAR", u32, sizeof u32, 3, "");
  for (int i = 2; i < 5; i++) {
    Scene scene = gltf_read_fine(gltf_save(
        &build, ONE_NODE ",'meshes':[{'primitives':[{'indices':%d,'attributes':{'POSITION':0,'NORMAL':1}}]}]", i));
    assert_memory_equal(scene.meshes[0].primitives[0].triangles[0], expected, sizeof expected);
    scene_free(&scene);
  }
}

static void interleaved_attributes_share_a_view(void **state)
{
  const float data[] = {0, 0, 0, 0.5f, 0.25f, 1, 0, 0, 1, 2, 0, 1, 0, 3, 4};
  GltfBuild build = {0};
  int view = gltf_view(&build, data, sizeof data, 20);
  gltf_accessor(&build, "{'bufferView':%d,'componentType':5126,'type':'VEC3','count':3}", view);
  gltf_accessor(&build, "{'bufferView':%d,'byteOffset':12,'componentType':5126,'type':'VEC2','count':3}", view);
  Scene scene = gltf_read_fine(
      gltf_save(&build, ONE_NODE ",'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_1':1}}]}]"));
  const Primitive *primitive = &scene.meshes[0].primitives[0];
  ASSERT_FLOATS(primitive->positions[1], 1, 0, 0);
  ASSERT_FLOATS(primitive->uvs[1][0], 0.5f, 0.25f);
  ASSERT_FLOATS(primitive->uvs[1][2], 3, 4);
  assert_null(primitive->uvs[0]);
  scene_free(&scene);
}

static void sparse_accessors_with_and_without_a_view(void **state)
{
  const uint16_t replaced[] = {2};
  GltfBuild build = {0};
  int base = gltf_view(&build, (const float[]){TRIANGLE}, 36, 0);
  int indices = gltf_view(&build, replaced, sizeof replaced, 0);
  int values = gltf_view(&build, (const float[]){5, 6, 7}, 12, 0);
  for (int with_view = 0; with_view < 2; with_view++) {
    char view[32] = "";
    if (with_view) snprintf(view, sizeof view, "'bufferView':%d,", base);
    int accessor = gltf_accessor(&build,
                                 "{%s'componentType':5126,'type':'VEC3','count':3,'sparse':{'count':1,'indices':{"
                                 "'bufferView':%d,'componentType':5123},'values':{'bufferView':%d}}}",
                                 view, indices, values);
    Scene scene = gltf_read_fine(
        gltf_save(&build, ONE_NODE ",'meshes':[{'primitives':[{'attributes':{'POSITION':%d}}]}]", accessor));
    ASSERT_FLOATS(scene.meshes[0].primitives[0].positions[1], (float)with_view, 0, 0);
    ASSERT_FLOATS(scene.meshes[0].primitives[0].positions[2], 5, 6, 7);
    scene_free(&scene);
  }
}

static void normals_and_tangents_come_out_unit_length(void **state)
{
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, 0, 0, 0, 0, 1, 0, 0, 0, 1);
  GLTF_FLOATS(&build, "VEC3", 3, 3, 0, 4, 0, 0, 0, 0, -5, 0);  // the zero one is made from its triangle
  GLTF_FLOATS(&build, "VEC4", 3, 2, 0, 0, 1, 0, 3, 0, -1, 0, 0, 4, 1);
  Scene scene = gltf_read_fine(
      gltf_save(&build, ONE_NODE ",'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1,'TANGENT':2}}]}]"));
  const Primitive *primitive = &scene.meshes[0].primitives[0];
  ASSERT_FLOATS(primitive->normals[0], 0.6f, 0, 0.8f);
  ASSERT_FLOATS(primitive->normals[1], 1, 0, 0);
  ASSERT_FLOATS(primitive->normals[2], 0, -1, 0);
  ASSERT_FLOATS(primitive->tangents[1], 0, 1, 0, -1);
  scene_free(&scene);
}

// Two triangles fold along a shared edge: each corner gets its own triangle's normal, and keeps its other attributes.
static void flat_normals_unshare_vertices(void **state)
{
  const uint8_t indices[] = {0, 1, 2, 1, 0, 3};
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 4, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1);
  GLTF_FLOATS(&build, "VEC2", 4, 0, 0, 1, 10, 2, 20, 3, 30);
  gltf_array(&build, 5121, "SCALAR", indices, sizeof indices, 6, "");
  Scene scene = gltf_read_fine(
      gltf_save(&build, ONE_NODE
                ",'meshes':[{'primitives':[{'indices':2,'attributes':{'POSITION':0,'TEXCOORD_0':1,'COLOR_0':0}}]}]"));
  const Primitive *primitive = &scene.meshes[0].primitives[0];
  assert_int_equal(primitive->vertex_count, 6);
  for (int corner = 0; corner < 3; corner++) {
    ASSERT_FLOATS(primitive->normals[primitive->triangles[0][corner]], 0, 0, 1);
    ASSERT_FLOATS(primitive->normals[primitive->triangles[1][corner]], 0, 1, 0);
  }
  uint32_t last = primitive->triangles[1][2];
  ASSERT_FLOATS(primitive->positions[last], 0, 0, 1);
  ASSERT_FLOATS(primitive->uvs[0][last], 3, 30);
  ASSERT_FLOATS(primitive->colors[last], 0, 0, 1, 1);
  scene_free(&scene);
}

static void colors_of_every_form_become_four_floats(void **state)
{
  const uint8_t ubytes[] = {255, 0, 51, 102, 0, 0, 0, 0, 0, 0, 0, 0};
  const uint16_t ushorts[] = {65535, 0, 13107, 26214, 0, 0, 0, 0, 0, 0, 0, 0};
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  gltf_array(&build, 5121, "VEC4", ubytes, sizeof ubytes, 3, ",'normalized':true");
  gltf_array(&build, 5123, "VEC4", ushorts, sizeof ushorts, 3, ",'normalized':true");
  GLTF_FLOATS(&build, "VEC4", 3, 1, 0, 0.2f, 0.4f, 0, 0, 0, 0, 0, 0, 0, 0);
  GLTF_FLOATS(&build, "VEC3", 3, 1, 0, 0.2f, 0, 0, 0, 0, 0, 0);
  for (int i = 1; i < 5; i++) {
    Scene scene = gltf_read_fine(
        gltf_save(&build, ONE_NODE ",'meshes':[{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':%d}}]}]", i));
    ASSERT_FLOATS(scene.meshes[0].primitives[0].colors[0], 1, 0, 0.2f, i == 4 ? 1 : 0.4f);
    scene_free(&scene);
  }
}

// ---- poses ---------------------------------------------------------------------------------------------------------

static void morph_targets_apply_with_mesh_and_node_weights(void **state)
{
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  GLTF_FLOATS(&build, "VEC3", 3, 0, 0, 1, 0, 0, 1, 0, 0, 1);
  GLTF_FLOATS(&build, "VEC3", 3, 0, 0, 2, 0, 0, 2, 0, 0, 4);
  GLTF_FLOATS(&build, "VEC3", 3, 0, 1, -1, 0, 0, 0, 0, 0, 0);
  Scene scene = gltf_read_fine(
      gltf_save(&build,
                "'scenes':[{'nodes':[0,1,2]}],'nodes':[{'mesh':0},{'mesh':0,'weights':[1]},{'mesh':0}],'meshes':[{"
                "'weights':[0.5],'primitives':[{'attributes':{'POSITION':0,'NORMAL':1},'targets':[{'POSITION':2,"
                "'NORMAL':3}]}]}]"));
  assert_int_equal(scene.mesh_count, 2);
  assert_int_equal(scene.objects[0].mesh, scene.objects[2].mesh);
  ASSERT_FLOATS(scene.meshes[scene.objects[0].mesh].primitives[0].positions[2], 0, 1, 2);
  ASSERT_FLOATS(scene.meshes[scene.objects[1].mesh].primitives[0].positions[2], 0, 1, 4);
  ASSERT_FLOATS(scene.meshes[scene.objects[1].mesh].primitives[0].normals[0], 0, 1, 0);
  scene_free(&scene);
}

// Joint 0 moves by (10, 0, 0), joint 1 turns by 90 degrees about z; its inverse bind matrix first moves by (-1, 0, 0).
static void skins_move_vertices_and_ignore_the_mesh_node(void **state)
{
  const uint8_t joints[] = {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0};
  const float weights[] = {1, 0, 0, 0, 2, 0, 0, 0, 0.5f, 0.5f, 0, 0};  // the second row does not add up to 1
  const float binds[32] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                           1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1};
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, 0, 0, 0, 2, 0, 0, 1, 1, 0);
  GLTF_FLOATS(&build, "VEC3", 3, 1, 0, 0, 1, 0, 0, 1, 0, 0);
  gltf_array(&build, 5121, "VEC4", joints, sizeof joints, 3, "");
  gltf_array(&build, 5126, "VEC4", weights, sizeof weights, 3, "");
  gltf_array(&build, 5126, "MAT4", binds, sizeof binds, 2, "");
  Scene scene = gltf_read_fine(gltf_save(
      &build,
      "'scenes':[{'nodes':[0,1]}],'nodes':[{'mesh':0,'skin':0,'translation':[99,0,0]},{'translation':[10,0,0]},"
      "{'rotation':[0,0,0.7071067811865476,0.7071067811865476]}],'skins':[{'joints':[1,2],'inverseBindMatrices':4}],"
      "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1,'JOINTS_0':2,'WEIGHTS_0':3}}]}]"));
  const Primitive *primitive = &scene.meshes[0].primitives[0];
  ASSERT_FLOATS(primitive->positions[0], 10, 0, 0);
  ASSERT_FLOATS(primitive->positions[1], 0, 1, 0);
  ASSERT_FLOATS(primitive->positions[2], 5, 0.5f, 0);  // between (11, 1, 0) and (-1, 0, 0)
  ASSERT_FLOATS(primitive->normals[1], 0, 1, 0);
  assert_vec3(gltf_object_point(&scene, 0, 1, 2, 3), 1, 2, 3);
  scene_free(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(bare_triangle_gets_normals_material_and_names),
      cmocka_unit_test(strips_fans_and_lists_keep_their_winding),
      cmocka_unit_test(points_and_lines_are_left_out_by_name),
      cmocka_unit_test(every_component_type_decodes),
      cmocka_unit_test(indices_of_each_width),
      cmocka_unit_test(interleaved_attributes_share_a_view),
      cmocka_unit_test(sparse_accessors_with_and_without_a_view),
      cmocka_unit_test(normals_and_tangents_come_out_unit_length),
      cmocka_unit_test(flat_normals_unshare_vertices),
      cmocka_unit_test(colors_of_every_form_become_four_floats),
      cmocka_unit_test(morph_targets_apply_with_mesh_and_node_weights),
      cmocka_unit_test(skins_move_vertices_and_ignore_the_mesh_node),
  };
  return cmocka_run_group_tests(tests, gltf_tests_begin, gltf_tests_end);
}
