// Bounding volume hierarchy over world-space triangles, built on the host by binned surface-area heuristic.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "base/log.h"
#include "shared/bvh.h"

// World-space triangles in scene order; triangle i has id i.
typedef struct TriangleSoup {
  const float (*positions)[3];     // [vertex_count]
  const uint32_t (*triangles)[3];  // [triangle_count], indices into positions
  const uint32_t *flags;           // [triangle_count], TRIANGLE_*
  uint32_t vertex_count, triangle_count;
} TriangleSoup;

// Binary tree: nodes[0] is the root (there even for an empty soup, with BVH_EMPTY children). Nodes lie in depth-first
// order; triangles in the order of the leaves, each exactly once. A box contains its triangles exactly (min and max of
// float coordinates); traversal pads, not the tree.
typedef struct Bvh2 {
  Bvh2Node *nodes;
  BvhTriangle *triangles;
  uint32_t node_count, triangle_count, depth;
} Bvh2;

typedef struct Bvh8 {
  Bvh8Node *nodes;  // nodes[0] is the root
  Bvh8Block *blocks;
  uint32_t node_count, block_count, depth;
} Bvh8;

typedef struct BvhOptions {
  uint32_t max_leaf;     // triangles, 1..8
  float traversal_cost;  // of visiting a node, in units of one triangle test
} BvhOptions;

// The same tree for any number of threads. Triangles with a non-finite vertex are left out; those of zero area stay.
// Depth (levels of nodes) stays within BVH_MAX_DEPTH whatever the input (median splits take over), so that traversal
// stacks are bounded.
// Source: Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007.
// Cost: 871 k triangles take 0.16 s on two cores; 64 bytes a triangle besides the result while it runs.
// Errors: STATUS_NO_MEMORY, STATUS_TOO_LARGE (2^28 triangles or more), STATUS_USAGE (max_leaf outside 1..8).
#define BVH_MAX_DEPTH 60
Status bvh2_build(Bvh2 *out, const TriangleSoup *soup, const BvhOptions *options, Log *log);
void bvh2_free(Bvh2 *bvh);

// Collapses the binary tree: each node opens its largest children until it has eight; subtrees of at most eight
// triangles become one block. Source: Wald, Benthin, Boulos, "Getting Rid of Packets", 2008.
Status bvh8_from_bvh2(Bvh8 *out, const Bvh2 *bvh, Log *log);
void bvh8_free(Bvh8 *bvh);

// A block of 1 to 8 triangles; the last fills the unused slots.
void bvh8_block_fill(Bvh8Block *block, const BvhTriangle *triangles, uint32_t count);
