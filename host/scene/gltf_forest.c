#include <stdlib.h>

#include "scene/gltf_guard.h"
#include "scene/gltf_json.h"

static Status parents_find(int *parents, Gltf *gltf, const json_t *nodes)
{
  size_t i, k;
  json_t *node, *child;
  for (i = 0; i < json_array_size(nodes); i++) parents[i] = NONE;
  json_array_foreach(nodes, i, node)
  {
    json_array_foreach(json_object_get(node, "children"), k, child)
    {
      json_int_t c = json_integer_value(child);
      if (parents[c] != NONE)
        return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR,
                         "nodes[%lld] is a child twice, of nodes[%d] and nodes[%zu]", (long long)c, parents[c], i);
      parents[c] = (int)i;
    }
  }
  return STATUS_OK;
}

// Walks up from each node and marks what it meets with the walk's number: a walk that meets its own mark went round.
static Status cycle_check(Gltf *gltf, const int *parents, uint32_t *walks, size_t count)
{
  for (size_t i = 0; i < count; i++) {
    uint32_t walk = (uint32_t)i + 1;
    int at = (int)i;
    for (; at != NONE && walks[at] == 0; at = parents[at]) walks[at] = walk;
    if (at != NONE && walks[at] == walk)
      return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "nodes[%d] is its own ancestor", at);
  }
  return STATUS_OK;
}

static Status roots_check(Gltf *gltf, const int *parents, uint32_t *listed)
{
  size_t i, k;
  json_t *scene, *root;
  json_array_foreach(json_object_get(gltf->document, "scenes"), i, scene)
  {
    json_array_foreach(json_object_get(scene, "nodes"), k, root)
    {
      json_int_t node = json_integer_value(root);
      if (parents[node] != NONE)
        return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR,
                         "scenes[%zu].nodes[%zu] is a child of nodes[%d], not a root", i, k, parents[node]);
      if (listed[node] == i + 1)
        return gltf_fail(gltf, STATUS_BAD_SCENE, GLTF_HINT_REPAIR, "scenes[%zu] lists nodes[%lld] twice", i,
                         (long long)node);
      listed[node] = (uint32_t)i + 1;
    }
  }
  return STATUS_OK;
}

Status gltf_check_forest(Gltf *gltf)
{
  Status status = STATUS_OK;
  const json_t *nodes = json_object_get(gltf->document, "nodes");
  size_t count = json_array_size(nodes);
  int *parents = NULL;
  uint32_t *walks = NULL, *listed = NULL;
  TRY(gltf_allocate(&parents, gltf, count, sizeof *parents));
  TRY(gltf_allocate(&walks, gltf, count, sizeof *walks));
  TRY(gltf_allocate(&listed, gltf, count, sizeof *listed));
  TRY(parents_find(parents, gltf, nodes));
  TRY(cycle_check(gltf, parents, walks, count));
  TRY(roots_check(gltf, parents, listed));

done:
  free(parents);
  free(walks);
  free(listed);
  return status;
}
