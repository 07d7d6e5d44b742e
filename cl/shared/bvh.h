// Bounding volume hierarchies over world-space triangles. Built by host/accel, walked by cl/rays.
//
// Two layouts of the same tree: Bvh2 for packets of rays on a CPU and for single rays on a GPU; Bvh8 for single rays on
// a CPU, whose eight children fill one vector.
#ifndef SHARED_BVH_H
#define SHARED_BVH_H

#include "shared/types.h"

// Reference to a child. Interior: index of a node. Leaf: BVH_LEAF | first triangle (or block), with the count apart.
#define BVH_LEAF 0x80000000u
#define BVH_EMPTY 0xffffffffu

// Both children's boxes in the parent, so that one 64-byte line decides both. bounds[child][axis][0 = low, 1 = high].
typedef struct Bvh2Node {
  float bounds[2][3][2];
  uint child[2];  // node index, or BVH_LEAF | index of the first triangle; BVH_EMPTY for none
  uint count[2];  // triangles of a leaf; 0 for a node
} Bvh2Node;
SHARED_SIZE(Bvh2Node, 64);

// One triangle in the order of the leaves. `id` numbers triangles in scene order; ties in distance go to the lower id.
typedef struct BvhTriangle {
  float vertex[3][3];  // world space, [corner][axis]
  uint id;
  uint flags;  // TRIANGLE_*
  uint pad;
} BvhTriangle;
SHARED_SIZE(BvhTriangle, 48);

#define TRIANGLE_SINGLE_SIDED 1u  // open to camera and reflected rays from behind; shadow rays see either side
#define TRIANGLE_MASKED 2u        // alpha MASK: the texture decides whether a hit counts
#define TRIANGLE_BLENDED 4u       // alpha BLEND: shadow rays pass, weakened
#define TRIANGLE_SHADOWLESS 8u    // shadow rays pass

// Eight children, structure of arrays. An unused child has an empty box (low = +inf, high = -inf).
typedef struct Bvh8Node {
  float bounds[3][2][8];  // [axis][low, high][child]
  uint child[8];          // node index, or BVH_LEAF | index of a Bvh8Block; BVH_EMPTY
  uint source[8];         // whose box it is: 2 x node + side of the binary tree; BVH_EMPTY for none or for both sides
} Bvh8Node;
SHARED_SIZE(Bvh8Node, 256);

// Up to eight triangles, structure of arrays. Unused slots repeat a triangle of the block.
typedef struct Bvh8Block {
  float vertex[3][3][8];  // [corner][axis][slot]
  uint id[8];
  uint flags[8];
} Bvh8Block;
SHARED_SIZE(Bvh8Block, 352);

#endif
