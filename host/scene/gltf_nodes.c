#include "scene/gltf_nodes.h"

#include <math.h>
#include <stdlib.h>

// What the walk over the chosen scene's nodes carries.
typedef struct NodeWalk {
  Scene *scene;
  Gltf *gltf;
  GltfPlaces *places;
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

// The scene's mesh for a node: shared by all nodes that draw it in its own pose, a mesh for itself else.
static Status node_mesh(int *out, NodeWalk *walk, const GltfNode *node)
{
  Status status = STATUS_OK;
  bool is_posed = node->skin != NONE || node->weights;
  GltfPose pose;
  Mat4 *joints = NULL;
  *out = walk->unposed_meshes[node->mesh];
  if (*out != NONE && !is_posed) return STATUS_OK;
  TRY(gltf_node_pose(&pose, &joints, walk->gltf, node, walk->worlds));
  *out = (int)walk->scene->mesh_count++;
  walk->places->meshes[*out] = is_posed ? (int)(node - walk->gltf->model->nodes) : NONE;
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
  int *grown_nodes = NULL;
  uint64_t needed = (uint64_t)scene->object_count + count;
  if (needed <= walk->object_capacity) return STATUS_OK;
  if (needed < 2ull * walk->object_capacity) needed = 2ull * walk->object_capacity;
  if (needed > INT32_MAX)
    return gltf_fail(walk->gltf, STATUS_TOO_LARGE, "draw a smaller scene", "has too many objects");
  TRY(gltf_allocate(&grown_nodes, walk->gltf, needed, sizeof *grown_nodes));
  TRY(gltf_allocate(&grown, walk->gltf, needed, sizeof *grown));
  for (uint32_t i = 0; i < scene->object_count; i++) {
    grown[i] = scene->objects[i];
    grown_nodes[i] = walk->places->objects[i];
  }
  free(scene->objects);
  free(walk->places->objects);
  scene->objects = grown;
  walk->places->objects = grown_nodes;
  walk->object_capacity = (uint32_t)needed;
  grown_nodes = NULL;

done:
  free(grown_nodes);
  return status;
}

static Status objects_add(NodeWalk *walk, int node_index)
{
  Status status = STATUS_OK;
  Gltf *gltf = walk->gltf;
  const GltfNode *node = &gltf->model->nodes[node_index];
  uint32_t count = node->skin == NONE ? gltf_instance_count(gltf, node) : 1;
  int mesh = NONE;
  TRY(node_mesh(&mesh, walk, node));
  if (walk->scene->meshes[mesh].primitive_count == 0) return STATUS_OK;
  TRY(objects_reserve(walk, count));
  for (uint32_t i = 0; i < count; i++) {
    Object *object = &walk->scene->objects[walk->scene->object_count];
    object->mesh = mesh;
    walk->places->objects[walk->scene->object_count++] = node_index;
    TRY(gltf_copy_name(&object->name, gltf, node->name[0] ? node->name : gltf->model->meshes[node->mesh].name));
  }

done:
  return status;
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
  walk->places->cameras[walk->scene->camera_count] = node_index;
  Camera *out = &walk->scene->cameras[walk->scene->camera_count++];
  *out = camera;
  out->name = NULL;
  return gltf_copy_name(&out->name, gltf, name);
}

static Status light_add(NodeWalk *walk, int node_index)
{
  Gltf *gltf = walk->gltf;
  const GltfNode *node = &gltf->model->nodes[node_index];
  Light light = gltf->model->lights[node->light];
  const char *name = light.name[0] ? light.name : node->name;
  if (!(light.intensity >= 0) || !isfinite(light.intensity))
    return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "the light '%.64s' has an intensity of %g", name,
                     (double)light.intensity);
  if (!gltf_light_has_place(&light, &walk->worlds[node_index])) {
    log_warn(gltf->log, "%s: the light '%.64s' is left out: it stands at infinity", gltf->path, name);
    return STATUS_OK;
  }
  light.outer_cone_rad = fmin(fmax(light.outer_cone_rad, 0), M_PI / 2);
  light.inner_cone_rad = fmin(fmax(light.inner_cone_rad, 0), light.outer_cone_rad);
  light.name = NULL;
  walk->places->lights[walk->places->light_count++] = node_index;
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
  TRY(gltf_allocate(&walk->places->meshes, gltf, meshes, sizeof *walk->places->meshes));
  TRY(gltf_allocate(&walk->places->cameras, gltf, cameras, sizeof *walk->places->cameras));
  TRY(gltf_allocate(&walk->places->lights, gltf, lights, sizeof *walk->places->lights));
  TRY(gltf_allocate(&walk->unposed_meshes, gltf, gltf->model->mesh_count, sizeof *walk->unposed_meshes));
  for (uint32_t i = 0; i < gltf->model->mesh_count; i++) walk->unposed_meshes[i] = NONE;

done:
  return status;
}

Status gltf_nodes_read(Scene *scene, GltfPlaces *places, Gltf *gltf)
{
  Status status = STATUS_OK;
  NodeWalk walk = {.scene = scene, .gltf = gltf, .places = places};
  TRY(gltf_world_transforms(&walk.worlds, gltf));
  TRY(order_find(&walk));
  TRY(scene_allocate(&walk));
  for (uint32_t i = 0; i < walk.order_count; i++) {
    const GltfNode *node = &gltf->model->nodes[walk.order[i]];
    if (node->mesh != NONE) TRY(objects_add(&walk, walk.order[i]));
    if (node->camera != NONE) TRY(camera_add(&walk, walk.order[i]));
    if (node->light != NONE) TRY(light_add(&walk, walk.order[i]));
  }
  TRY(gltf_places_apply(scene, gltf, places, walk.worlds));
  if (gltf->options->changes) TRY(scene_file_change(scene, gltf->options->changes, gltf->log));

done:
  free(walk.worlds);
  free(walk.order);
  free(walk.unposed_meshes);
  return status;
}
