#include "scene/gltf_places.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>

#include "scene/gltf_accessors.h"
#include "scene/gltf_nodes.h"

// Matrices from the bind pose to world space, one a joint.
static Status joints_read(Mat4 **out, Gltf *gltf, const GltfNode *node, const Mat4 *worlds)
{
  const GltfSkin *skin = &gltf->model->skins[node->skin];
  Status status = STATUS_OK;
  float(*inverse_binds)[16] = NULL;
  snprintf(gltf->where, sizeof gltf->where, "the skin of meshes[%d]", node->mesh);
  if (skin->inverse_bind != NONE) {
    if (gltf->model->accessors[skin->inverse_bind].count < skin->joint_count)
      return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s has fewer inverse bind matrices than joints",
                       gltf->where);
    TRY(gltf_read_floats(&inverse_binds, gltf, skin->inverse_bind, 16, 16, 0));
  }
  TRY(gltf_allocate(out, gltf, skin->joint_count, sizeof **out));
  for (uint32_t i = 0; i < skin->joint_count; i++) {
    Mat4 joint_from_bind = mat4_identity();
    for (int e = 0; inverse_binds && e < 16; e++) joint_from_bind.m[e] = inverse_binds[i][e];
    (*out)[i] = mat4_mul(worlds[skin->joints[i]], joint_from_bind);
  }

done:
  free(inverse_binds);
  return status;
}

Status gltf_node_pose(GltfPose *out, Mat4 **joints, Gltf *gltf, const GltfNode *node, const Mat4 *worlds)
{
  const GltfMesh *mesh = &gltf->model->meshes[node->mesh];
  Status status = STATUS_OK;
  *out = (GltfPose){.weights = node->weights ? node->weights : mesh->weights,
                    .weight_count = node->weights ? node->weight_count : mesh->weight_count};
  if (node->skin == NONE) return STATUS_OK;
  TRY(joints_read(joints, gltf, node, worlds));
  out->world_from_bind = *joints;
  out->joint_count = gltf->model->skins[node->skin].joint_count;

done:
  return status;
}

static Vec3 column(const Mat4 *m, int i) { return vec3(m->m[4 * i], m->m[4 * i + 1], m->m[4 * i + 2]); }

// World transform of a camera's or light's node, whose own scale does not count: turned back where that mirrors. (Its
// ancestors' mirroring stays: the scene around it is mirrored as well.)
static Mat4 world_unmirrored(const GltfNode *node, Mat4 world)
{
  for (int i = 0; i < 12 && !node->matrix; i++)
    if (node->scale[i / 4] < 0) world.m[i] = -world.m[i];
  return world;
}

// Rotation and translation alone: z keeps its direction, y as near to its own as is upright to it, x follows.
static Mat4 without_scale(const Mat4 *m)
{
  Vec3 z = vec3_unit_or(column(m, 2), vec3(0, 0, 1)), y = column(m, 1);
  Vec3 x = vec3_cross(y, z);
  if (vec3_length(x) == 0) x = fabs(z.y) < 0.9 ? vec3_cross(vec3(0, 1, 0), z) : vec3_cross(vec3(1, 0, 0), z);
  x = vec3_unit_or(x, vec3(1, 0, 0));
  y = vec3_cross(z, x);
  return (Mat4){{x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, m->m[12], m->m[13], m->m[14], 1}};
}

bool gltf_light_has_place(const Light *light, const Mat4 *world)
{
  Vec3 position = column(world, 3);
  double farthest = fmax(fmax(fabs(position.x), fabs(position.y)), fabs(position.z));
  return light->kind == LIGHT_DIRECTIONAL || farthest <= (double)FLT_MAX;
}

// The objects of one node, one an instance.
static Status objects_place(Object *objects, Gltf *gltf, const GltfNode *node, const Mat4 *world)
{
  Status status = STATUS_OK;
  Mat4 *instances = NULL;
  uint32_t count = node->skin == NONE ? gltf_instance_count(gltf, node) : 1;
  if (node->skin == NONE) TRY(gltf_instances_read(&instances, gltf, node));
  for (uint32_t i = 0; i < count; i++)
    objects[i].world_from_object = node->skin != NONE ? mat4_identity()
                                   : instances        ? mat4_mul(*world, instances[i])
                                                      : *world;

done:
  free(instances);
  return status;
}

static Status light_place(Light *light, Gltf *gltf, const GltfNode *node, const Mat4 *node_world)
{
  Mat4 world = world_unmirrored(node, *node_world);
  if (!gltf_light_has_place(light, node_world))
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "the light '%.64s' goes to infinity", light->name);
  light->position_world = column(&world, 3);
  light->direction_world = vec3_unit_or(vec3_neg(column(&world, 2)), vec3(0, 0, -1));
  return STATUS_OK;
}

Status gltf_places_apply(Scene *scene, Gltf *gltf, const GltfPlaces *places, const Mat4 *worlds)
{
  Status status = STATUS_OK;
  const GltfNode *nodes = gltf->model->nodes;
  for (uint32_t i = 0; i < scene->object_count; i++) {
    int node = places->objects[i];
    if (i == 0 || node != places->objects[i - 1])
      TRY(objects_place(&scene->objects[i], gltf, &nodes[node], &worlds[node]));
  }
  for (uint32_t i = 0; i < scene->camera_count; i++) {
    Mat4 world = world_unmirrored(&nodes[places->cameras[i]], worlds[places->cameras[i]]);
    scene->cameras[i].world_from_camera = without_scale(&world);
  }
  for (uint32_t i = 0; i < places->light_count; i++)
    TRY(light_place(&scene->lights[i], gltf, &nodes[places->lights[i]], &worlds[places->lights[i]]));

done:
  return status;
}

void gltf_places_free(GltfPlaces *places)
{
  free(places->objects);
  free(places->cameras);
  free(places->lights);
  free(places->meshes);
  *places = (GltfPlaces){0};
}
