// Checks of finished trees, for tests and for whoever writes a builder or a refit.
#pragma once

#include "accel/bvh.h"

// Walks the whole tree: nodes and triangles in depth-first order and none left over; every finite triangle of the soup
// exactly once, with the soup's vertices and flags; ids ascending in a leaf of at most `max_leaf`; each recorded box
// exactly the box of what lies below it, hence inside its parent's; unused children empty; depth as recorded and within
// BVH_MAX_DEPTH. Errors: STATUS_FAILED with what is wrong and where, STATUS_NO_MEMORY.
Status bvh2_validate(const Bvh2 *bvh, const TriangleSoup *soup, uint32_t max_leaf, Log *log);

// The same of the wide tree; unused slots of a block repeat the last used one.
Status bvh8_validate(const Bvh8 *bvh, const TriangleSoup *soup, Log *log);

// Expected cost of a ray that meets the root's box, in triangle tests: sum over nodes of traversal_cost x area and over
// leaves of count x area, over the root's area. 0 for a tree without area.
double bvh2_cost(const Bvh2 *bvh, double traversal_cost);
