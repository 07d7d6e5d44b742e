// Trees that follow triangles that move: boxes made anew from the leaves up, in place, in the order they have.
//
//   Cost  of what moved and the nodes above it, and a byte read for each triangle, block and node.
//   Fails where triangles that share leaves part: boxes grow and overlap, rays take longer (never other hits). The
//         sum of areas tells: bvh_refit_is_worn. Where a triangle becomes or ceases to be finite, the tree has to
//         be built anew.
//   From  Wald, Boulos, Shirley, "Ray Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies", 2007; when
//         to build anew: Lauterbach, Yoon, Tuft, Manocha, "RT-DEFORM: Interactive Ray Tracing of Dynamic Scenes using
//         BVHs", 2006.
#pragma once

#include <stdbool.h>

#include "accel/bvh.h"

// Where a triangle lies: its place in the order of the leaves, and the node above it; BVH_EMPTY for one left out.
typedef struct BvhPlace {
  uint32_t slot, node;
} BvhPlace;

// Nodes [begin, end) of a subtree, for one thread, and the change of their cost.
typedef struct BvhSubtree {
  uint32_t begin, end;
  double change;
} BvhSubtree;

typedef struct BvhRefit {
  Bvh2 *two;
  Bvh8 *eight;             // NULL where there is none
  BvhPlace *places;        // [place_count], by id
  uint32_t *parents;       // [two->node_count]
  uint32_t *block_starts;  // [eight->block_count + 1], first triangle of each block
  BvhSubtree *subtrees;    // [subtree_count], apart; what is above them is refitted after them
  uint32_t place_count, subtree_count;
  double traversal_cost;
  double cost_sum, built_sum;  // bvh2_node_cost over all nodes, now and after the build
  double largest_sum;          // since it was summed from nothing

  // Bytes that are 1 where the last bvh_refit wrote: by triangle in the order of the leaves, node, wide node, block.
  uint8_t *triangles_moved, *nodes_moved, *wide_nodes_moved, *blocks_moved;
} BvhRefit;

// Prepares two trees that were just built, `eight` (may be NULL) from `two`, for refits. They must stay where they are.
// `triangle_count` is the soup's. Errors: STATUS_NO_MEMORY.
Status bvh_refit_make(BvhRefit *out, Bvh2 *two, Bvh8 *eight, uint32_t triangle_count, double traversal_cost, Log *log);
void bvh_refit_free(BvhRefit *refit);

typedef struct BvhIds {
  uint32_t begin, end;
} BvhIds;

// Moves both trees to the soup as it is now, which differs from what they hold in triangles of `moved` alone. False
// where a triangle became finite or no longer is, or the tree is of a few triangles alone: the trees are then to be
// freed and built anew.
bool bvh_refit(BvhRefit *refit, const TriangleSoup *soup, const BvhIds *moved, uint32_t moved_count);

// Is a build worth its time: is cost_sum over BVH_WORN times what it was after the build? Not relative to the root's
// area, as bvh2_cost is: where parts fly apart the root grows, and what rays meet in the middle does not lessen.
// Measured where 150 balls fly apart about a bust: 1.32, 1.8, 2.8, 6.8 times the sum (1.30, 1.8, 2.5, 5.2 times that of
// a tree built anew) make rays take 1.2, 1.4, 2.4, 3.3 times as long. Meshes that turn, bend or shake a little stay
// under 1.3 and lose nothing.
#define BVH_WORN 1.3
bool bvh_refit_is_worn(const BvhRefit *refit);
