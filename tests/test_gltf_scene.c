// glTF import: nodes, cameras, lights, materials and images.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "support/gltf_build.h"

#define ONE_MESH "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]"

static GltfBuild triangle_build(void)
{
  GltfBuild build = {0};
  GLTF_FLOATS(&build, "VEC3", 3, TRIANGLE);
  return build;
}

// ---- nodes ---------------------------------------------------------------------------------------------------------

static void transforms_compose_down_the_hierarchy(void **state)
{
  GltfBuild build = triangle_build();
  Scene scene = gltf_read_fine(gltf_save(
      &build,
      "'scenes':[{'nodes':[2]}],'nodes':[{'mesh':0,'name':'leaf','matrix':[1,0,0,0, 0,1,0,0, 0,0,1,0, 1,2,3,1]},"
      "{'children':[0],'rotation':[0,0,0.7071067811865476,0.7071067811865476]},"
      "{'children':[1,3],'translation':[10,0,0],'scale':[2,3,-1]},{'mesh':0,'scale':[1,1,1]}]," ONE_MESH));
  assert_int_equal(scene.object_count, 2);
  assert_int_equal(scene.mesh_count, 1);
  assert_string_equal(scene.objects[0].name, "leaf");
  assert_vec3(gltf_object_point(&scene, 0, 0, 0, 0), 6, 3, -3);  // (1, 2, 3), turned to (-2, 1, 3), scaled and moved
  assert_vec3(gltf_object_point(&scene, 0, 1, 0, 0), 6, 6, -3);
  assert_vec3(gltf_object_point(&scene, 1, 1, 1, 1), 12, 3, -1);
  assert_true(mat4_determinant3(&scene.objects[1].world_from_object) < 0);
  scene_free(&scene);
}

static void the_chosen_scene_alone_is_read(void **state)
{
  GltfBuild build = triangle_build();
  const char *path = gltf_save(&build,
                               "'scene':1,'scenes':[{'nodes':[0]},{'nodes':[1,2]}],'nodes':[{'mesh':0,'name':'a'},"
                               "{'mesh':0,'name':'b'},{'mesh':0,'name':'c'}]," ONE_MESH);
  Scene scene = gltf_read_fine(path);
  assert_int_equal(scene.object_count, 2);
  assert_string_equal(scene.objects[0].name, "b");
  scene_free(&scene);
  gltf_options.scene = 0;
  scene = gltf_read_fine(path);
  assert_int_equal(scene.object_count, 1);
  assert_string_equal(scene.objects[0].name, "a");
  scene_free(&scene);
  gltf_options.scene = 2;
  gltf_read_fails(path, STATUS_USAGE, "has 2 scenes, no scene 2");
}

static void a_chain_of_50000_nodes_needs_no_stack(void **state)
{
  enum { COUNT = 50000, BYTES = 64 * COUNT };
  char *text = malloc(BYTES);
  int length = snprintf(text, BYTES, "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[");
  for (int i = 1; i < COUNT; i++) length += snprintf(text + length, BYTES - length, "{\"children\":[%d]},", i);
  length += snprintf(text + length, BYTES - length, "{}]}");
  Scene scene = gltf_read_fine(gltf_save_bytes("chain.gltf", text, (size_t)length));
  assert_int_equal(scene.object_count, 0);
  scene_free(&scene);
  free(text);
}

static void instances_become_objects(void **state)
{
  GltfBuild build = triangle_build();
  GLTF_FLOATS(&build, "VEC3", 2, 0, 0, 0, 5, 0, 0);
  GLTF_FLOATS(&build, "VEC4", 2, 0, 0, 0, 1, 0, 0, 0.70710678f, 0.70710678f);
  GLTF_FLOATS(&build, "VEC3", 2, 1, 1, 1, 2, 2, 2);
  Scene scene = gltf_read_fine(
      gltf_save(&build,
                "'extensionsUsed':['EXT_mesh_gpu_instancing'],'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,"
                "'translation':[0,0,7],'extensions':{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':1,"
                "'ROTATION':2,'SCALE':3}}}}]," ONE_MESH));
  assert_int_equal(scene.object_count, 2);
  assert_int_equal(scene_triangle_count(&scene), 2);
  assert_vec3(gltf_object_point(&scene, 0, 1, 0, 0), 1, 0, 7);
  assert_vec3(gltf_object_point(&scene, 1, 1, 0, 0), 5, 2, 7);
  assert_string_equal(gltf_warnings, "");
  scene_free(&scene);
}

static void what_is_not_read_is_named_once(void **state)
{
  GltfBuild build = triangle_build();
  GLTF_FLOATS(&build, "SCALAR", 1, 0);
  Scene scene = gltf_read_fine(gltf_save(
      &build, "'extensionsUsed':['KHR_materials_sheen','KHR_lights_punctual']," ONE_NODE "," ONE_MESH
              ",'materials':[{'extensions':{'KHR_materials_sheen':{'sheenColorFactor':[1,1,1]}}}],"
              "'animations':[{'samplers':[{'input':1,'output':0}],'channels':[{'sampler':0,'target':{'node':0,"
              "'path':'translation'}}]}]"));
  assert_non_null(strstr(gltf_warnings, "uses the extension KHR_materials_sheen"));
  assert_non_null(strstr(gltf_warnings, "1 animations: the pose at rest is drawn"));
  assert_null(strstr(gltf_warnings, "KHR_lights_punctual"));
  scene_free(&scene);
}

// ---- cameras and lights --------------------------------------------------------------------------------------------

static void cameras_lose_their_scale(void **state)
{
  Scene scene = gltf_read_fine(gltf_save_text(
      "{'asset':{'version':'2.0'},'scenes':[{'nodes':[0,1]}],'nodes':[{'camera':0,'name':'node','translation':[1,2,3],"
      "'scale':[2,-3,-4],'rotation':[0,0.7071067811865476,0,0.7071067811865476]},{'camera':1}],'cameras':["
      "{'type':'perspective','perspective':{'yfov':0.5,'znear':0.25}},"
      "{'name':'flat','type':'orthographic','orthographic':{'xmag':2,'ymag':3,'znear':0,'zfar':9}}]}"));
  assert_int_equal(scene.camera_count, 2);
  const Camera *camera = &scene.cameras[0];
  assert_string_equal(camera->name, "node");
  assert_int_equal(camera->kind, CAMERA_PERSPECTIVE);
  assert_near(camera->yfov_rad, 0.5);
  assert_near(camera->znear_m, 0.25);
  assert_true(isinf(camera->zfar_m));
  assert_near(mat4_determinant3(&camera->world_from_camera), 1);
  assert_vec3(mat4_point(&camera->world_from_camera, vec3(0, 0, 0)), 1, 2, 3);
  assert_vec3(mat4_direction(&camera->world_from_camera, vec3(0, 0, -1)), -1, 0, 0);
  assert_vec3(mat4_direction(&camera->world_from_camera, vec3(0, 1, 0)), 0, 1, 0);
  camera = &scene.cameras[1];
  assert_string_equal(camera->name, "flat");
  assert_int_equal(camera->kind, CAMERA_ORTHOGRAPHIC);
  assert_near(camera->ymag_m, 3);
  assert_near(camera->zfar_m, 9);
  scene_free(&scene);
}

static void cameras_that_make_no_image_are_left_out_by_name(void **state)
{
  const char *const flaws[] = {"'type':'perspective','perspective':{'yfov':0,'znear':1}",
                               "'type':'perspective','perspective':{'yfov':4,'znear':1}",
                               "'type':'perspective','perspective':{'yfov':1,'znear':0}",
                               "'type':'perspective','perspective':{'yfov':1,'znear':2,'zfar':1}",
                               "'type':'orthographic','orthographic':{'xmag':1,'ymag':0,'znear':0,'zfar':1}",
                               "'type':'orthographic','orthographic':{'xmag':1,'ymag':1,'znear':1,'zfar':1}"};
  for (size_t i = 0; i < sizeof flaws / sizeof *flaws; i++) {
    Scene scene = gltf_read_fine(gltf_save_text(
        "{'asset':{'version':'2.0'},'scenes':[{'nodes':[0]}],'nodes':[{'camera':0}],'cameras':[{'name':'odd',%s}]}",
        flaws[i]));
    assert_int_equal(scene.camera_count, 0);
    assert_non_null(strstr(gltf_warnings, "cameras[0] 'odd' is left out: "));
    scene_free(&scene);
  }
}

static void lights_shine_along_their_nodes(void **state)
{
  Scene scene = gltf_read_fine(gltf_save_text(
      "{'asset':{'version':'2.0'},'extensionsUsed':['KHR_lights_punctual'],'extensionsRequired':['KHR_lights_punctual']"
      ","
      "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'directional','name':'sun','intensity':3,"
      "'color':[1,0.5,0.25]},{'type':'point','range':8},{'type':'spot','intensity':2,'spot':{'innerConeAngle':0.1,"
      "'outerConeAngle':0.2}},{'type':'spot','spot':{}}]}},'scenes':[{'nodes':[0,1,2,3]}],'nodes':["
      "{'rotation':[-0.7071067811865476,0,0,0.7071067811865476],'extensions':{'KHR_lights_punctual':{'light':0}}},"
      "{'name':'bulb','translation':[1,2,3],'scale':[9,9,9],'extensions':{'KHR_lights_punctual':{'light':1}}},"
      "{'extensions':{'KHR_lights_punctual':{'light':2}}},{'extensions':{'KHR_lights_punctual':{'light':3}}}]}"));
  const Light *lights = scene.lights;
  assert_int_equal(scene.light_count, 4);
  assert_string_equal(lights[0].name, "sun");
  assert_int_equal(lights[0].kind, LIGHT_DIRECTIONAL);
  assert_vec3(lights[0].direction_world, 0, -1, 0);
  ASSERT_FLOATS(lights[0].color, 1, 0.5f, 0.25f);
  assert_near(lights[0].intensity, 3);
  assert_string_equal(lights[1].name, "bulb");
  assert_int_equal(lights[1].kind, LIGHT_POINT);
  assert_vec3(lights[1].position_world, 1, 2, 3);
  assert_near(lights[1].range_m, 8);
  ASSERT_FLOATS(lights[1].color, 1, 1, 1);
  assert_near(lights[1].intensity, 1);
  assert_int_equal(lights[2].kind, LIGHT_SPOT);
  assert_true(isinf(lights[2].range_m));
  assert_near(lights[2].inner_cone_rad, 0.1);
  assert_near(lights[2].outer_cone_rad, 0.2);
  assert_near(lights[3].inner_cone_rad, 0);
  assert_near(lights[3].outer_cone_rad, M_PI / 4);
  scene_free(&scene);
}

// What is too far for single precision lights nothing, and is named; a directional light shines from anywhere.
static void lights_at_infinity_are_left_out_by_name(void **state)
{
  Scene scene = gltf_read_fine(gltf_save_text(
      "{'asset':{'version':'2.0'},'extensionsUsed':['KHR_lights_punctual'],"
      "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'directional'},{'type':'point','name':'lost'},"
      "{'type':'spot','spot':{}}]}},'scenes':[{'nodes':[0,1,2]}],'nodes':["
      "{'translation':[1e300,0,0],'extensions':{'KHR_lights_punctual':{'light':0}}},"
      "{'translation':[0,-1e39,0],'extensions':{'KHR_lights_punctual':{'light':1}}},"
      "{'translation':[0,0,1e30],'extensions':{'KHR_lights_punctual':{'light':2}}}]}"));
  assert_non_null(strstr(gltf_warnings, "the light 'lost' is left out: it stands at infinity"));
  assert_int_equal(scene.light_count, 2);
  assert_int_equal(scene.lights[0].kind, LIGHT_DIRECTIONAL);
  assert_int_equal(scene.lights[1].kind, LIGHT_SPOT);
  scene_free(&scene);
}

// ---- materials and images ------------------------------------------------------------------------------------------

static void material_factors_and_slots(void **state)
{
  GltfBuild build = triangle_build();
  int view = gltf_view(&build, gltf_png, gltf_png_bytes, 0);
  Scene scene = gltf_read_fine(gltf_save(
      &build,
      "'extensionsUsed':['KHR_texture_transform','KHR_materials_unlit','KHR_materials_emissive_strength']," ONE_NODE
      ",'meshes':[{'primitives':[{'material':0,'attributes':{'POSITION':0}}]}],'images':[{'bufferView':%d,"
      "'mimeType':'image/png'}],'samplers':[{'wrapS':33071,'wrapT':33648,'magFilter':9728,'minFilter':9987}],"
      "'textures':[{'source':0},{'source':0,'sampler':0}],'materials':[{'name':'paint','alphaMode':'MASK',"
      "'alphaCutoff':0.25,'doubleSided':true,'emissiveFactor':[1,0.5,0],'extensions':{'KHR_materials_unlit':{},"
      "'KHR_materials_emissive_strength':{'emissiveStrength':4}},'pbrMetallicRoughness':{'baseColorFactor':[0.1,0.2,0."
      "3,"
      "0.4],'metallicFactor':0.5,'roughnessFactor':0.75,'baseColorTexture':{'index':1,'texCoord':0,'extensions':{"
      "'KHR_texture_transform':{'offset':[0.5,0.25],'rotation':1.5707963267948966,'scale':[2,3],'texCoord':1}}},"
      "'metallicRoughnessTexture':{'index':0,'texCoord':1}},'normalTexture':{'index':0,'scale':0.5},'occlusionTexture':"
      "{"
      "'index':0,'strength':0.25},'emissiveTexture':{'index':1}}]",
      view));
  const Material *m = &scene.materials[0];
  assert_int_equal(scene.material_count, 1);
  assert_string_equal(m->name, "paint");
  ASSERT_FLOATS(m->base_color, 0.1f, 0.2f, 0.3f, 0.4f);
  assert_near(m->metallic, 0.5);
  assert_near(m->roughness, 0.75);
  ASSERT_FLOATS(m->emission, 4, 2, 0);
  assert_int_equal(m->alpha_mode, ALPHA_MASK);
  assert_near(m->alpha_cutoff, 0.25);
  assert_true(m->double_sided && m->unlit);
  assert_near(m->normal_scale, 0.5);
  assert_near(m->occlusion_strength, 0.25);
  assert_int_equal(scene.image_count, 1);
  assert_int_equal(scene.texture_count, 2);
  const Texture *texture = &scene.textures[m->base_color_slot.texture];
  assert_int_equal(texture->image, 0);
  assert_int_equal(texture->wrap_u, WRAP_CLAMP);
  assert_int_equal(texture->wrap_v, WRAP_MIRROR);
  assert_true(texture->nearest);
  texture = &scene.textures[m->metallic_roughness_slot.texture];
  assert_int_equal(texture->wrap_u, WRAP_REPEAT);
  assert_false(texture->nearest);
  assert_int_equal(m->emission_slot.texture, m->base_color_slot.texture);
  assert_int_equal(m->normal_slot.texture, m->metallic_roughness_slot.texture);
  assert_int_equal(m->base_color_slot.uv_set, 1);
  assert_int_equal(m->metallic_roughness_slot.uv_set, 1);
  assert_int_equal(m->occlusion_slot.uv_set, 0);
  ASSERT_FLOATS(m->base_color_slot.uv_from_uv, 0, 3, 0.5f, -2, 0, 0.25f);
  ASSERT_FLOATS(m->normal_slot.uv_from_uv, 1, 0, 0, 0, 1, 0);
  const uint8_t texels[] = {255, 0, 0, 255, 0, 128, 255, 255};
  assert_int_equal(scene.images[0].width, 2);
  assert_memory_equal(scene.images[0].texels, texels, sizeof texels);
  scene_free(&scene);
}

static const char *image_file_save(const GltfBuild *build, const char *uri, int material)
{
  return gltf_save(build,
                   ONE_NODE
                   ",'meshes':[{'primitives':[{'material':%d,'attributes':{'POSITION':0}}]}],'images':["
                   "{'uri':'%s'}],'textures':[{'source':0}],'materials':[{'pbrMetallicRoughness':{"
                   "'baseColorTexture':{'index':0}}},{'name':'plain'}]",
                   material, uri);
}

static void images_come_from_files_and_data_uris(void **state)
{
  GltfBuild build = triangle_build();
  gltf_save_bytes("two words.png", gltf_png, gltf_png_bytes);
  const char *const uris[] = {
      "two%20words.png", "./two words.png",
      "data:image/png;base64,"
      "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAIAAAB7QOjdAAAAD0lEQVR42mP4z8DA0PAfAAgAAn8lPvwJAAAAAElFTkSuQmCC"};
  for (size_t i = 0; i < sizeof uris / sizeof *uris; i++) {
    Scene scene = gltf_read_fine(image_file_save(&build, uris[i], 0));
    assert_int_equal(scene.image_count, 1);
    assert_int_equal(scene.images[0].texels[5], 128);
    scene_free(&scene);
  }
}

static void missing_and_broken_images_are_named(void **state)
{
  GltfBuild build = triangle_build();
  gltf_save_bytes("broken.png", gltf_png, gltf_png_bytes / 2);
  gltf_read_fails(image_file_save(&build, "nowhere.png", 0), STATUS_NOT_FOUND, "refers to 'nowhere.png': No such file");
  gltf_read_fails(image_file_save(&build, "broken.png", 0), STATUS_BAD_IMAGE, "/broken.png: ");
  gltf_read_fails(image_file_save(&build, "data:image/png;base64,AAAA", 0), STATUS_BAD_IMAGE, "test.glb: images[0]: ");
  gltf_read_fails(image_file_save(&build, "data:image/png;base64,A*AA", 0), STATUS_BAD_SCENE, "not valid base64");
}

// A material that nothing draws keeps its index, but its pictures are not even looked for.
static void unused_materials_need_no_image(void **state)
{
  GltfBuild build = triangle_build();
  Scene scene = gltf_read_fine(image_file_save(&build, "nowhere.png", 1));
  assert_int_equal(scene.image_count, 0);
  assert_int_equal(scene.texture_count, 0);
  assert_int_equal(scene.material_count, 2);
  assert_int_equal(scene.materials[0].base_color_slot.texture, NONE);
  assert_string_equal(scene.materials[scene.meshes[0].primitives[0].material].name, "plain");
  scene_free(&scene);
}

// ---- where bytes come from -----------------------------------------------------------------------------------------

static void buffers_come_from_files_and_data_uris(void **state)
{
  const float positions[] = {TRIANGLE};
  char folder[256];
  snprintf(folder, sizeof folder, "%s/sub", gltf_folder);
  mkdir(folder, 0755);
  gltf_save_bytes("sub/b%c.bin", positions, sizeof positions);
  const char *const uris[] = {"sub/b%25c.bin", "sub/../sub/b%25c.bin",
                              "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"};
  for (size_t i = 0; i < sizeof uris / sizeof *uris; i++) {
    Scene scene = gltf_read_fine(gltf_save_text(
        "{'asset':{'version':'2.0'},'buffers':[{'uri':'%s','byteLength':36}],'bufferViews':[{'buffer':0,'byteLength':"
        "36}],"
        "'accessors':[{'bufferView':0,'componentType':5126,'type':'VEC3','count':3.0}]," ONE_NODE "," ONE_MESH "}",
        uris[i]));
    ASSERT_FLOATS(scene.meshes[0].primitives[0].positions[1], 1, 0, 0);
    scene_free(&scene);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(transforms_compose_down_the_hierarchy),
      cmocka_unit_test(the_chosen_scene_alone_is_read),
      cmocka_unit_test(a_chain_of_50000_nodes_needs_no_stack),
      cmocka_unit_test(instances_become_objects),
      cmocka_unit_test(what_is_not_read_is_named_once),
      cmocka_unit_test(cameras_lose_their_scale),
      cmocka_unit_test(cameras_that_make_no_image_are_left_out_by_name),
      cmocka_unit_test(lights_shine_along_their_nodes),
      cmocka_unit_test(lights_at_infinity_are_left_out_by_name),
      cmocka_unit_test(material_factors_and_slots),
      cmocka_unit_test(images_come_from_files_and_data_uris),
      cmocka_unit_test(missing_and_broken_images_are_named),
      cmocka_unit_test(unused_materials_need_no_image),
      cmocka_unit_test(buffers_come_from_files_and_data_uris),
  };
  return cmocka_run_group_tests(tests, gltf_tests_begin, gltf_tests_end);
}
