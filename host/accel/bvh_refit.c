#include "accel/bvh_refit.h"

#include <string.h>

#include "accel/box.h"
#include "accel/bvh_cost.h"
#include "base/large_array.h"
#include "base/parallel.h"

enum {
  SUBTREES_PER_TREE = 64,
  CHUNK = 4096,        // triangles that one thread moves at once
  AHEAD = 16,          // of them, which lie anywhere in the tree: so far ahead they are fetched
  BLOCK_CHUNK = 1024,  // blocks, or wide nodes
  WORTH_THREADS = 2 * CHUNK,
  FEW_TRIANGLES = 8,  // a wide tree of one block, whose box is no box of the binary tree
};

typedef struct Pass {
  BvhRefit *refit;
  const TriangleSoup *soup;
  BvhIds moved;
  int finite_changed;
} Pass;

static void loop(size_t count, ParallelBody body, void *context, bool threads)
{
  if (threads)
    parallel_for(count, body, context);
  else
    for (size_t i = 0; i < count; i++) body(context, i);
}

static size_t chunks_of(size_t count, size_t chunk) { return (count + chunk - 1) / chunk; }

static void places_fill(BvhRefit *refit)
{
  const Bvh2 *two = refit->two;
  memset(refit->places, 0xff, refit->place_count * sizeof *refit->places);
  refit->parents[0] = 0;
  for (uint32_t i = 0; i < two->node_count; i++)
    for (int side = 0; side < 2; side++) {
      const Bvh2Node *node = &two->nodes[i];
      const uint32_t child = node->child[side], first = child & ~BVH_LEAF;
      if (node->count[side] == 0 && child != BVH_EMPTY) refit->parents[child] = i;
      for (uint32_t slot = first; slot < first + node->count[side]; slot++)
        refit->places[two->triangles[slot].id] = (BvhPlace){slot, i};
    }
}

// Blocks come in the order of the binary tree's leaves.
static void block_starts_fill(BvhRefit *refit)
{
  uint32_t next = 0;
  for (uint32_t b = 0; b < refit->eight->block_count; b++) {
    const Bvh8Block *block = &refit->eight->blocks[b];
    refit->block_starts[b] = next++;
    for (int slot = 1; slot < 8 && block->id[slot] != block->id[slot - 1]; slot++) next++;
  }
  refit->block_starts[refit->eight->block_count] = next;
}

// Finds subtrees of a share of the nodes each; writes them where `out` is not NULL and returns how many.
static uint32_t subtrees_find(BvhSubtree *out, const uint32_t *sizes, uint32_t node_count)
{
  uint32_t count = 0;
  for (uint32_t i = 0; i < node_count;) {
    if (sizes[i] > node_count / SUBTREES_PER_TREE) {
      i++;
      continue;
    }
    if (out) out[count] = (BvhSubtree){.begin = i, .end = i + sizes[i]};
    count++;
    i += sizes[i];
  }
  return count;
}

static bool subtrees_make(BvhRefit *refit)
{
  const uint32_t nodes = refit->two->node_count;
  uint32_t *sizes = large_array(nodes, sizeof *sizes);
  if (!sizes) return false;
  for (uint32_t i = 0; i < nodes; i++) sizes[i] = 1;
  for (uint32_t i = nodes; i-- > 1;) sizes[refit->parents[i]] += sizes[i];
  refit->subtree_count = subtrees_find(NULL, sizes, nodes);
  refit->subtrees = large_array(refit->subtree_count, sizeof *refit->subtrees);
  if (refit->subtrees) subtrees_find(refit->subtrees, sizes, nodes);
  free(sizes);
  return refit->subtrees != NULL;
}

static bool refit_allocate(BvhRefit *refit)
{
  const size_t nodes = refit->two->node_count, triangles = refit->two->triangle_count;
  const size_t wide_nodes = refit->eight ? refit->eight->node_count : 0;
  const size_t blocks = refit->eight ? refit->eight->block_count : 0;
  refit->places = large_array(refit->place_count, sizeof *refit->places);
  refit->parents = large_array(nodes, sizeof *refit->parents);
  refit->block_starts = large_array(blocks + 1, sizeof *refit->block_starts);
  refit->triangles_moved = calloc(triangles + 1, 1);
  refit->nodes_moved = calloc(nodes + 1, 1);
  refit->wide_nodes_moved = calloc(wide_nodes + 1, 1);
  refit->blocks_moved = calloc(blocks + 1, 1);
  return refit->places && refit->parents && refit->block_starts && refit->triangles_moved && refit->nodes_moved &&
         refit->wide_nodes_moved && refit->blocks_moved;
}

static void cost_sum_anew(BvhRefit *refit)
{
  const Bvh2 *two = refit->two;
  refit->cost_sum = 0;
  for (uint32_t i = 0; i < two->node_count; i++)
    refit->cost_sum += bvh2_node_cost(&two->nodes[i], refit->traversal_cost);
  refit->largest_sum = refit->cost_sum;
}

Status bvh_refit_make(BvhRefit *out, Bvh2 *two, Bvh8 *eight, uint32_t triangle_count, double traversal_cost, Log *log)
{
  BvhRefit refit = {.two = two, .eight = eight, .place_count = triangle_count, .traversal_cost = traversal_cost};
  bool made = refit_allocate(&refit);
  if (made) {
    places_fill(&refit);
    if (eight) block_starts_fill(&refit);
    made = subtrees_make(&refit);
  }
  if (!made) {
    bvh_refit_free(&refit);
    return log_no_memory(log, "BVH");
  }
  cost_sum_anew(&refit);
  refit.built_sum = refit.cost_sum;
  *out = refit;
  return STATUS_OK;
}

void bvh_refit_free(BvhRefit *refit)
{
  free(refit->places);
  free(refit->parents);
  free(refit->block_starts);
  free(refit->subtrees);
  free(refit->triangles_moved);
  free(refit->nodes_moved);
  free(refit->wide_nodes_moved);
  free(refit->blocks_moved);
  *refit = (BvhRefit){0};
}

static void mark(uint8_t *byte) { __atomic_store_n(byte, 1, __ATOMIC_RELAXED); }

// The triangle's vertices; returns whether all are finite.
static bool triangle_read(float vertex[3][3], const TriangleSoup *soup, uint32_t id)
{
  float zero = 0;
  for (int corner = 0; corner < 3; corner++)
    for (int axis = 0; axis < 3; axis++) {
      vertex[corner][axis] = soup->positions[soup->triangles[id][corner]][axis];
      zero += vertex[corner][axis] * 0;
    }
  return zero == 0;  // infinity and NaN times 0 are NaN
}

static void triangles_move(void *context, size_t index)
{
  Pass *pass = context;
  BvhRefit *refit = pass->refit;
  const uint32_t begin = pass->moved.begin + (uint32_t)index * CHUNK;
  const uint32_t end = pass->moved.end - begin > CHUNK ? begin + CHUNK : pass->moved.end;
  for (uint32_t id = begin; id < end; id++) {
    const BvhPlace place = refit->places[id], later = refit->places[end - id > AHEAD ? id + AHEAD : id];
    float vertex[3][3];
    if (later.slot != BVH_EMPTY) __builtin_prefetch(&refit->two->triangles[later.slot], 1);
    const bool finite = triangle_read(vertex, pass->soup, id);
    if (finite != (place.slot != BVH_EMPTY)) __atomic_store_n(&pass->finite_changed, 1, __ATOMIC_RELAXED);
    if (!finite || place.slot == BVH_EMPTY) continue;
    BvhTriangle *triangle = &refit->two->triangles[place.slot];
    if (memcmp(triangle->vertex, vertex, sizeof vertex) == 0) continue;
    memcpy(triangle->vertex, vertex, sizeof vertex);
    mark(&refit->triangles_moved[place.slot]);
    mark(&refit->nodes_moved[place.node]);
  }
}

static Box node_side_box(const Bvh2Node *node, int side)
{
  const float(*bounds)[2] = node->bounds[side];
  return (Box){{bounds[0][0], bounds[1][0], bounds[2][0]}, {bounds[0][1], bounds[1][1], bounds[2][1]}};
}

static Box child_box(const Bvh2 *two, const Bvh2Node *node, int side)
{
  const uint32_t child = node->child[side], first = child & ~BVH_LEAF;
  if (node->count[side] == 0)
    return box_union(node_side_box(&two->nodes[child], 0), node_side_box(&two->nodes[child], 1));
  Box box = box_empty();
  for (uint32_t i = first; i < first + node->count[side]; i++)
    for (int corner = 0; corner < 3; corner++) {
      const float *vertex = two->triangles[i].vertex[corner];
      box = box_with_point(box, (F4){vertex[0], vertex[1], vertex[2], 0});
    }
  return box;
}

// Makes the boxes of a node's children anew; returns the change of its cost.
static double node_refit(const BvhRefit *refit, uint32_t index)
{
  Bvh2Node *node = &refit->two->nodes[index];
  const double before = bvh2_node_cost(node, refit->traversal_cost);
  for (int side = 0; side < 2; side++) {
    const Box box = child_box(refit->two, node, side);
    for (int axis = 0; axis < 3; axis++) {
      node->bounds[side][axis][0] = box.low[axis];
      node->bounds[side][axis][1] = box.high[axis];
    }
  }
  return bvh2_node_cost(node, refit->traversal_cost) - before;
}

// Refits the marked nodes of [begin, end), the last first, and marks their parents, down to `lowest`. Returns the
// change of their cost.
static double nodes_refit(BvhRefit *refit, uint32_t begin, uint32_t end, uint32_t lowest)
{
  double change = 0;
  uint8_t *marks = refit->nodes_moved;
  for (const uint8_t *at; (at = memrchr(marks + begin, 1, end - begin)) != NULL;) {
    end = (uint32_t)(at - marks);
    change += node_refit(refit, end);
    if (refit->parents[end] >= lowest) marks[refit->parents[end]] = 1;
  }
  return change;
}

static void subtree_refit(void *context, size_t index)
{
  const Pass *pass = context;
  BvhSubtree *subtree = &pass->refit->subtrees[index];
  subtree->change = nodes_refit(pass->refit, subtree->begin, subtree->end, subtree->begin);
}

// The nodes above the subtrees, and the sum of all changes: in this order, whatever the threads.
static void top_refit(BvhRefit *refit)
{
  uint32_t end = refit->two->node_count;
  for (uint32_t i = refit->subtree_count; i-- > 0; end = refit->subtrees[i].begin) {
    const BvhSubtree *subtree = &refit->subtrees[i];
    refit->cost_sum += nodes_refit(refit, subtree->end, end, 0);
    refit->cost_sum += subtree->change;
    if (refit->nodes_moved[subtree->begin]) refit->nodes_moved[refit->parents[subtree->begin]] = 1;
  }
  refit->cost_sum += nodes_refit(refit, 0, end, 0);
  if (refit->cost_sum > refit->largest_sum) refit->largest_sum = refit->cost_sum;
  if (!(refit->cost_sum > 1e-3 * refit->largest_sum)) cost_sum_anew(refit);  // too many digits are lost
}

static void blocks_move(void *context, size_t index)
{
  const Pass *pass = context;
  BvhRefit *refit = pass->refit;
  const uint32_t *starts = refit->block_starts, count = refit->eight->block_count;
  uint32_t block = (uint32_t)index * BLOCK_CHUNK, end = count - block > BLOCK_CHUNK ? block + BLOCK_CHUNK : count;
  const uint8_t *marks = refit->triangles_moved, *at = marks + starts[block];
  while ((at = memchr(at, 1, (size_t)(marks + starts[end] - at))) != NULL) {
    while (starts[block + 1] <= at - marks) block++;
    bvh8_block_fill(&refit->eight->blocks[block], &refit->two->triangles[starts[block]],
                    starts[block + 1] - starts[block]);
    refit->blocks_moved[block] = 1;
    at = marks + starts[block + 1];
  }
}

static void wide_nodes_move(void *context, size_t index)
{
  const Pass *pass = context;
  BvhRefit *refit = pass->refit;
  const uint32_t begin = (uint32_t)index * BLOCK_CHUNK, count = refit->eight->node_count;
  const uint32_t end = count - begin > BLOCK_CHUNK ? begin + BLOCK_CHUNK : count;
  for (uint32_t i = begin; i < end; i++) {
    Bvh8Node *node = &refit->eight->nodes[i];
    for (int lane = 0; lane < 8 && node->source[lane] != BVH_EMPTY; lane++) {
      const uint32_t source = node->source[lane];
      if (!refit->nodes_moved[source / 2]) continue;
      const float(*bounds)[2] = refit->two->nodes[source / 2].bounds[source % 2];
      for (int axis = 0; axis < 3; axis++)
        for (int end_of = 0; end_of < 2; end_of++) node->bounds[axis][end_of][lane] = bounds[axis][end_of];
      refit->wide_nodes_moved[i] = 1;
    }
  }
}

static void marks_clear(BvhRefit *refit)
{
  memset(refit->triangles_moved, 0, refit->two->triangle_count);
  memset(refit->nodes_moved, 0, refit->two->node_count);
  if (!refit->eight) return;
  memset(refit->wide_nodes_moved, 0, refit->eight->node_count);
  memset(refit->blocks_moved, 0, refit->eight->block_count);
}

bool bvh_refit(BvhRefit *refit, const TriangleSoup *soup, const BvhIds *moved, uint32_t moved_count)
{
  Pass pass = {.refit = refit, .soup = soup};
  size_t triangles = 0;
  if (refit->two->triangle_count <= FEW_TRIANGLES) return false;
  marks_clear(refit);
  for (uint32_t i = 0; i < moved_count; i++) {
    const size_t count = moved[i].end - moved[i].begin;
    pass.moved = moved[i];
    loop(chunks_of(count, CHUNK), triangles_move, &pass, count > WORTH_THREADS);
    triangles += count;
  }
  if (pass.finite_changed) return false;
  const bool threads = triangles > WORTH_THREADS;
  loop(refit->subtree_count, subtree_refit, &pass, threads);
  top_refit(refit);
  if (!refit->eight) return true;
  loop(chunks_of(refit->eight->block_count, BLOCK_CHUNK), blocks_move, &pass, threads);
  loop(chunks_of(refit->eight->node_count, BLOCK_CHUNK), wide_nodes_move, &pass, threads);
  return true;
}

bool bvh_refit_is_worn(const BvhRefit *refit) { return refit->cost_sum > BVH_WORN * refit->built_sum; }
