// How a BVH2 is built below the top of its tree: one thread a subtree. For bvh2_build.c alone.
#pragma once

#include "accel/bvh.h"
#include "accel/bvh_split.h"

// What a parent records of a child: a leaf has a count.
typedef struct Reference {
  uint32_t index, count;
} Reference;

typedef struct TopNode {
  Range range;
  uint32_t depth;                // of the root: 1
  struct TopNode *left, *right;  // NULL for a subtree
  BinMap map;
  Split split;
  uint32_t first_chunk, chunk_count;
  Reference root;                   // of a subtree: its place among the primitives
  uint32_t node_count, node_depth;  // of a subtree
  uint32_t first_node;              // of a subtree, in the tree
} TopNode;

typedef struct Builder {
  const TriangleSoup *soup;
  BvhOptions options;
  Prim *prims[2];  // a range of depth d lies in [(d - 1) % 2], its halves in the other one
  struct Chunk *chunks;
  Bins *bins;  // [chunk]
  uint32_t chunk_count;
  TopNode *top;
  uint32_t top_count;
  TopNode **subtrees;  // largest first
  uint32_t subtree_count;
  Bvh2 tree;
} Builder;

static inline Prim *prims_of_depth(Builder *builder, uint32_t depth) { return builder->prims[(depth - 1) % 2]; }

// Builds the tree below a range that lies at that depth of the subtree, and counts its nodes. They stay among the
// primitives, where the reference says, until subtree_number writes them.
Reference subtree_build(Builder *builder, TopNode *subtree, const Range *range, uint32_t depth);

// Writes the nodes of a subtree into the tree in depth-first order, from *next onwards.
Reference subtree_number(Builder *builder, Reference root, uint32_t *next);

void node_set_child(Bvh2Node *node, int side, Box bounds, Reference child);
