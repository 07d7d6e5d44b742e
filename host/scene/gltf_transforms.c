#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/gltf_accessors.h"
#include "scene/gltf_nodes.h"

static Mat4 parent_from_node(const GltfNode *node)
{
  Mat4 matrix;
  if (!node->matrix)
    return mat4_from_trs(vec3(node->translation[0], node->translation[1], node->translation[2]), node->rotation,
                         vec3(node->scale[0], node->scale[1], node->scale[2]));
  memcpy(matrix.m, node->matrix, sizeof matrix.m);
  return matrix;
}

static bool mat4_is_finite(const Mat4 *m)
{
  for (int i = 0; i < 16; i++)
    if (!isfinite(m->m[i])) return false;
  return true;
}

static Status transform_check(Gltf *gltf, const Mat4 *world, int node)
{
  if (mat4_is_finite(world)) return STATUS_OK;
  return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "nodes[%d] '%.64s' has a transform that is not finite",
                   node, gltf->model->nodes[node].name);
}

Status gltf_world_transforms(Mat4 **out, Gltf *gltf)
{
  Status status = STATUS_OK;
  const GltfModel *model = gltf->model;
  Mat4 *worlds = NULL;
  bool *is_child = NULL;
  int *stack = NULL;
  TRY(gltf_allocate(&worlds, gltf, model->node_count, sizeof *worlds));
  TRY(gltf_allocate(&is_child, gltf, model->node_count, sizeof *is_child));
  TRY(gltf_allocate(&stack, gltf, model->node_count, sizeof *stack));
  for (uint32_t i = 0; i < model->node_count; i++)
    for (uint32_t k = 0; k < model->nodes[i].child_count; k++) is_child[model->nodes[i].children[k]] = true;
  uint32_t top = 0;
  for (uint32_t i = 0; i < model->node_count; i++) {
    if (is_child[i]) continue;
    worlds[i] = parent_from_node(&model->nodes[i]);
    stack[top++] = (int)i;
  }
  while (top > 0) {
    int at = stack[--top];
    TRY(transform_check(gltf, &worlds[at], at));
    for (uint32_t k = 0; k < model->nodes[at].child_count; k++) {
      int child = model->nodes[at].children[k];
      worlds[child] = mat4_mul(worlds[at], parent_from_node(&model->nodes[child]));
      stack[top++] = child;
    }
  }
  *out = worlds;
  worlds = NULL;

done:
  free(worlds);
  free(is_child);
  free(stack);
  return status;
}

uint32_t gltf_instance_count(const Gltf *gltf, const GltfNode *node)
{
  const int accessors[] = {node->instance_translation, node->instance_rotation, node->instance_scale};
  uint64_t count = 1;
  for (int i = 0; i < 3 && node->is_instanced; i++)
    if (accessors[i] != NONE) count = gltf->model->accessors[accessors[i]].count;
  return (uint32_t)count;
}

Status gltf_instances_read(Mat4 **out, Gltf *gltf, const GltfNode *node)
{
  Status status = STATUS_OK;
  float(*translations)[3] = NULL, (*rotations)[4] = NULL, (*scales)[3] = NULL;
  const int accessors[] = {node->instance_translation, node->instance_rotation, node->instance_scale};
  uint64_t n = gltf_instance_count(gltf, node);
  *out = NULL;
  if (!node->is_instanced) return STATUS_OK;
  snprintf(gltf->where, sizeof gltf->where, "EXT_mesh_gpu_instancing of the node '%.64s'", node->name);
  if (accessors[0] != NONE) TRY(gltf_read_floats(&translations, gltf, accessors[0], 3, 3, n));
  if (accessors[1] != NONE) TRY(gltf_read_floats(&rotations, gltf, accessors[1], 4, 4, n));
  if (accessors[2] != NONE) TRY(gltf_read_floats(&scales, gltf, accessors[2], 3, 3, n));
  TRY(gltf_allocate(out, gltf, n, sizeof **out));
  for (uint64_t i = 0; i < n; i++) {
    double rotation[4] = {0, 0, 0, 1};
    for (int c = 0; rotations && c < 4; c++) rotation[c] = rotations[i][c];
    (*out)[i] = mat4_from_trs(translations ? vec3_from_floats(translations[i]) : vec3(0, 0, 0), rotation,
                              scales ? vec3_from_floats(scales[i]) : vec3(1, 1, 1));
  }

done:
  gltf->where[0] = 0;
  free(translations);
  free(rotations);
  free(scales);
  return status;
}
