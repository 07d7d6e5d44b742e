#include <string.h>

#include "accel/bvh2_subtree.h"
#include "base/large_array.h"
#include "base/parallel.h"

// The top of the tree is divided level by level, each level's ranges cut into chunks for the threads; ranges that are
// small enough become subtrees, one thread each. Neither cut depends on the number of threads.
enum {
  CHUNK = 8192,
  MAX_TOP_RANGES = 64,   // that one level may divide
  MAX_TOP_LEVELS = 12,   // ranges still large after that become subtrees all the same
  MIN_TOP_COUNT = 4096,  // ranges up to this size are subtrees at once
  MAX_TOP_NODES = 1 + 2 * MAX_TOP_RANGES * MAX_TOP_LEVELS,
};

typedef struct Chunk {
  const TopNode *node;
  uint32_t begin, end, count;
  uint32_t left_at, right_at;
  Box bounds, left_centroids, right_centroids;
} Chunk;

// Boxes of the chunk's triangles, packed to its front where some are left out.
static void chunk_read(void *context, size_t index)
{
  Builder *builder = context;
  const TriangleSoup *soup = builder->soup;
  Chunk *chunk = &builder->chunks[index];
  Prim *prims = builder->prims[0] + chunk->begin;
  Box bounds = box_empty(), centroids = box_empty();
  for (uint32_t i = chunk->begin; i < chunk->end; i++) {
    Prim prim = box_empty();
    F4 zero = {0};
    for (int corner = 0; corner < 3; corner++) {
      const float *position = soup->positions[soup->triangles[i][corner]];
      F4 point = {position[0], position[1], position[2], 0};
      prim = box_with_point(prim, point);
      zero += point * 0;
    }
    if (!(zero[0] + zero[1] + zero[2] == 0)) continue;  // infinity and NaN times 0 are NaN
    bounds = box_union(prim, bounds);
    prim = prim_with_id(prim, i);
    centroids = box_with_point(centroids, prim_centroid(prim));
    prims[chunk->count++] = prim;
  }
  chunk->bounds = bounds;
  chunk->left_centroids = centroids;
}

static void chunk_bin(void *context, size_t index)
{
  Builder *builder = context;
  const Chunk *chunk = &builder->chunks[index];
  const TopNode *node = chunk->node;
  bins_clear(&builder->bins[index], &node->map);
  bins_add(&builder->bins[index], &node->map, prims_of_depth(builder, node->depth), chunk->begin, chunk->end);
}

static void chunk_partition(void *context, size_t index)
{
  Builder *builder = context;
  Chunk *chunk = &builder->chunks[index];
  const TopNode *node = chunk->node;
  if (!node->left) return;
  prims_partition(prims_of_depth(builder, node->depth + 1), prims_of_depth(builder, node->depth), chunk->begin,
                  chunk->end, &node->map, &node->split, chunk->left_at, chunk->right_at, &chunk->left_centroids,
                  &chunk->right_centroids);
}

static void chunks_add(Builder *builder, TopNode *node)
{
  node->first_chunk = builder->chunk_count;
  for (uint32_t begin = node->range.begin; begin < node->range.end; begin += CHUNK) {
    uint32_t end = node->range.end - begin > CHUNK ? begin + CHUNK : node->range.end;
    builder->chunks[builder->chunk_count++] = (Chunk){
        .node = node, .begin = begin, .end = end, .left_centroids = box_empty(), .right_centroids = box_empty()};
  }
  node->chunk_count = builder->chunk_count - node->first_chunk;
}

static TopNode *top_add(Builder *builder, uint32_t begin, uint32_t end, Box bounds, uint32_t depth)
{
  TopNode *node = &builder->top[builder->top_count++];
  *node = (TopNode){.range = {begin, end, bounds, box_empty()}, .depth = depth};
  return node;
}

// Fills prims[0] and makes the root.
static void prims_read(Builder *builder)
{
  TopNode whole = {.range = {.begin = 0, .end = builder->soup->triangle_count}};
  chunks_add(builder, &whole);
  parallel_for(builder->chunk_count, chunk_read, builder);
  Range range = {0, 0, box_empty(), box_empty()};
  for (uint32_t i = 0; i < builder->chunk_count; i++) {
    const Chunk *chunk = &builder->chunks[i];
    if (range.end != chunk->begin)
      memmove(builder->prims[0] + range.end, builder->prims[0] + chunk->begin, chunk->count * sizeof(Prim));
    range.end += chunk->count;
    range.bounds = box_union(range.bounds, chunk->bounds);
    range.centroids = box_union(range.centroids, chunk->left_centroids);
  }
  top_add(builder, 0, range.end, range.bounds, 1)->range = range;
}

// Finds the node's split from its chunks' bins, and where each chunk's primitives go.
static void top_split(Builder *builder, TopNode *node)
{
  Bins *bins = &builder->bins[node->first_chunk];
  Chunk *chunks = &builder->chunks[node->first_chunk];
  Bins all = bins[0];
  for (uint32_t i = 1; i < node->chunk_count; i++) bins_merge(&all, &bins[i], &node->map);
  Split *split = &node->split;
  if (!bins_split(split, &all, &node->map, area_scale(node->range.bounds))) return;

  uint32_t left_at = node->range.begin, right_at = left_at + split->left_count;
  node->left = top_add(builder, left_at, right_at, split->left, node->depth + 1);
  node->right = top_add(builder, right_at, node->range.end, split->right, node->depth + 1);
  for (uint32_t i = 0; i < node->chunk_count; i++) {
    uint32_t left = 0;
    for (uint32_t bin = 0; bin < split->bin; bin++) left += (uint32_t)bins[i].count[bin][split->axis];
    chunks[i].left_at = left_at;
    chunks[i].right_at = right_at;
    left_at += left;
    right_at += chunks[i].end - chunks[i].begin - left;
  }
}

// Divides the top of the tree.
static void top_build(Builder *builder)
{
  uint32_t subtree_size = range_count(&builder->top[0].range) / MAX_TOP_RANGES;
  if (subtree_size < MIN_TOP_COUNT) subtree_size = MIN_TOP_COUNT;
  uint32_t level_begin = 0;
  for (int level = 0; level < MAX_TOP_LEVELS; level++) {
    uint32_t level_end = builder->top_count;
    builder->chunk_count = 0;
    for (uint32_t i = level_begin; i < level_end; i++) {
      TopNode *node = &builder->top[i];
      if (range_count(&node->range) > subtree_size && bin_map_make(&node->map, &node->range)) chunks_add(builder, node);
    }
    if (builder->chunk_count == 0) break;
    parallel_for(builder->chunk_count, chunk_bin, builder);
    for (uint32_t i = level_begin; i < level_end; i++)
      if (builder->top[i].chunk_count) top_split(builder, &builder->top[i]);
    parallel_for(builder->chunk_count, chunk_partition, builder);
    for (uint32_t i = 0; i < builder->chunk_count; i++) {
      const Chunk *chunk = &builder->chunks[i];
      if (!chunk->node->left) continue;
      Range *left = &chunk->node->left->range, *right = &chunk->node->right->range;
      left->centroids = box_union(left->centroids, chunk->left_centroids);
      right->centroids = box_union(right->centroids, chunk->right_centroids);
    }
    level_begin = level_end;
  }
}

static void subtree_run(void *context, size_t index)
{
  Builder *builder = context;
  TopNode *subtree = builder->subtrees[index];
  subtree->root = subtree_build(builder, subtree, &subtree->range, subtree->depth);
}

static int subtree_compare(const void *a, const void *b)
{
  const TopNode *first = *(TopNode *const *)a, *second = *(TopNode *const *)b;
  uint32_t x = range_count(&first->range), y = range_count(&second->range);
  return x > y ? -1 : x < y;
}

static void subtrees_build(Builder *builder)
{
  for (uint32_t i = 0; i < builder->top_count; i++)
    if (!builder->top[i].left) builder->subtrees[builder->subtree_count++] = &builder->top[i];
  qsort(builder->subtrees, builder->subtree_count, sizeof *builder->subtrees, subtree_compare);
  parallel_for(builder->subtree_count, subtree_run, builder);
}

// Numbers the nodes depth first and writes those above the subtrees.
static Reference top_place(Builder *builder, TopNode *node)
{
  Bvh2 *tree = &builder->tree;
  if (!node->left) {
    node->first_node = tree->node_count;
    tree->node_count += node->node_count;
    if (node->node_depth > tree->depth) tree->depth = node->node_depth;
    return node->root.count ? node->root : (Reference){node->first_node, 0};
  }
  Bvh2Node *written = &tree->nodes[tree->node_count];
  Reference reference = {tree->node_count++, 0};
  node_set_child(written, 0, node->left->range.bounds, top_place(builder, node->left));
  node_set_child(written, 1, node->right->range.bounds, top_place(builder, node->right));
  return reference;
}

static void subtree_write(void *context, size_t index)
{
  Builder *builder = context;
  const TopNode *subtree = builder->subtrees[index];
  uint32_t next = subtree->first_node;
  subtree_number(builder, subtree->root, &next);
}

static Status builder_allocate(Builder *builder, Log *log)
{
  size_t count = builder->soup->triangle_count, chunks = count / CHUNK + MAX_TOP_RANGES + 1;
  builder->prims[0] = large_array(count, sizeof(Prim));
  builder->prims[1] = large_array(count, sizeof(Prim));
  builder->tree.triangles = large_array(count, sizeof(BvhTriangle));
  builder->chunks = large_array(chunks, sizeof(Chunk));
  builder->bins = large_array(chunks, sizeof(Bins));
  builder->top = large_array(MAX_TOP_NODES, sizeof(TopNode));
  builder->subtrees = large_array(MAX_TOP_NODES, sizeof(TopNode *));
  if (!builder->prims[0] || !builder->prims[1] || !builder->tree.triangles || !builder->chunks || !builder->bins ||
      !builder->top || !builder->subtrees)
    return log_no_memory(log, "BVH");
  return STATUS_OK;
}

// Gathers the subtrees into one array of nodes.
static Status tree_finish(Builder *builder, Log *log)
{
  Bvh2 *tree = &builder->tree;
  tree->triangle_count = builder->top[0].range.end;
  size_t nodes = 1;
  for (uint32_t i = 0; i < builder->top_count; i++) nodes += builder->top[i].left ? 1 : builder->top[i].node_count;
  tree->nodes = large_array(nodes, sizeof(Bvh2Node));
  if (!tree->nodes) return log_no_memory(log, "BVH");

  Reference none = {BVH_EMPTY, 0}, root = none;
  tree->depth = 1;
  if (tree->triangle_count) root = top_place(builder, &builder->top[0]);
  parallel_for(builder->subtree_count, subtree_write, builder);
  if (tree->node_count == 0) {
    node_set_child(&tree->nodes[0], 0, builder->top[0].range.bounds, root);
    node_set_child(&tree->nodes[0], 1, box_empty(), none);
    tree->node_count = 1;
  }
  return STATUS_OK;
}

Status bvh2_build(Bvh2 *out, const TriangleSoup *soup, const BvhOptions *options, Log *log)
{
  Status status = STATUS_OK;
  Builder builder = {.soup = soup, .options = *options};
  if (soup->triangle_count >= 1u << 28)
    return log_fail(log, STATUS_TOO_LARGE, "BVH: %u triangles: split the scene into parts of fewer than 2^28",
                    soup->triangle_count);
  if (options->max_leaf < 1 || options->max_leaf > 8)
    return log_fail(log, STATUS_USAGE, "BVH: max_leaf %u: must be 1 to 8", options->max_leaf);

  TRY(builder_allocate(&builder, log));
  prims_read(&builder);
  if (builder.top[0].range.end > 0) {
    top_build(&builder);
    subtrees_build(&builder);
  }
  TRY(tree_finish(&builder, log));
  *out = builder.tree;

done:
  if (status) bvh2_free(&builder.tree);
  free(builder.prims[0]);
  free(builder.prims[1]);
  free(builder.chunks);
  free(builder.bins);
  free(builder.top);
  free(builder.subtrees);
  return status;
}

void bvh2_free(Bvh2 *bvh)
{
  free(bvh->nodes);
  free(bvh->triangles);
  *bvh = (Bvh2){0};
}
