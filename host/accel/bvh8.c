#include <math.h>
#include <string.h>

#include "accel/bvh.h"
#include "accel/bvh_cost.h"
#include "base/large_array.h"
#include "base/parallel.h"

enum { TASKS_PER_TREE = 64, MIN_TASK_TRIANGLES = 4096 };

// A subtree of the binary tree: its reference in the parent, and the triangles [first, end) below it.
typedef struct Branch {
  uint32_t child;
  uint32_t source;  // as in Bvh8Node
  uint32_t first, end;
  float bounds[3][2];
} Branch;

typedef struct Task {
  Branch root;
  uint32_t nodes, blocks, depth;     // counted
  uint32_t first_node, first_block;  // given
} Task;

typedef struct Tasks {
  Task *list;
  uint32_t count, capacity;
} Tasks;

// One walk over the tree to be, depth first. It counts where `out` is NULL and writes otherwise. The walk over the top
// leaves branches of fewer than `task_triangles` to tasks: the first time it collects them, the second time it gives
// each its place.
typedef struct Walk {
  const Bvh2 *bvh;
  const Bvh8 *out;
  uint32_t next_node, next_block, depth;
  uint32_t task_triangles;  // 0: no tasks
  Tasks *tasks;
  uint32_t next_task;
  Status status;
} Walk;

static uint32_t branch_triangles(const Branch *branch) { return branch->end - branch->first; }

static uint32_t first_triangle(const Bvh2 *bvh, uint32_t child)
{
  while (!(child & BVH_LEAF)) child = bvh->nodes[child].child[0];
  return child & ~BVH_LEAF;
}

// Replaces a branch of more than eight triangles, whose root is a node of two children, by its two sides.
static void branch_open(Branch *left, Branch *right, const Bvh2 *bvh, Branch branch)
{
  const Bvh2Node *node = &bvh->nodes[branch.child];
  uint32_t middle = first_triangle(bvh, node->child[1]);
  *left = (Branch){.child = node->child[0], .source = 2 * branch.child, .first = branch.first, .end = middle};
  *right = (Branch){.child = node->child[1], .source = 2 * branch.child + 1, .first = middle, .end = branch.end};
  memcpy(left->bounds, node->bounds[0], sizeof left->bounds);
  memcpy(right->bounds, node->bounds[1], sizeof right->bounds);
}

void bvh8_block_fill(Bvh8Block *block, const BvhTriangle *triangles, uint32_t count)
{
  for (uint32_t slot = 0; slot < 8; slot++) {
    const BvhTriangle *triangle = &triangles[slot < count ? slot : count - 1];
    for (int corner = 0; corner < 3; corner++)
      for (int axis = 0; axis < 3; axis++) block->vertex[corner][axis][slot] = triangle->vertex[corner][axis];
    block->id[slot] = triangle->id;
    block->flags[slot] = triangle->flags;
  }
}

static uint32_t walk_node(Walk *walk, const Branch *branch, uint32_t depth);

static uint32_t walk_branch(Walk *walk, const Branch *branch, uint32_t depth)
{
  if (branch_triangles(branch) > 8) return walk_node(walk, branch, depth);
  uint32_t index = walk->next_block++;
  if (walk->out)
    bvh8_block_fill(&walk->out->blocks[index], &walk->bvh->triangles[branch->first], branch_triangles(branch));
  return BVH_LEAF | index;
}

// Up to eight branches that together are `branch`, in its order: the largest that has a node for root opens first.
static uint32_t branch_collapse(Branch children[8], const Bvh2 *bvh, const Branch *branch)
{
  children[0] = *branch;
  if (branch_triangles(branch) <= 8) return branch_triangles(branch) > 0;
  double areas[8];  // of what can be opened, else -1
  areas[0] = 0;
  uint32_t count = 1, largest = 0;
  while (count < 8 && areas[largest] >= 0) {
    for (uint32_t i = count++; i > largest + 1; i--) {
      children[i] = children[i - 1];
      areas[i] = areas[i - 1];
    }
    branch_open(&children[largest], &children[largest + 1], bvh, children[largest]);
    for (uint32_t i = largest; i < largest + 2; i++)
      areas[i] = branch_triangles(&children[i]) > 8 ? bvh_half_area(children[i].bounds) : -1;
    for (uint32_t i = largest = 0; i < count; i++)
      if (areas[i] > areas[largest]) largest = i;
  }
  return count;
}

// Leaves a branch to a task. Returns its node, which is known in the walk that writes.
static uint32_t walk_task(Walk *walk, const Branch *branch, uint32_t depth)
{
  Tasks *tasks = walk->tasks;
  if (walk->out) {
    Task *task = &tasks->list[walk->next_task++];
    task->first_node = walk->next_node;
    task->first_block = walk->next_block;
    walk->next_node += task->nodes;
    walk->next_block += task->blocks;
    return task->first_node;
  }
  if (tasks->count == tasks->capacity) {
    uint32_t capacity = tasks->capacity ? 2 * tasks->capacity : 4 * TASKS_PER_TREE;
    Task *larger = realloc(tasks->list, capacity * sizeof *larger);
    if (!larger) {
      walk->status = STATUS_NO_MEMORY;
      return BVH_EMPTY;
    }
    tasks->list = larger;
    tasks->capacity = capacity;
  }
  tasks->list[tasks->count++] = (Task){.root = *branch, .depth = depth};
  return BVH_EMPTY;
}

static uint32_t walk_node(Walk *walk, const Branch *branch, uint32_t depth)
{
  if (branch_triangles(branch) < walk->task_triangles) return walk_task(walk, branch, depth);
  uint32_t index = walk->next_node++;
  if (depth > walk->depth) walk->depth = depth;
  Branch children[8];
  uint32_t count = branch_collapse(children, walk->bvh, branch);

  Bvh8Node node = {.child = {0}};
  for (uint32_t i = 0; i < 8; i++) {
    for (int axis = 0; axis < 3; axis++) {
      node.bounds[axis][0][i] = i < count ? children[i].bounds[axis][0] : INFINITY;
      node.bounds[axis][1][i] = i < count ? children[i].bounds[axis][1] : -INFINITY;
    }
    node.child[i] = i < count ? walk_branch(walk, &children[i], depth + 1) : BVH_EMPTY;
    node.source[i] = i < count ? children[i].source : BVH_EMPTY;
  }
  if (walk->out) walk->out->nodes[index] = node;
  return index;
}

typedef struct Collapse {
  const Bvh2 *bvh;
  Bvh8 tree;
  Tasks tasks;
} Collapse;

static void task_count(void *context, size_t index)
{
  Collapse *collapse = context;
  Task *task = &collapse->tasks.list[index];
  Walk walk = {.bvh = collapse->bvh};
  walk_node(&walk, &task->root, task->depth);
  task->nodes = walk.next_node;
  task->blocks = walk.next_block;
  task->depth = walk.depth;
}

static void task_write(void *context, size_t index)
{
  Collapse *collapse = context;
  const Task *task = &collapse->tasks.list[index];
  Walk walk = {
      .bvh = collapse->bvh, .out = &collapse->tree, .next_node = task->first_node, .next_block = task->first_block};
  walk_node(&walk, &task->root, 0);
}

Status bvh8_from_bvh2(Bvh8 *out, const Bvh2 *bvh, Log *log)
{
  Status status = STATUS_OK;
  Collapse collapse = {.bvh = bvh};
  Bvh8 *tree = &collapse.tree;
  Branch root = {.child = 0, .source = BVH_EMPTY, .first = 0, .end = bvh->triangle_count};
  for (int axis = 0; axis < 3; axis++) {
    root.bounds[axis][0] = fminf(bvh->nodes[0].bounds[0][axis][0], bvh->nodes[0].bounds[1][axis][0]);
    root.bounds[axis][1] = fmaxf(bvh->nodes[0].bounds[0][axis][1], bvh->nodes[0].bounds[1][axis][1]);
  }
  uint32_t task_triangles = bvh->triangle_count / TASKS_PER_TREE;
  if (task_triangles < MIN_TASK_TRIANGLES) task_triangles = MIN_TASK_TRIANGLES;
  if (bvh->triangle_count < task_triangles) task_triangles = 0;

  Walk top = {.bvh = bvh, .tasks = &collapse.tasks, .task_triangles = task_triangles};
  walk_node(&top, &root, 1);
  if (top.status) {
    status = log_no_memory(log, "BVH");
    goto done;
  }
  parallel_for(collapse.tasks.count, task_count, &collapse);

  tree->node_count = top.next_node;
  tree->block_count = top.next_block;
  tree->depth = top.depth;
  for (uint32_t i = 0; i < collapse.tasks.count; i++) {
    const Task *task = &collapse.tasks.list[i];
    tree->node_count += task->nodes;
    tree->block_count += task->blocks;
    if (task->depth > tree->depth) tree->depth = task->depth;
  }
  tree->nodes = large_array(tree->node_count, sizeof(Bvh8Node));
  tree->blocks = large_array(tree->block_count, sizeof(Bvh8Block));
  if (!tree->nodes || !tree->blocks) {
    status = log_no_memory(log, "BVH");
    goto done;
  }

  Walk place = {.bvh = bvh, .out = tree, .tasks = &collapse.tasks, .task_triangles = task_triangles};
  walk_node(&place, &root, 1);
  parallel_for(collapse.tasks.count, task_write, &collapse);
  *out = *tree;

done:
  if (status) bvh8_free(tree);
  free(collapse.tasks.list);
  return status;
}

void bvh8_free(Bvh8 *bvh)
{
  free(bvh->nodes);
  free(bvh->blocks);
  *bvh = (Bvh8){0};
}
