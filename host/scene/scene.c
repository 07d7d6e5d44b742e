#include "scene/scene.h"

#include <stdlib.h>

void primitive_free(Primitive *primitive)
{
  free(primitive->positions);
  free(primitive->normals);
  free(primitive->tangents);
  free(primitive->uvs[0]);
  free(primitive->uvs[1]);
  free(primitive->colors);
  free(primitive->triangles);
  *primitive = (Primitive){0};
}

static void mesh_free(Mesh *mesh)
{
  for (uint32_t i = 0; i < mesh->primitive_count; i++) primitive_free(&mesh->primitives[i]);
  free(mesh->primitives);
  free(mesh->name);
}

Material material_default(void)
{
  TextureSlot none = {.texture = NONE, .uv_from_uv = {1, 0, 0, 0, 1, 0}};
  return (Material){
      .name = "default",
      .base_color = {1, 1, 1, 1},
      .metallic = 1,
      .roughness = 1,
      .alpha_cutoff = 0.5f,
      .normal_scale = 1,
      .occlusion_strength = 1,
      .base_color_slot = none,
      .metallic_roughness_slot = none,
      .emission_slot = none,
      .normal_slot = none,
      .occlusion_slot = none,
  };
}

void scene_free(Scene *scene)
{
  for (uint32_t i = 0; i < scene->image_count; i++) image_free(&scene->images[i]);
  for (uint32_t i = 0; i < scene->material_count; i++) free(scene->materials[i].name);
  for (uint32_t i = 0; i < scene->mesh_count; i++) mesh_free(&scene->meshes[i]);
  for (uint32_t i = 0; i < scene->object_count; i++) free(scene->objects[i].name);
  for (uint32_t i = 0; i < scene->camera_count; i++) free(scene->cameras[i].name);
  for (uint32_t i = 0; i < scene->light_count; i++) free(scene->lights[i].name);
  image_free(&scene->environment.image);
  free(scene->path);
  free(scene->images);
  free(scene->textures);
  free(scene->materials);
  free(scene->meshes);
  free(scene->objects);
  free(scene->cameras);
  free(scene->lights);
  *scene = (Scene){0};
}

uint64_t scene_triangle_count(const Scene *scene)
{
  uint64_t count = 0;
  for (uint32_t o = 0; o < scene->object_count; o++) count += scene_object_triangles(scene, o);
  return count;
}

uint32_t scene_object_triangles(const Scene *scene, uint32_t object)
{
  const Mesh *mesh = &scene->meshes[scene->objects[object].mesh];
  uint64_t count = 0;
  for (uint32_t p = 0; p < mesh->primitive_count; p++) count += mesh->primitives[p].triangle_count;
  return count > UINT32_MAX ? UINT32_MAX : (uint32_t)count;
}

// Widens the box by the triangles of a primitive; vertices that no triangle uses do not count.
static void box_add(Vec3 *low, Vec3 *high, const Primitive *primitive, const Mat4 *world_from_object)
{
  for (uint32_t i = 0; i < primitive->triangle_count; i++)
    for (int corner = 0; corner < 3; corner++) {
      const float *position = primitive->positions[primitive->triangles[i][corner]];
      Vec3 world = mat4_point(world_from_object, vec3_from_floats(position));
      *low = vec3_min(*low, world);
      *high = vec3_max(*high, world);
    }
}

bool scene_object_bounds(const Scene *scene, uint32_t object, Vec3 *low_world, Vec3 *high_world)
{
  Vec3 low = vec3(INFINITY, INFINITY, INFINITY), high = vec3_neg(low);
  const Mesh *mesh = &scene->meshes[scene->objects[object].mesh];
  for (uint32_t p = 0; p < mesh->primitive_count; p++)
    box_add(&low, &high, &mesh->primitives[p], &scene->objects[object].world_from_object);
  if (!(low.x <= high.x)) return false;
  *low_world = low;
  *high_world = high;
  return true;
}

bool scene_bounds(const Scene *scene, Vec3 *low_world, Vec3 *high_world)
{
  Vec3 low = vec3(INFINITY, INFINITY, INFINITY), high = vec3_neg(low);
  for (uint32_t o = 0; o < scene->object_count; o++) {
    Vec3 object_low, object_high;
    if (!scene_object_bounds(scene, o, &object_low, &object_high)) continue;
    low = vec3_min(low, object_low);
    high = vec3_max(high, object_high);
  }
  if (!(low.x <= high.x)) return false;
  *low_world = low;
  *high_world = high;
  return true;
}
