#include "scene/gltf_nodes.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "scene/gltf_accessors.h"
#include "scene/gltf_mesh.h"

// What the walk over the chosen scene's nodes carries.
typedef struct NodeWalk {
  Scene *scene;
  Gltf *gltf;
  Mat4 *worlds;  // [node_count]
  int *order;    // nodes of the scene, parents first, in the file's order
  uint32_t order_count;
  int *unposed_meshes;  // [mesh_count] index into scene->meshes of a mesh in its own pose, or NONE
  uint32_t object_capacity;
} NodeWalk;

static Status scene_choose(int *out, Gltf *gltf)
{
  const GltfModel *model = gltf->model;
  int chosen = gltf->options->scene;
  if (chosen != NONE && (chosen < 0 || (uint32_t)chosen >= model->scene_count))
    return gltf_fail(gltf, STATUS_USAGE, "name one of them", "has %u scenes, no scene %d", model->scene_count, chosen);
  if (chosen == NONE) chosen = model->default_scene;
  if (chosen == NONE && model->scene_count > 0) chosen = 0;
  if (chosen == NONE) log_warn(gltf->log, "%s: has no scene: nothing is drawn", gltf->path);
  *out = chosen;
  return STATUS_OK;
}

// Depth first, children in the file's order.
static Status order_find(NodeWalk *walk)
{
  Status status = STATUS_OK;
  const GltfModel *model = walk->gltf->model;
  int chosen = NONE, *stack = NULL;
  uint32_t top = 0;
  TRY(scene_choose(&chosen, walk->gltf));
  TRY(gltf_allocate(&walk->order, walk->gltf, model->node_count, sizeof *walk->order));
  TRY(gltf_allocate(&stack, walk->gltf, model->node_count, sizeof *stack));
  const GltfScene none = {0}, *scene = chosen == NONE ? &none : &model->scenes[chosen];
  for (uint32_t i = scene->root_count; i > 0; i--) stack[top++] = scene->roots[i - 1];
  while (top > 0) {
    const GltfNode *node = &model->nodes[stack[--top]];
    walk->order[walk->order_count++] = (int)(node - model->nodes);
    for (uint32_t k = node->child_count; k > 0; k--) stack[top++] = node->children[k - 1];
  }

done:
  free(stack);
  return status;
}

// Matrices from the bind pose to world space, one a joint; the transform of the skinned node itself does not count.
static Status joints_read(Mat4 **out, NodeWalk *walk, const GltfNode *node)
{
  const GltfSkin *skin = &walk->gltf->model->skins[node->skin];
  Status status = STATUS_OK;
  float(*inverse_binds)[16] = NULL;
  snprintf(walk->gltf->where, sizeof walk->gltf->where, "the skin of meshes[%d]", node->mesh);
  if (skin->inverse_bind != NONE) {
    if (walk->gltf->model->accessors[skin->inverse_bind].count < skin->joint_count)
      return gltf_fail(walk->gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "%s has fewer inverse bind matrices than joints",
                       walk->gltf->where);
    TRY(gltf_read_floats(&inverse_binds, walk->gltf, skin->inverse_bind, 16, 16, 0));
  }
  TRY(gltf_allocate(out, walk->gltf, skin->joint_count, sizeof **out));
  for (uint32_t i = 0; i < skin->joint_count; i++) {
    Mat4 joint_from_bind = mat4_identity();
    for (int e = 0; inverse_binds && e < 16; e++) joint_from_bind.m[e] = inverse_binds[i][e];
    (*out)[i] = mat4_mul(walk->worlds[skin->joints[i]], joint_from_bind);
  }

done:
  free(inverse_binds);
  return status;
}

// The scene's mesh for a node: shared by all nodes that draw it in its own pose, a mesh for itself else.
static Status node_mesh(int *out, NodeWalk *walk, const GltfNode *node)
{
  Status status = STATUS_OK;
  const GltfMesh *from = &walk->gltf->model->meshes[node->mesh];
  bool is_posed = node->skin != NONE || node->weights;
  GltfPose pose = {.weights = node->weights ? node->weights : from->weights,
                   .weight_count = node->weights ? node->weight_count : from->weight_count};
  Mat4 *joints = NULL;
  *out = walk->unposed_meshes[node->mesh];
  if (*out != NONE && !is_posed) return STATUS_OK;
  if (node->skin != NONE) {
    TRY(joints_read(&joints, walk, node));
    pose.world_from_bind = joints;
    pose.joint_count = walk->gltf->model->skins[node->skin].joint_count;
  }
  *out = (int)walk->scene->mesh_count++;
  if (!is_posed) walk->unposed_meshes[node->mesh] = *out;
  TRY(gltf_mesh_read(&walk->scene->meshes[*out], walk->gltf, node->mesh, &pose));

done:
  free(joints);
  return status;
}

static Status objects_reserve(NodeWalk *walk, uint32_t count)
{
  Status status = STATUS_OK;
  Scene *scene = walk->scene;
  Object *grown = NULL;
  uint64_t needed = (uint64_t)scene->object_count + count;
  if (needed <= walk->object_capacity) return STATUS_OK;
  if (needed < 2ull * walk->object_capacity) needed = 2ull * walk->object_capacity;
  if (needed > INT32_MAX)
    return gltf_fail(walk->gltf, STATUS_TOO_LARGE, "draw a smaller scene", "has too many objects");
  TRY(gltf_allocate(&grown, walk->gltf, needed, sizeof *grown));
  for (uint32_t i = 0; i < scene->object_count; i++) grown[i] = scene->objects[i];
  free(scene->objects);
  scene->objects = grown;
  walk->object_capacity = (uint32_t)needed;

done:
  return status;
}

static Status objects_add(NodeWalk *walk, int node_index)
{
  Status status = STATUS_OK;
  Gltf *gltf = walk->gltf;
  const GltfNode *node = &gltf->model->nodes[node_index];
  Mat4 *instances = NULL;
  uint32_t count = 1;
  int mesh = NONE;
  TRY(node_mesh(&mesh, walk, node));
  if (walk->scene->meshes[mesh].primitive_count == 0) goto done;
  if (node->skin == NONE) TRY(gltf_instances_read(&instances, &count, gltf, node));
  TRY(objects_reserve(walk, count));
  for (uint32_t i = 0; i < count; i++) {
    Object *object = &walk->scene->objects[walk->scene->object_count++];
    *object =
        (Object){.mesh = mesh, .world_from_object = node->skin == NONE ? walk->worlds[node_index] : mat4_identity()};
    if (instances) object->world_from_object = mat4_mul(object->world_from_object, instances[i]);
    TRY(gltf_copy_name(&object->name, gltf, node->name[0] ? node->name : gltf->model->meshes[node->mesh].name));
  }

done:
  free(instances);
  return status;
}

static Vec3 column(const Mat4 *m, int i) { return vec3(m->m[4 * i], m->m[4 * i + 1], m->m[4 * i + 2]); }

// World transform of a camera's or light's node, whose own scale does not count: turned back where that mirrors. (Its
// ancestors' mirroring stays: the scene around it is mirrored as well.)
static Mat4 world_unmirrored(const NodeWalk *walk, int node_index)
{
  const GltfNode *node = &walk->gltf->model->nodes[node_index];
  Mat4 world = walk->worlds[node_index];
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

static Status camera_add(NodeWalk *walk, int node_index)
{
  Gltf *gltf = walk->gltf;
  const GltfNode *node = &gltf->model->nodes[node_index];
  Camera camera = gltf->model->cameras[node->camera];
  const char *name = camera.name[0] ? camera.name : node->name;
  bool is_perspective = camera.kind == CAMERA_PERSPECTIVE;
  const char *flaw = is_perspective && !(camera.yfov_rad > 0 && camera.yfov_rad < M_PI) ? "yfov is not between 0 and pi"
                     : is_perspective && !(camera.znear_m > 0)                          ? "znear is not above 0"
                     : !is_perspective && !(camera.ymag_m > 0)                          ? "ymag is not above 0"
                     : !(camera.zfar_m > camera.znear_m)                                ? "zfar is not above znear"
                                                                                        : NULL;
  if (flaw) {
    log_warn(gltf->log, "%s: cameras[%d] '%.64s' is left out: %s", gltf->path, node->camera, name, flaw);
    return STATUS_OK;
  }
  Camera *out = &walk->scene->cameras[walk->scene->camera_count++];
  *out = camera;
  out->name = NULL;
  Mat4 world = world_unmirrored(walk, node_index);
  out->world_from_camera = without_scale(&world);
  return gltf_copy_name(&out->name, gltf, name);
}

static Status light_add(NodeWalk *walk, int node_index)
{
  Gltf *gltf = walk->gltf;
  const GltfNode *node = &gltf->model->nodes[node_index];
  Mat4 world = world_unmirrored(walk, node_index);
  Light light = gltf->model->lights[node->light];
  const char *name = light.name[0] ? light.name : node->name;
  if (!(light.intensity >= 0) || !isfinite(light.intensity))
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "the light '%.64s' has an intensity of %g", name,
                     (double)light.intensity);
  Vec3 position = column(&world, 3);
  double farthest = fmax(fmax(fabs(position.x), fabs(position.y)), fabs(position.z));
  if (light.kind != LIGHT_DIRECTIONAL && !(farthest <= (double)FLT_MAX)) {
    log_warn(gltf->log, "%s: the light '%.64s' is left out: it stands at infinity", gltf->path, name);
    return STATUS_OK;
  }
  light.outer_cone_rad = fmin(fmax(light.outer_cone_rad, 0), M_PI / 2);
  light.inner_cone_rad = fmin(fmax(light.inner_cone_rad, 0), light.outer_cone_rad);
  light.position_world = position;
  light.direction_world = vec3_unit_or(vec3_neg(column(&world, 2)), vec3(0, 0, -1));
  light.name = NULL;
  Light *out = &walk->scene->lights[walk->scene->light_count++];
  *out = light;
  return gltf_copy_name(&out->name, gltf, name);
}

// Room for what the nodes of the scene may add.
static Status scene_allocate(NodeWalk *walk)
{
  Status status = STATUS_OK;
  Gltf *gltf = walk->gltf;
  uint32_t meshes = 0, cameras = 0, lights = 0;
  for (uint32_t i = 0; i < walk->order_count; i++) {
    const GltfNode *node = &gltf->model->nodes[walk->order[i]];
    meshes += node->mesh != NONE;
    cameras += node->camera != NONE;
    lights += node->light != NONE;
  }
  TRY(gltf_allocate(&walk->scene->meshes, gltf, meshes, sizeof *walk->scene->meshes));
  TRY(gltf_allocate(&walk->scene->cameras, gltf, cameras, sizeof *walk->scene->cameras));
  TRY(gltf_allocate(&walk->scene->lights, gltf, lights, sizeof *walk->scene->lights));
  TRY(gltf_allocate(&walk->unposed_meshes, gltf, gltf->model->mesh_count, sizeof *walk->unposed_meshes));
  for (uint32_t i = 0; i < gltf->model->mesh_count; i++) walk->unposed_meshes[i] = NONE;

done:
  return status;
}

Status gltf_nodes_read(Scene *scene, Gltf *gltf)
{
  Status status = STATUS_OK;
  NodeWalk walk = {.scene = scene, .gltf = gltf};
  TRY(gltf_world_transforms(&walk.worlds, gltf));
  TRY(order_find(&walk));
  TRY(scene_allocate(&walk));
  for (uint32_t i = 0; i < walk.order_count; i++) {
    const GltfNode *node = &gltf->model->nodes[walk.order[i]];
    if (node->mesh != NONE) TRY(objects_add(&walk, walk.order[i]));
    if (node->camera != NONE) TRY(camera_add(&walk, walk.order[i]));
    if (node->light != NONE) TRY(light_add(&walk, walk.order[i]));
  }

done:
  free(walk.worlds);
  free(walk.order);
  free(walk.unposed_meshes);
  return status;
}
