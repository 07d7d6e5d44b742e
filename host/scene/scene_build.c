#include "scene/scene_build.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const Vec3 up_world = {0, 1, 0};

// `array`, or a larger copy of it with room for one element more; NULL where there is no memory, and the old one stays.
static void *array_grown(Scene *scene, void **array, size_t count, size_t element_bytes)
{
  void *larger = realloc(*array, (count + 1) * element_bytes);
  if (!larger) {
    scene->incomplete = true;
    return NULL;
  }
  memset((char *)larger + count * element_bytes, 0, element_bytes);
  return *array = larger;
}

#define GROW(scene, array, count) array_grown(scene, (void **)&(scene)->array, (scene)->count, sizeof *(scene)->array)

// Zeroed.
static void *array_make(Scene *scene, size_t count, size_t element_bytes)
{
  void *array = calloc(count ? count : 1, element_bytes);
  if (!array) scene->incomplete = true;
  return array;
}

static char *name_of(Scene *scene, const char *what, uint32_t index)
{
  char name[64];
  snprintf(name, sizeof name, "%s %u", what, index);
  char *copy = strdup(name);
  if (!copy) scene->incomplete = true;
  return copy;
}

Scene scene_empty(void)
{
  Scene scene = {.environment = {.kind = ENVIRONMENT_CONSTANT, .intensity = 1}};
  scene.path = name_of(&scene, "made scene", 0);
  return scene;
}

void scene_set_constant(Scene *scene, double red, double green, double blue)
{
  scene->environment =
      (Environment){.kind = ENVIRONMENT_CONSTANT, .constant = {(float)red, (float)green, (float)blue}, .intensity = 1};
}

void scene_set_image(Scene *scene, uint32_t width, uint32_t height, const float (*colors)[3])
{
  Image *image = &scene->environment.image;
  size_t count = (size_t)width * height;
  scene->environment.kind = ENVIRONMENT_IMAGE;
  float *pixels = array_make(scene, count, 4 * sizeof *pixels);
  if (!pixels) return;
  *image = (Image){.width = width, .height = height, .pixels = pixels};
  for (size_t i = 0; i < count; i++) {
    memcpy(image->pixels + 4 * i, colors[i], sizeof colors[i]);
    image->pixels[4 * i + 3] = 1;
  }
}

Material material_plain(Vec3 base, double metallic, double roughness)
{
  Material material = {
      .base_color = {(float)base.x, (float)base.y, (float)base.z, 1},
      .metallic = (float)metallic,
      .roughness = (float)roughness,
      .alpha_cutoff = 0.5f,
      .normal_scale = 1,
      .occlusion_strength = 1,
  };
  TextureSlot *slots[] = {&material.base_color_slot, &material.metallic_roughness_slot, &material.emission_slot,
                          &material.normal_slot, &material.occlusion_slot};
  for (size_t i = 0; i < sizeof slots / sizeof *slots; i++)
    *slots[i] = (TextureSlot){.texture = NONE, .uv_from_uv = {1, 0, 0, 0, 1, 0}};
  return material;
}

Material material_glowing(Vec3 emission)
{
  Material material = material_plain(vec3(0, 0, 0), 1, 1);
  material.emission[0] = (float)emission.x;
  material.emission[1] = (float)emission.y;
  material.emission[2] = (float)emission.z;
  return material;
}

int scene_add_material(Scene *scene, Material material)
{
  if (!GROW(scene, materials, material_count)) return 0;
  material.name = name_of(scene, "material", scene->material_count);
  scene->materials[scene->material_count] = material;
  return (int)scene->material_count++;
}

int scene_add_texture(Scene *scene, uint32_t width, uint32_t height, const uint8_t (*texels)[4])
{
  size_t count = (size_t)width * height;
  if (!GROW(scene, images, image_count) || !GROW(scene, textures, texture_count)) return NONE;
  Image *image = &scene->images[scene->image_count];
  *image = (Image){.width = width, .height = height, .texels = array_make(scene, count, 4)};
  if (!image->texels) return NONE;
  memcpy(image->texels, texels, 4 * count);
  scene->textures[scene->texture_count] = (Texture){.image = (int)scene->image_count++};
  return (int)scene->texture_count++;
}

// One mesh of one primitive with room for its arrays, drawn by one object; NULL where there is no memory.
static Primitive *shape_add(Scene *scene, int material, uint32_t vertex_count, uint32_t triangle_count, bool has_uvs)
{
  Primitive *primitive = array_make(scene, 1, sizeof *primitive);
  if (!primitive) return NULL;
  *primitive = (Primitive){.vertex_count = vertex_count, .triangle_count = triangle_count, .material = material};
  primitive->positions = array_make(scene, vertex_count, sizeof *primitive->positions);
  primitive->normals = array_make(scene, vertex_count, sizeof *primitive->normals);
  primitive->triangles = array_make(scene, triangle_count, sizeof *primitive->triangles);
  if (has_uvs) primitive->uvs[0] = array_make(scene, vertex_count, sizeof *primitive->uvs[0]);
  char *names[] = {name_of(scene, "mesh", scene->mesh_count), name_of(scene, "object", scene->object_count)};
  if (scene->incomplete || !GROW(scene, meshes, mesh_count) || !GROW(scene, objects, object_count)) {
    primitive_free(primitive);
    free(primitive);
    free(names[0]);
    free(names[1]);
    return NULL;
  }
  scene->meshes[scene->mesh_count] = (Mesh){.name = names[0], .primitives = primitive, .primitive_count = 1};
  scene->objects[scene->object_count++] =
      (Object){.name = names[1], .mesh = (int)scene->mesh_count++, .world_from_object = mat4_identity()};
  return primitive;
}

static void floats_set(float out[3], Vec3 v)
{
  out[0] = (float)v.x;
  out[1] = (float)v.y;
  out[2] = (float)v.z;
}

static void triangle_set(Primitive *primitive, uint32_t at, uint32_t a, uint32_t b, uint32_t c)
{
  const uint32_t corners[3] = {a, b, c};
  memcpy(primitive->triangles[at], corners, sizeof corners);
}

uint32_t scene_add_triangle(Scene *scene, int material, const Vec3 corners[3], const Vec3 normals[3])
{
  Primitive *primitive = shape_add(scene, material, 3, 1, false);
  if (!primitive) return 0;
  for (int i = 0; i < 3; i++) {
    floats_set(primitive->positions[i], corners[i]);
    floats_set(primitive->normals[i], vec3_unit_or(normals[i], up_world));
  }
  triangle_set(primitive, 0, 0, 1, 2);
  return scene->object_count - 1;
}

// Face `face` of a shape made of quads.
static void quad_set(Primitive *primitive, uint32_t face, Vec3 corner, Vec3 u, Vec3 v)
{
  static const float uvs[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  const Vec3 corners[4] = {corner, vec3_add(corner, u), vec3_add(vec3_add(corner, u), v), vec3_add(corner, v)};
  Vec3 normal = vec3_unit_or(vec3_cross(u, v), up_world);
  for (int i = 0; i < 4; i++) {
    floats_set(primitive->positions[4 * face + i], corners[i]);
    floats_set(primitive->normals[4 * face + i], normal);
    memcpy(primitive->uvs[0][4 * face + i], uvs[i], sizeof uvs[i]);
  }
  triangle_set(primitive, 2 * face, 4 * face, 4 * face + 1, 4 * face + 2);
  triangle_set(primitive, 2 * face + 1, 4 * face, 4 * face + 2, 4 * face + 3);
}

uint32_t scene_add_quad(Scene *scene, int material, Vec3 corner, Vec3 u, Vec3 v)
{
  Primitive *primitive = shape_add(scene, material, 4, 2, true);
  if (!primitive) return 0;
  quad_set(primitive, 0, corner, u, v);
  return scene->object_count - 1;
}

uint32_t scene_add_box(Scene *scene, int material, Vec3 low, Vec3 high)
{
  Primitive *primitive = shape_add(scene, material, 4 * 6, 2 * 6, true);
  if (!primitive) return 0;
  Vec3 size = vec3_sub(high, low);
  const Vec3 edges[3] = {vec3(size.x, 0, 0), vec3(0, size.y, 0), vec3(0, 0, size.z)};
  for (int axis = 0; axis < 3; axis++) {
    Vec3 u = edges[(axis + 1) % 3], v = edges[(axis + 2) % 3];
    quad_set(primitive, 2 * axis, low, v, u);
    quad_set(primitive, 2 * axis + 1, vec3_add(low, edges[axis]), u, v);
  }
  return scene->object_count - 1;
}

uint32_t scene_add_sphere(Scene *scene, int material, Vec3 center, double radius, int rings)
{
  const int columns = 2 * rings;
  Primitive *primitive = shape_add(scene, material, (rings + 1) * columns, 2 * columns * (rings - 1), false);
  if (!primitive) return 0;
  for (int ring = 0; ring <= rings; ring++) {
    for (int column = 0; column < columns; column++) {
      double theta = M_PI * ring / rings, phi = 2 * M_PI * column / columns;
      double sine = ring < rings ? sin(theta) : 0;  // else there is a hole of 1e-16 at the pole
      Vec3 normal = vec3(sine * cos(phi), cos(theta), -sine * sin(phi));
      floats_set(primitive->positions[ring * columns + column], vec3_add(center, vec3_scale(normal, radius)));
      floats_set(primitive->normals[ring * columns + column], normal);
    }
  }
  uint32_t at = 0;
  for (int ring = 0; ring < rings; ring++) {
    for (int column = 0; column < columns; column++) {
      uint32_t a = ring * columns + column, b = a + columns;
      uint32_t right_a = ring * columns + (column + 1) % columns, right_b = right_a + columns;
      if (ring < rings - 1) triangle_set(primitive, at++, a, b, right_b);
      if (ring > 0) triangle_set(primitive, at++, a, right_b, right_a);
    }
  }
  return scene->object_count - 1;
}

void scene_join_last(Scene *scene)
{
  if (scene->incomplete || scene->object_count < 2) return;
  Mesh *mesh = &scene->meshes[scene->mesh_count - 2], *last = mesh + 1;
  size_t all = (size_t)mesh->primitive_count + last->primitive_count;
  Primitive *primitives = realloc(mesh->primitives, all * sizeof *primitives);
  if (!primitives) {
    scene->incomplete = true;
    return;
  }
  memcpy(primitives + mesh->primitive_count, last->primitives, last->primitive_count * sizeof *primitives);
  mesh->primitives = primitives;
  mesh->primitive_count = (uint32_t)all;
  free(last->primitives);
  free(last->name);
  free(scene->objects[--scene->object_count].name);
  scene->mesh_count--;
}

Light light_point(Vec3 position, double intensity_cd)
{
  return (Light){.kind = LIGHT_POINT,
                 .color = {1, 1, 1},
                 .intensity = (float)intensity_cd,
                 .range_m = INFINITY,
                 .position_world = position,
                 .direction_world = vec3(0, 0, -1)};
}

Light light_spot(Vec3 position, Vec3 towards, double intensity_cd, double inner_rad, double outer_rad)
{
  Light light = light_point(position, intensity_cd);
  light.kind = LIGHT_SPOT;
  light.direction_world = vec3_unit_or(vec3_sub(towards, position), light.direction_world);
  light.inner_cone_rad = inner_rad;
  light.outer_cone_rad = outer_rad;
  return light;
}

Light light_directional(Vec3 direction, double intensity_lux)
{
  Light light = light_point(vec3(0, 0, 0), intensity_lux);
  light.kind = LIGHT_DIRECTIONAL;
  light.direction_world = vec3_unit_or(direction, light.direction_world);
  return light;
}

void scene_add_light(Scene *scene, Light light)
{
  if (!GROW(scene, lights, light_count)) return;
  light.name = name_of(scene, "light", scene->light_count);
  scene->lights[scene->light_count++] = light;
}

static Camera camera_looking(CameraKind kind, Vec3 eye, Vec3 target)
{
  Vec3 back = vec3_unit_or(vec3_sub(eye, target), vec3(0, 0, 1));
  Vec3 upright = fabs(back.y) > 0.999 ? vec3(0, 0, -1) : up_world;
  Vec3 right = vec3_unit_or(vec3_cross(upright, back), vec3(1, 0, 0)), up = vec3_cross(back, right);
  return (Camera){
      .kind = kind,
      .znear_m = 1e-3,
      .zfar_m = INFINITY,
      .world_from_camera = {{right.x, right.y, right.z, 0, up.x, up.y, up.z, 0, back.x, back.y, back.z, 0, eye.x, eye.y,
                             eye.z, 1}},
  };
}

Camera camera_perspective(Vec3 eye, Vec3 target, double yfov_rad)
{
  Camera camera = camera_looking(CAMERA_PERSPECTIVE, eye, target);
  camera.yfov_rad = yfov_rad;
  return camera;
}

Camera camera_orthographic(Vec3 eye, Vec3 target, double ymag_m)
{
  Camera camera = camera_looking(CAMERA_ORTHOGRAPHIC, eye, target);
  camera.ymag_m = ymag_m;
  return camera;
}

Status scene_check_complete(const Scene *scene, Log *log)
{
  return scene->incomplete ? log_no_memory(log, "scene") : STATUS_OK;
}
