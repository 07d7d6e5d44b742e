#include "support/scene_features.h"

#include <string.h>

#include "scene/scene_build.h"
#include "support/oracle_scene.h"

enum { SIDE = 16 };

typedef void (*TexelMaker)(uint8_t out[4], int x, int y);

static uint8_t hashed(int x, int y, int salt)
{
  uint32_t state = (uint32_t)(x * 73856093) ^ (uint32_t)(y * 19349663) ^ (uint32_t)(salt * 83492791);
  return (uint8_t)((state * 1664525u + 1013904223u) >> 24);
}

static void tiles_make(uint8_t out[4], int x, int y)
{
  bool dark = (x < SIDE / 2) ^ (y < SIDE / 2);
  for (int c = 0; c < 3; c++) out[c] = (uint8_t)(dark ? 90 + 30 * c : 230 - 20 * c);
}

static void speckles_make(uint8_t out[4], int x, int y)
{
  for (int c = 0; c < 3; c++) out[c] = (uint8_t)(96 + hashed(x, y, c) / 2);
}

// Holes in rings: alpha is 0 or 255, but for what lies between when filtered.
static void holes_make(uint8_t out[4], int x, int y)
{
  int dx = x - SIDE / 2, dy = y - SIDE / 2;
  out[0] = 200;
  out[1] = out[2] = 60;
  out[3] = (dx * dx + dy * dy) / 12 % 2 ? 0 : 255;
}

// Green is roughness, blue metallic: mirror, gloss and matt in stripes. Red, which is junk, is for occlusion.
static void rough_metal_make(uint8_t out[4], int x, int y)
{
  out[0] = (uint8_t)(40 + 12 * y);
  out[1] = (uint8_t)(x < 4 ? 0 : 80 + 10 * x);
  out[2] = (uint8_t)(y < SIDE / 2 ? 255 : 40);
}

static void bumps_make(uint8_t out[4], int x, int y)
{
  out[0] = (uint8_t)(128 + 50 * ((x / 2 + y / 3) % 3 - 1));
  out[1] = (uint8_t)(128 + 40 * ((x / 3 + y) % 3 - 1));
  out[2] = 230;
}

static void glow_make(uint8_t out[4], int x, int y)
{
  out[0] = out[1] = (uint8_t)(x == y || x == SIDE - 1 - y ? 255 : 0);
  out[2] = 20;
}

static int texture_make(Scene *scene, TexelMaker make)
{
  uint8_t texels[SIDE * SIDE][4];
  for (int i = 0; i < SIDE * SIDE; i++) {
    texels[i][3] = 255;
    make(texels[i], i % SIDE, i / SIDE);
  }
  return scene_add_texture(scene, SIDE, SIDE, (const uint8_t(*)[4])texels);
}

static TextureSlot slot_of(int texture, float scale, float turn)
{
  float c = scale * cosf(turn), s = scale * sinf(turn);
  return (TextureSlot){.texture = texture, .uv_from_uv = {c, s, 0.1f, -s, c, 0.3f}};
}

static void floor_add(Scene *scene)
{
  Material material = material_plain(vec3(0.9, 0.9, 0.9), 0, 0.7);
  material.base_color_slot = slot_of(texture_make(scene, tiles_make), 3, 0.3f);
  scene->textures[material.base_color_slot.texture].nearest = true;
  scene_add_quad(scene, scene_add_material(scene, material), vec3(-4, 0, 3), vec3(8, 0, 0), vec3(0, 0, -6));
}

// Back wall: bumps without tangents, occlusion, and a texture that is mirrored where it repeats.
static void wall_add(Scene *scene)
{
  Material material = material_plain(vec3(0.8, 0.7, 0.5), 0, 0.6);
  material.base_color_slot = slot_of(texture_make(scene, speckles_make), 2.5f, 0);
  material.normal_slot = slot_of(texture_make(scene, bumps_make), 2, 0.5f);
  material.occlusion_slot = slot_of(texture_make(scene, rough_metal_make), 1, 0);
  material.occlusion_strength = 0.8f;
  material.normal_scale = 0.7f;
  scene->textures[material.base_color_slot.texture].wrap_u = WRAP_MIRROR;
  scene->textures[material.base_color_slot.texture].wrap_v = WRAP_MIRROR;
  scene_add_quad(scene, scene_add_material(scene, material), vec3(-4, 0, -3), vec3(8, 0, 0), vec3(0, 4, 0));
}

// A panel whose texture makes mirrors, gloss and matt of it, with bumps along the file's own tangents.
static void panel_add(Scene *scene)
{
  Material material = material_plain(vec3(0.9, 0.8, 0.6), 1, 1);
  material.metallic_roughness_slot = slot_of(texture_make(scene, rough_metal_make), 0.8f, 0);
  material.emission_slot = slot_of(texture_make(scene, glow_make), 0.8f, 0);
  material.normal_slot = slot_of(texture_make(scene, bumps_make), 0.8f, 0);
  material.normal_scale = 0.3f;
  material.emission[0] = material.emission[1] = 0.4f;
  for (int i = 0; i < 3; i++) scene->textures[scene->texture_count - 1 - i].wrap_v = WRAP_CLAMP;
  scene->textures[material.metallic_roughness_slot.texture].nearest = true;
  uint32_t object = scene_add_quad(scene, scene_add_material(scene, material), vec3(-3.4, 0.2, -1.5), vec3(1.8, 0, -1),
                                   vec3(0, 2, 0));
  Primitive *primitive = &scene->meshes[scene->objects[object].mesh].primitives[0];
  primitive->tangents = oracle_array(4, sizeof *primitive->tangents);
  for (int i = 0; i < 4; i++) memcpy(primitive->tangents[i], (float[4]){0.874f, 0, -0.486f, 1}, sizeof(float[4]));
}

static void fence_and_glass_add(Scene *scene)
{
  Material fence = material_plain(vec3(1, 1, 1), 0, 0.5), glass = material_plain(vec3(0.3, 0.7, 0.5), 0, 0);
  fence.alpha_mode = ALPHA_MASK;
  fence.double_sided = true;
  fence.base_color_slot = slot_of(texture_make(scene, holes_make), 2, 0);
  glass.alpha_mode = ALPHA_BLEND;
  glass.base_color[3] = 0.4f;
  glass.double_sided = true;
  scene_add_quad(scene, scene_add_material(scene, fence), vec3(1.2, 0, 0.9), vec3(1.6, 0, -0.9), vec3(0, 1.4, 0));
  int material = scene_add_material(scene, glass);
  scene_add_quad(scene, material, vec3(-1.2, 0.1, 1.3), vec3(1.5, 0, 0.2), vec3(0, 1.1, 0.1));
  scene_add_quad(scene, material, vec3(-0.8, 0.1, 0.9), vec3(1.5, 0, 0.2), vec3(0, 1.3, 0.1));
}

// Balls: a mirror; glazed with vertex colours, in a mirrored and stretched object; unlit.
static void balls_add(Scene *scene)
{
  int mirror = scene_add_material(scene, material_plain(vec3(0.95, 0.9, 0.85), 1, 0));
  int glaze = scene_add_material(scene, material_plain(vec3(1, 1, 1), 0, 0.25));
  Material plain = material_plain(vec3(0.1, 0.5, 0.9), 0, 1);
  plain.unlit = true;
  scene_add_sphere(scene, mirror, vec3(0.4, 0.9, -1), 0.9, 16);
  uint32_t object = scene_add_sphere(scene, glaze, vec3(0, 0, 0), 0.6, 12);
  Primitive *primitive = &scene->meshes[scene->objects[object].mesh].primitives[0];
  primitive->colors = oracle_array(primitive->vertex_count, sizeof *primitive->colors);
  for (uint32_t i = 0; i < primitive->vertex_count; i++) {
    const float *n = primitive->normals[i];
    memcpy(primitive->colors[i], (float[4]){0.5f + 0.4f * n[0], 0.5f - 0.4f * n[1], 0.5f, 1}, sizeof(float[4]));
  }
  scene->objects[object].world_from_object = (Mat4){{-0.8, 0.2, 0, 0, 0, 1.4, 0, 0, 0, 0, 1, 0, 2.5, 0.9, -1.2, 1}};
  scene_add_sphere(scene, scene_add_material(scene, plain), vec3(-1.8, 0.3, 0.6), 0.3, 8);
}

// More than one launch takes.
static void lights_add(Scene *scene)
{
  Light fill = light_point(vec3(-3.5, 2.5, 2.5), 4);
  fill.range_m = 6;
  scene_add_light(scene, light_point(vec3(1.5, 3.2, 1), 9));
  scene_add_light(scene, fill);
  scene_add_light(scene, light_spot(vec3(3, 3.5, 2.5), vec3(1, 0.3, -1), 25, 0.2, 0.4));
  scene_add_light(scene, light_directional(vec3(0.4, -1, -0.7), 0.6));
  scene_add_light(scene, light_spot(vec3(-2, 3, 0), vec3(-2.5, 1, -2), 12, 0, 0.7));
  scene_add_light(scene, light_point(vec3(0, 0.6, 2.2), 0.8));
  for (uint32_t i = 0; i < scene->light_count; i++) {
    scene->lights[i].color[1] = 1 - 0.1f * (float)(i % 3);
    scene->lights[i].color[2] = 0.7f + 0.1f * (float)(i % 4);
  }
}

Scene scene_features(void)
{
  Scene scene = scene_empty();
  floor_add(&scene);
  wall_add(&scene);
  panel_add(&scene);
  fence_and_glass_add(&scene);
  balls_add(&scene);
  lights_add(&scene);
  return scene;
}

Camera scene_features_camera(void) { return camera_perspective(vec3(0.3, 2, 6.5), vec3(0, 1.1, -0.5), 0.75); }
