// What the surface-area heuristic counts of a tree.
#pragma once

#include <math.h>

#include "shared/bvh.h"

// Half the surface area of a box; -infinity to infinity for an empty one.
static inline double bvh_half_area(const float bounds[3][2])
{
  double size[3];
  for (int axis = 0; axis < 3; axis++) size[axis] = (double)bounds[axis][1] - bounds[axis][0];
  return size[0] * (size[1] + size[2]) + size[1] * size[2];
}

// Of the root's box.
static inline double bvh2_root_area(const Bvh2Node *root)
{
  float whole[3][2];
  for (int axis = 0; axis < 3; axis++) {
    const float *a = root->bounds[0][axis], *b = root->bounds[1][axis];
    whole[axis][0] = a[0] < b[0] ? a[0] : b[0];
    whole[axis][1] = a[1] > b[1] ? a[1] : b[1];
  }
  return bvh_half_area(whole);
}

// Half areas of the boxes of a node's two children, times what each costs a ray that meets it, in triangle tests.
static inline double bvh2_node_cost(const Bvh2Node *node, double traversal_cost)
{
  double sum = 0;
  for (int side = 0; side < 2; side++)
    if (node->child[side] != BVH_EMPTY)
      sum += bvh_half_area(node->bounds[side]) * (node->count[side] ? node->count[side] : traversal_cost);
  return sum;
}

// Expected cost of a ray that meets the root's box, from the sum over all nodes; 0 for a tree without area.
static inline double bvh2_cost_of_sum(double sum, double root_area, double traversal_cost)
{
  return root_area > 0 && root_area < INFINITY ? traversal_cost + sum / root_area : 0;
}
