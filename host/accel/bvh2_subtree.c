#include "accel/bvh2_subtree.h"

#include <math.h>
#include <string.h>

// Levels of nodes that median splits need for so many triangles.
static uint32_t levels_needed(uint32_t count, uint32_t max_leaf)
{
  uint32_t levels = 0;
  while ((uint64_t)max_leaf << levels < count) levels++;
  return levels;
}

// Whether a leaf of `count` triangles costs no more than a node over two leaves of `split_cost`.
static int leaf_wins(const Builder *builder, const Range *range, F4 scale, float split_cost)
{
  float area = half_area((range->bounds.high - range->bounds.low) * scale);
  uint32_t count = range_count(range);
  return count <= builder->options.max_leaf &&
         !((float)count * area > builder->options.traversal_cost * area + split_cost);
}

static int depth_allows(const Builder *builder, uint32_t depth, uint32_t larger_count)
{
  return depth + levels_needed(larger_count, builder->options.max_leaf) <= BVH_MAX_DEPTH;
}

// Divides a range into `left` and `right`, moved to the next depth's primitives; 0: it is a leaf.
static int range_divide(Range *left, Range *right, Builder *builder, const Range *range, uint32_t depth)
{
  uint32_t count = range_count(range), max_leaf = builder->options.max_leaf;
  const Prim *from = prims_of_depth(builder, depth);
  Prim *to = prims_of_depth(builder, depth + 1);
  if (count == 1 || (count <= max_leaf && depth > BVH_MAX_DEPTH)) return 0;
  F4 scale = area_scale(range->bounds);

  if (count <= MAX_FEW && depth_allows(builder, depth, count - 1)) {
    uint32_t left_mask;
    float cost = few_split(&left_mask, from + range->begin, count, scale);
    if (leaf_wins(builder, range, scale, cost)) return 0;
    few_partition(left, right, to, from, range, left_mask);
    return 1;
  }

  BinMap map;
  Split split;
  int found = bin_map_make(&map, range);
  if (found) {
    Bins bins;
    bins_clear(&bins, &map);
    bins_add(&bins, &map, from, range->begin, range->end);
    found = bins_split(&split, &bins, &map, scale);
  }
  if (leaf_wins(builder, range, scale, found ? split.cost : INFINITY)) return 0;
  if (!found ||
      !depth_allows(builder, depth, split.left_count > count / 2 ? split.left_count : count - split.left_count)) {
    range_split_median(left, right, to, from, range);
    return 1;
  }
  uint32_t middle = range->begin + split.left_count;
  *left = (Range){range->begin, middle, split.left, box_empty()};
  *right = (Range){middle, range->end, split.right, box_empty()};
  prims_partition(to, from, range->begin, range->end, &map, &split, left->begin, right->begin, &left->centroids,
                  &right->centroids);
  return 1;
}

static Reference leaf_write(Builder *builder, const Range *range, uint32_t depth)
{
  const TriangleSoup *soup = builder->soup;
  const Prim *prims = prims_of_depth(builder, depth);
  for (uint32_t i = range->begin; i < range->end; i++) {
    uint32_t id = prim_id(prims[i]);
    BvhTriangle triangle = {.id = id, .flags = soup->flags[id]};
    for (int corner = 0; corner < 3; corner++)
      memcpy(triangle.vertex[corner], soup->positions[soup->triangles[id][corner]], sizeof triangle.vertex[corner]);
    builder->tree.triangles[i] = triangle;
  }
  return (Reference){BVH_LEAF | range->begin, range_count(range)};
}

// A child as a primitive: its box, with the reference in the fourth lanes.
static Prim child_pack(Box bounds, Reference reference)
{
  I4 low = (I4)bounds.low, high = (I4)bounds.high;
  low[3] = (int32_t)reference.index;
  high[3] = (int32_t)reference.count;
  return (Prim){(F4)low, (F4)high};
}

static Reference child_reference(Prim packed)
{
  return (Reference){(uint32_t)((I4)packed.low)[3], (uint32_t)((I4)packed.high)[3]};
}

// Builds the tree below a range. A finished range needs its primitives no more, so a node's two children take the place
// of the last primitive on its left side, in either array: no two nodes have that place in common.
Reference subtree_build(Builder *builder, TopNode *subtree, const Range *range, uint32_t depth)
{
  Range left, right;
  if (!range_divide(&left, &right, builder, range, depth)) return leaf_write(builder, range, depth);
  if (depth > subtree->node_depth) subtree->node_depth = depth;
  subtree->node_count++;
  Reference left_reference = subtree_build(builder, subtree, &left, depth + 1);
  Reference right_reference = subtree_build(builder, subtree, &right, depth + 1);
  uint32_t place = left.end - 1;
  builder->prims[0][place] = child_pack(left.bounds, left_reference);
  builder->prims[1][place] = child_pack(right.bounds, right_reference);
  return (Reference){place, 0};
}

void node_set_child(Bvh2Node *node, int side, Box bounds, Reference child)
{
  for (int axis = 0; axis < 3; axis++) {
    node->bounds[side][axis][0] = bounds.low[axis];
    node->bounds[side][axis][1] = bounds.high[axis];
  }
  node->child[side] = child.index;
  node->count[side] = child.count;
}

Reference subtree_number(Builder *builder, Reference root, uint32_t *next)
{
  if (root.count) return root;
  Reference reference = {(*next)++, 0};
  for (int side = 0; side < 2; side++) {
    Prim child = builder->prims[side][root.index];
    node_set_child(&builder->tree.nodes[reference.index], side, child,
                   subtree_number(builder, child_reference(child), next));
  }
  return reference;
}
