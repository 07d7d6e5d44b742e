#include "accel/bvh_validate.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "accel/bvh_cost.h"

typedef struct Bounds {
  float low[3], high[3];
} Bounds;

typedef struct Check {
  const TriangleSoup *soup;
  Log *log;
  bool *seen;          // [soup->triangle_count]
  uint32_t next_node;  // that a depth-first walk meets
  uint32_t next_leaf;  // first triangle, or block, that it meets
  uint32_t found;      // triangles
  uint32_t depth;      // deepest node met; the root's is 1
} Check;

static const Bounds bounds_empty = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void bounds_add(Bounds *bounds, const float low[3], const float high[3])
{
  for (int axis = 0; axis < 3; axis++) {
    if (low[axis] < bounds->low[axis]) bounds->low[axis] = low[axis];
    if (high[axis] > bounds->high[axis]) bounds->high[axis] = high[axis];
  }
}

static bool bounds_equal(const Bounds *a, const Bounds *b)
{
  for (int axis = 0; axis < 3; axis++)
    if (a->low[axis] != b->low[axis] || a->high[axis] != b->high[axis]) return false;
  return true;
}

static bool triangle_finite(const TriangleSoup *soup, uint32_t id)
{
  for (int corner = 0; corner < 3; corner++)
    for (int axis = 0; axis < 3; axis++)
      if (!isfinite(soup->positions[soup->triangles[id][corner]][axis])) return false;
  return true;
}

// A triangle met for the first time, the same as in the soup.
static Status check_triangle(Check *check, Bounds *bounds, uint32_t id, uint32_t flags, const float vertex[3][3])
{
  const TriangleSoup *soup = check->soup;
  if (id >= soup->triangle_count)
    return log_fail(check->log, STATUS_FAILED, "BVH: triangle %u of %u is in a leaf", id, soup->triangle_count);
  if (check->seen[id]) return log_fail(check->log, STATUS_FAILED, "BVH: triangle %u is in two places", id);
  check->seen[id] = true;
  check->found++;
  if (!triangle_finite(soup, id)) return log_fail(check->log, STATUS_FAILED, "BVH: triangle %u is not finite", id);
  if (flags != soup->flags[id]) return log_fail(check->log, STATUS_FAILED, "BVH: triangle %u has other flags", id);
  for (int corner = 0; corner < 3; corner++) {
    if (memcmp(vertex[corner], soup->positions[soup->triangles[id][corner]], sizeof vertex[corner]) != 0)
      return log_fail(check->log, STATUS_FAILED, "BVH: triangle %u, corner %d: not the soup's", id, corner);
    bounds_add(bounds, vertex[corner], vertex[corner]);
  }
  return STATUS_OK;
}

static Status check_begin(Check *check, const TriangleSoup *soup, Log *log)
{
  *check = (Check){.soup = soup, .log = log};
  check->seen = calloc(soup->triangle_count + 1, sizeof *check->seen);
  return check->seen ? STATUS_OK : log_no_memory(log, "BVH");
}

static Status check_node(Check *check, uint32_t index, uint32_t node_count, uint32_t depth)
{
  if (index != check->next_node || index >= node_count)
    return log_fail(check->log, STATUS_FAILED, "BVH: node %u where node %u of %u comes next", index, check->next_node,
                    node_count);
  if (depth > BVH_MAX_DEPTH)
    return log_fail(check->log, STATUS_FAILED, "BVH: node %u is at depth %u of %d", index, depth, BVH_MAX_DEPTH);
  check->next_node++;
  if (depth > check->depth) check->depth = depth;
  return STATUS_OK;
}

// The box a node records of a child; `contents` is what lies below, which joins the node's own bounds.
static Status check_box(Check *check, Bounds *bounds, const Bounds *recorded, const Bounds *contents, uint32_t node,
                        int child)
{
  if (!bounds_equal(recorded, contents))
    return log_fail(check->log, STATUS_FAILED, "BVH: node %u, child %d: its box is not the box of its contents", node,
                    child);
  bounds_add(bounds, contents->low, contents->high);
  return STATUS_OK;
}

static Status check_totals(const Check *check, uint32_t nodes, uint32_t leaves, uint32_t triangles, uint32_t depth)
{
  uint32_t finite = 0;
  for (uint32_t i = 0; i < check->soup->triangle_count; i++) finite += triangle_finite(check->soup, i);
  if (check->next_node != nodes || check->next_leaf != leaves)
    return log_fail(check->log, STATUS_FAILED, "BVH: %u nodes and %u leaf entries of %u and %u can be reached",
                    check->next_node, check->next_leaf, nodes, leaves);
  if (check->found != finite || triangles != finite)
    return log_fail(check->log, STATUS_FAILED, "BVH: %u triangles found, %u recorded, %u in the soup", check->found,
                    triangles, finite);
  if (check->depth != depth)
    return log_fail(check->log, STATUS_FAILED, "BVH: depth %u, recorded as %u", check->depth, depth);
  return STATUS_OK;
}

static Status check_leaf2(Check *check, Bounds *bounds, const Bvh2 *bvh, uint32_t first, uint32_t count,
                          uint32_t max_leaf)
{
  Status status = STATUS_OK;
  if (first != check->next_leaf || count > max_leaf || count > bvh->triangle_count - first)
    return log_fail(check->log, STATUS_FAILED, "BVH: a leaf of %u triangles from %u on, where %u comes next", count,
                    first, check->next_leaf);
  check->next_leaf += count;
  for (uint32_t i = first; i < first + count; i++) {
    const BvhTriangle *triangle = &bvh->triangles[i];
    if (i > first && triangle->id <= bvh->triangles[i - 1].id)
      return log_fail(check->log, STATUS_FAILED, "BVH: triangle %u: ids of its leaf do not ascend", triangle->id);
    TRY(check_triangle(check, bounds, triangle->id, triangle->flags, triangle->vertex));
  }
done:
  return status;
}

static Status check_tree2(Check *check, Bounds *bounds, const Bvh2 *bvh, uint32_t index, uint32_t depth,
                          uint32_t max_leaf)
{
  Status status = STATUS_OK;
  TRY(check_node(check, index, bvh->node_count, depth));
  const Bvh2Node *node = &bvh->nodes[index];
  for (int side = 0; side < 2; side++) {
    Bounds contents = bounds_empty, recorded;
    for (int axis = 0; axis < 3; axis++) {
      recorded.low[axis] = node->bounds[side][axis][0];
      recorded.high[axis] = node->bounds[side][axis][1];
    }
    uint32_t child = node->child[side], count = node->count[side];
    bool empty = child == BVH_EMPTY;
    if ((empty || !(child & BVH_LEAF)) != (count == 0) || (empty && bvh->node_count > 1))
      return log_fail(check->log, STATUS_FAILED, "BVH: node %u, child %d: %x with %u triangles", index, side, child,
                      count);
    if (count)
      TRY(check_leaf2(check, &contents, bvh, child & ~BVH_LEAF, count, max_leaf));
    else if (!empty)
      TRY(check_tree2(check, &contents, bvh, child, depth + 1, max_leaf));
    TRY(check_box(check, bounds, &recorded, &contents, index, side));
  }
done:
  return status;
}

Status bvh2_validate(const Bvh2 *bvh, const TriangleSoup *soup, uint32_t max_leaf, Log *log)
{
  Status status = STATUS_OK;
  Check check;
  Bounds bounds = bounds_empty;
  TRY(check_begin(&check, soup, log));
  TRY(check_tree2(&check, &bounds, bvh, 0, 1, max_leaf));
  TRY(check_totals(&check, bvh->node_count, bvh->triangle_count, bvh->triangle_count, bvh->depth));
done:
  free(check.seen);
  return status;
}

static Status check_block(Check *check, Bounds *bounds, const Bvh8 *bvh, uint32_t index)
{
  Status status = STATUS_OK;
  if (index != check->next_leaf || index >= bvh->block_count)
    return log_fail(check->log, STATUS_FAILED, "BVH: block %u where block %u of %u comes next", index, check->next_leaf,
                    bvh->block_count);
  check->next_leaf++;
  const Bvh8Block *block = &bvh->blocks[index];
  float vertex[3][3], previous[3][3];
  bool repeats = false;
  for (int slot = 0; slot < 8; slot++) {
    memcpy(previous, vertex, sizeof previous);
    for (int corner = 0; corner < 3; corner++)
      for (int axis = 0; axis < 3; axis++) vertex[corner][axis] = block->vertex[corner][axis][slot];
    bool same = slot > 0 && block->id[slot] == block->id[slot - 1];
    if (repeats && !same) return log_fail(check->log, STATUS_FAILED, "BVH: block %u has a gap", index);
    repeats = same;
    if (!same) {
      TRY(check_triangle(check, bounds, block->id[slot], block->flags[slot], vertex));
    } else if (block->flags[slot] != block->flags[slot - 1] || memcmp(vertex, previous, sizeof vertex) != 0) {
      return log_fail(check->log, STATUS_FAILED, "BVH: block %u, slot %d: no copy of the last triangle", index, slot);
    }
  }
done:
  return status;
}

static Status check_tree8(Check *check, Bounds *bounds, const Bvh8 *bvh, uint32_t index, uint32_t depth)
{
  Status status = STATUS_OK;
  TRY(check_node(check, index, bvh->node_count, depth));
  const Bvh8Node *node = &bvh->nodes[index];
  for (int i = 0; i < 8; i++) {
    Bounds contents = bounds_empty, recorded;
    for (int axis = 0; axis < 3; axis++) {
      recorded.low[axis] = node->bounds[axis][0][i];
      recorded.high[axis] = node->bounds[axis][1][i];
    }
    uint32_t child = node->child[i];
    if (child == BVH_EMPTY)
      contents = bounds_empty;
    else if (child & BVH_LEAF)
      TRY(check_block(check, &contents, bvh, child & ~BVH_LEAF));
    else
      TRY(check_tree8(check, &contents, bvh, child, depth + 1));
    TRY(check_box(check, bounds, &recorded, &contents, index, i));
  }
done:
  return status;
}

Status bvh8_validate(const Bvh8 *bvh, const TriangleSoup *soup, Log *log)
{
  Status status = STATUS_OK;
  Check check;
  Bounds bounds = bounds_empty;
  TRY(check_begin(&check, soup, log));
  TRY(check_tree8(&check, &bounds, bvh, 0, 1));
  TRY(check_totals(&check, bvh->node_count, bvh->block_count, check.found, bvh->depth));
done:
  free(check.seen);
  return status;
}

double bvh2_cost(const Bvh2 *bvh, double traversal_cost)
{
  double sum = 0;
  for (uint32_t i = 0; i < bvh->node_count; i++) sum += bvh2_node_cost(&bvh->nodes[i], traversal_cost);
  return bvh2_cost_of_sum(sum, bvh2_root_area(&bvh->nodes[0]), traversal_cost);
}
