/* SPDX-License-Identifier: MIT */
/*
 * The builder of the hierarchy of boxes. References are cut in two, over and over, which gives a binary hierarchy;
 * bvh_collapse.c says which of its nodes become nodes of sixteen; these are written in depth-first order.
 *
 * The upper levels are built one after the other, and below them each subtree by itself, shared out to the pool. What
 * becomes of a set depends on its references and its shares of depth and leaves only, and everything has its place
 * before it is made, so the number of threads changes nothing.
 *
 * Two things are bounded for any input:
 *
 *   Leaves. A set of n references has a budget of leaves, at least reserve(n), so that halving it until 16 are left
 *   always stays within. A split that would leave one side with less than its reserve is not made. A binary hierarchy
 *   of b leaves has 2 b - 1 nodes, so each subtree has its own part of the array of nodes.
 *
 *   Depth. A split is made only if both sides can be halved to leaves in the levels that remain. A node of sixteen
 * takes at least one level, so a limit of MLRT_BVH_DEPTH_LIMIT binary levels would do, but is more than most scenes
 * need and less than some do. So it is built with a larger one first, and again with that one only if the result is too
 * deep.
 */
#include "bvh_build.h"

#include <math.h>
#include <string.h>

#include "bvh_check.h"
#include "bvh_collapse.h"
#include "bvh_split.h"
#include "platform.h"
#include "predicate.h"
#include "scheduler.h"

/* ---- settings ------------------------------------------------------------------------------------------------ */

static const struct mlrt_bvh_costs COSTS = {1.0f, 0.5f, 0.05f, 0.03f};

/* References per leaf that the budget allows for on average: memory for nodes while building is 104 / 3 bytes each. */
#define LEAF_SHARE 3

/* Binary levels in the first attempt. It bounds the stack. */
#define BINARY_DEPTH 64

/* Subtrees of at most so many references, or of this part of all, are built by one worker. */
#define ITEM_SIZE  4096
#define ITEM_SHARE 256

#define CHUNK_SIZE 16384

/* Quads and nodes have 29 bits in a child. */
#define COUNT_LIMIT (UINT32_MAX >> 3)

/* ---- one build ----------------------------------------------------------------------------------------------- */

/* A set to be cut, its place among the binary nodes, and what it may use. */
struct task {
    struct mlrt_bvh_set set;
    uint32_t node;
    uint32_t depth;
    uint32_t budget; /* of leaves */
    uint32_t padding;
};

struct build {
    struct mlrt_tree *tree;
    struct mlrt_pool *pool;
    struct mlrt_bvh_costs costs;
    struct mlrt_quad_box *references;
    struct mlrt_binary_node *nodes;
    struct task *tasks;
    struct mlrt_forest_costs *task_costs;
    struct mlrt_bvh_size *task_sizes;
    uint32_t *triangles; /* of the references, in their order */
    uint32_t capacity;   /* references that there is room for */
    uint32_t reference_count;
    uint32_t node_capacity;
    uint32_t task_capacity;
    uint32_t task_count;
    uint32_t task_size; /* sets up to this are tasks */
    uint32_t depth_limit;
    double scene_area;
};

static float relative_area(const struct build *build, const struct mlrt_quad_box *box)
{
    return build->scene_area > 0 ? (float)(mlrt_quad_box_area(box) / build->scene_area) : 1;
}

/* ---- references ---------------------------------------------------------------------------------------------- */

static int is_finite(const struct mlrt_triangle *triangle)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            if (!isfinite(triangle->v[i][k])) return 0;
    return 1;
}

/* + 0 turns -0 into 0. */
static void set_reference(struct mlrt_quad_box *reference, const struct mlrt_triangle *triangle, uint32_t number)
{
    uint32_t bits = number | MLRT_REFERENCE_MARK;
    for (int k = 0; k < 3; k++) {
        float a = triangle->v[0][k], b = triangle->v[1][k], c = triangle->v[2][k];
        float lo = a < b ? a : b, hi = a < b ? b : a;
        reference->lo[k] = (c < lo ? c : lo) + 0.0f;
        reference->hi[k] = (c > hi ? c : hi) + 0.0f;
    }
    memcpy(&reference->lo[3], &bits, sizeof bits);
    reference->hi[3] = 0;
}

/* One reference for each triangle that can be hit. The others are counted. */
static void refer_to_all(struct build *build)
{
    struct mlrt_tree *tree = build->tree;
    uint64_t non_finite_count = 0, zero_area_count = 0;
    for (uint32_t i = 0; i < tree->triangle_count; i++) {
        const struct mlrt_triangle *triangle = &tree->triangles[i];
        if (!is_finite(triangle))
            non_finite_count++;
        else if (!mlrt_triangle_has_area(triangle))
            zero_area_count++;
        else
            set_reference(&build->references[build->reference_count++], triangle, i);
    }
    tree->info.non_finite_count = non_finite_count;
    tree->info.zero_area_count = zero_area_count;
}

/* ---- budgets ------------------------------------------------------------------------------------------------- */

/* Leaves that halving leaves: at least 8 references in each if there are more than 16. */
static uint32_t reserve(uint32_t count)
{
    return count <= MLRT_BVH_LEAF_LIMIT ? 1 : count / 8;
}

/* Levels that halving takes. */
static uint32_t halving_depth(uint32_t count)
{
    uint32_t depth = 0;
    for (; count > MLRT_BVH_LEAF_LIMIT; depth++) count -= count / 2;
    return depth;
}

static uint32_t leaf_budget(uint32_t count)
{
    return count / LEAF_SHARE + 1;
}

/* The lower side's part of a budget that has enough for both reserves: the rest is shared out by size. */
static uint32_t lower_budget(uint32_t budget, uint32_t lower_count, uint32_t upper_count)
{
    uint32_t rest = budget - reserve(lower_count) - reserve(upper_count);
    return reserve(lower_count) + (uint32_t)((uint64_t)rest * lower_count / ((uint64_t)lower_count + upper_count));
}

static int may_split(const struct build *build, const struct task *task, const struct mlrt_bvh_split *split)
{
    uint32_t lower = split->lower_count, upper = task->set.count - lower;
    uint32_t larger = lower > upper ? lower : upper;
    return split->cost < HUGE_VAL && reserve(lower) + reserve(upper) <= task->budget &&
           task->depth + 1 + halving_depth(larger) <= build->depth_limit;
}

/* ---- binary hierarchy ---------------------------------------------------------------------------------------- */

static struct mlrt_binary_node *start_node(const struct build *build, const struct task *task)
{
    struct mlrt_binary_node *node = &build->nodes[task->node];
    memcpy(node->lo, task->set.box.lo, sizeof node->lo);
    memcpy(node->hi, task->set.box.hi, sizeof node->hi);
    node->first = task->set.first;
    node->count = task->set.count;
    node->upper = 0;
    return node;
}

/* A sixteenth of a node is what another child of it costs. */
static int split_pays(const struct build *build, const struct mlrt_bvh_set *set, const struct mlrt_bvh_split *split)
{
    double area = mlrt_quad_box_area(&set->box);
    return split->cost + area * (build->costs.node / MLRT_BVH_WIDTH) <
           area * mlrt_bvh_leaf_cost(&build->costs, set->count);
}

/* Cuts a set in two, unless it is to be a leaf. Returns whether it did. */
static int cut_set(const struct build *build, const struct task *task, struct mlrt_binary_node *node,
                   struct task sides[2])
{
    struct mlrt_bvh_split split;
    struct mlrt_bvh_set sets[2];
    int is_small = task->set.count <= MLRT_BVH_LEAF_LIMIT;
    if (is_small && (task->budget < 2 || task->set.count < 2)) return 0;
    mlrt_find_bvh_split(&build->costs, build->references, &task->set, &split);
    if (!may_split(build, task, &split)) split.cost = HUGE_VAL;
    if (is_small && (split.cost == HUGE_VAL || !split_pays(build, &task->set, &split))) return 0;
    mlrt_apply_bvh_split(build->references, &task->set, &split, sets);
    uint32_t budget = lower_budget(task->budget, sets[0].count, sets[1].count);
    for (int side = 0; side < 2; side++) {
        sides[side].set = sets[side];
        sides[side].depth = task->depth + 1;
        sides[side].budget = side == 0 ? budget : task->budget - budget;
        sides[side].node = side == 0 ? task->node + 1 : task->node + 2 * budget;
    }
    node->upper = sides[1].node;
    return 1;
}

static void build_subtree(const struct build *build, const struct task *task, struct mlrt_forest_costs *costs)
{
    struct mlrt_binary_node *node = start_node(build, task);
    struct task sides[2];
    struct mlrt_forest_costs side_costs[2];
    float area = relative_area(build, &task->set.box);
    if (!cut_set(build, task, node, sides)) {
        mlrt_choose_leaf(&build->costs, area, node, costs);
        return;
    }
    for (int side = 0; side < 2; side++) build_subtree(build, &sides[side], &side_costs[side]);
    mlrt_choose_cut(&build->costs, area, side_costs, node, costs);
}

/* The references of a task have their last order: their numbers are all that is needed from now on. */
static void take_triangles(const struct build *build, const struct mlrt_bvh_set *set)
{
    for (uint32_t i = 0; i < set->count; i++)
        build->triangles[set->first + i] = mlrt_reference_triangle(&build->references[set->first + i]);
}

static MLRT_NOINLINE void run_task(struct build *build, uint32_t item)
{
    build_subtree(build, &build->tasks[item], &build->task_costs[item]);
    take_triangles(build, &build->tasks[item].set);
}

static int32_t run_task_item(void *work, uint32_t item, uint32_t worker)
{
    (void)worker;
    const uint64_t environment = mlrt_enter_fp_environment();
    run_task(work, item);
    mlrt_leave_fp_environment(environment);
    return 0;
}

/* Cuts sets until they are small enough for tasks, and notes these in the order of the hierarchy. */
static void find_tasks(struct build *build, const struct task *task)
{
    struct task sides[2];
    if (task->set.count <= build->task_size || !cut_set(build, task, start_node(build, task), sides)) {
        build->tasks[build->task_count++] = *task;
        return;
    }
    for (int side = 0; side < 2; side++) find_tasks(build, &sides[side]);
}

/* The choices of the upper levels, when the tasks below them are done. */
static void choose_upper(const struct build *build, uint32_t number, uint32_t *next_task,
                         struct mlrt_forest_costs *costs)
{
    struct mlrt_binary_node *node = &build->nodes[number];
    if (*next_task < build->task_count && build->tasks[*next_task].node == number) {
        *costs = build->task_costs[(*next_task)++];
        return;
    }
    struct mlrt_forest_costs side_costs[2];
    struct mlrt_quad_box box;
    memcpy(box.lo, node->lo, sizeof node->lo);
    memcpy(box.hi, node->hi, sizeof node->hi);
    choose_upper(build, number + 1, next_task, &side_costs[0]);
    choose_upper(build, node->upper, next_task, &side_costs[1]);
    mlrt_choose_cut(&build->costs, relative_area(build, &box), side_costs, node, costs);
}

/* ---- nodes of sixteen ---------------------------------------------------------------------------------------- */

static uint32_t quads_of(uint32_t count)
{
    return (count + 3) / 4;
}

static void measure_forest(const struct build *build, uint32_t number, uint32_t slots, uint32_t depth,
                           struct mlrt_bvh_size *size)
{
    const struct mlrt_binary_node *node = &build->nodes[number];
    while (slots > 1 && node->choice[slots] == 0) slots--;
    uint32_t lower_slots = node->choice[slots];
    if (slots == 1) {
        if (node->choice[1] == 0) {
            size->quad_count += quads_of(node->count);
            return;
        }
        size->node_count++;
        depth++;
        if (depth > size->depth) size->depth = depth;
        slots = MLRT_BVH_WIDTH;
        lower_slots = node->choice[0];
    }
    measure_forest(build, number + 1, lower_slots, depth, size);
    measure_forest(build, node->upper, slots - lower_slots, depth, size);
}

static void clear_node(struct mlrt_bvh_node *node)
{
    for (int i = 0; i < MLRT_BVH_WIDTH; i++) {
        for (int k = 0; k < 3; k++) {
            node->lo[k][i] = INFINITY;
            node->hi[k][i] = -INFINITY;
        }
        node->child[i] = 0;
    }
}

/* Ascending, so that the first of equal hits is met first. */
static void sort_numbers(uint32_t *numbers, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        uint32_t number = numbers[i], j = i;
        for (; j > 0 && numbers[j - 1] > number; j--) numbers[j] = numbers[j - 1];
        numbers[j] = number;
    }
}

static void write_leaf(const struct build *build, const struct mlrt_binary_node *node, uint32_t quad)
{
    const struct mlrt_bvh *bvh = &build->tree->bvh;
    uint32_t *numbers = bvh->numbers + 4 * (size_t)quad;
    uint32_t place_count = 4 * quads_of(node->count);
    memcpy(numbers, build->triangles + node->first, node->count * sizeof *numbers);
    sort_numbers(numbers, node->count);
    for (uint32_t place = node->count; place < place_count; place++) numbers[place] = MLRT_NONE;
    float *row = bvh->corners + 36 * (size_t)quad;
    for (uint32_t place = 0; place < place_count; place++) {
        const float *corners = place < node->count ? build->tree->triangles[numbers[place]].v[0] : NULL;
        for (uint32_t i = 0; i < 9; i++) row[i * place_count + place] = corners != NULL ? corners[i] : NAN;
    }
}

static void write_child(struct mlrt_bvh_cursor *cursor, const struct mlrt_binary_node *node, uint32_t child)
{
    for (int k = 0; k < 3; k++) {
        cursor->parent->lo[k][cursor->slot] = node->lo[k];
        cursor->parent->hi[k][cursor->slot] = node->hi[k];
    }
    cursor->parent->child[cursor->slot++] = child;
}

/* Writes a binary node as at most `slots` children of the cursor's node, and all that lies below it. */
static void write_forest(const struct build *build, uint32_t number, uint32_t slots, struct mlrt_bvh_cursor *cursor)
{
    const struct mlrt_binary_node *node = &build->nodes[number];
    while (slots > 1 && node->choice[slots] == 0) slots--;
    if (slots > 1) {
        write_forest(build, number + 1, node->choice[slots], cursor);
        write_forest(build, node->upper, slots - node->choice[slots], cursor);
    } else if (node->choice[1] == 0) {
        write_child(cursor, node, cursor->quad << 3 | quads_of(node->count));
        write_leaf(build, node, cursor->quad);
        cursor->quad += quads_of(node->count);
    } else {
        struct mlrt_bvh_cursor below = {cursor->node + 1, cursor->quad, &build->tree->bvh.nodes[cursor->node], 0};
        write_child(cursor, node, cursor->node << 3);
        clear_node(below.parent);
        write_forest(build, number + 1, node->choice[0], &below);
        write_forest(build, node->upper, MLRT_BVH_WIDTH - node->choice[0], &below);
        cursor->node = below.node;
        cursor->quad = below.quad;
    }
}

/* The root is a node even if one leaf would do. */
static void write_root(const struct build *build)
{
    struct mlrt_bvh_cursor cursor = {1, 0, build->tree->bvh.nodes, 0};
    const struct mlrt_binary_node *root = &build->nodes[0];
    clear_node(cursor.parent);
    if (root->choice[1] == 0) {
        write_forest(build, 0, 1, &cursor);
    } else {
        write_forest(build, 1, root->choice[0], &cursor);
        write_forest(build, root->upper, MLRT_BVH_WIDTH - root->choice[0], &cursor);
    }
}

/* ---- memory -------------------------------------------------------------------------------------------------- */

static void release(const struct build *build, void *block, size_t count, size_t size)
{
    mlrt_free(&build->tree->memory, block, count, size);
}

static int allocate_work(struct build *build)
{
    struct mlrt_memory *memory = &build->tree->memory;
    build->node_capacity = 2 * leaf_budget(build->capacity) - 1;
    build->references = mlrt_allocate(memory, build->capacity, sizeof *build->references);
    build->nodes = mlrt_allocate(memory, build->node_capacity, sizeof *build->nodes);
    build->triangles = mlrt_allocate(memory, build->capacity, sizeof *build->triangles);
    build->tasks = mlrt_allocate(memory, build->task_capacity, sizeof *build->tasks);
    build->task_costs = mlrt_allocate(memory, build->task_capacity, sizeof *build->task_costs);
    return build->references != NULL && build->nodes != NULL && build->triangles != NULL && build->tasks != NULL &&
           build->task_costs != NULL;
}

static void release_references(struct build *build)
{
    release(build, build->references, build->capacity, sizeof *build->references);
    release(build, build->tasks, build->task_capacity, sizeof *build->tasks);
    release(build, build->task_costs, build->task_capacity, sizeof *build->task_costs);
    build->references = NULL;
    build->tasks = NULL;
    build->task_costs = NULL;
}

static void release_work(struct build *build)
{
    release_references(build);
    release(build, build->nodes, build->node_capacity, sizeof *build->nodes);
    release(build, build->triangles, build->capacity, sizeof *build->triangles);
}

void mlrt_free_bvh(struct mlrt_tree *tree)
{
    static const struct mlrt_bvh NONE;
    struct mlrt_bvh *bvh = &tree->bvh;
    mlrt_free(&tree->memory, bvh->nodes, bvh->node_count, sizeof *bvh->nodes);
    mlrt_free(&tree->memory, bvh->corners, 36 * (size_t)bvh->quad_count + 16, sizeof *bvh->corners);
    mlrt_free(&tree->memory, bvh->numbers, 4 * (size_t)bvh->quad_count + 16, sizeof *bvh->numbers);
    *bvh = NONE;
}

static int32_t allocate_result(struct mlrt_tree *tree, const struct mlrt_bvh_size *size)
{
    struct mlrt_bvh *bvh = &tree->bvh;
    if (size->node_count > COUNT_LIMIT || size->quad_count > COUNT_LIMIT) return MLRT_ERROR_TOO_LARGE;
    bvh->node_count = (uint32_t)size->node_count;
    bvh->quad_count = (uint32_t)size->quad_count;
    bvh->nodes = mlrt_allocate(&tree->memory, bvh->node_count, sizeof *bvh->nodes);
    bvh->corners = mlrt_allocate(&tree->memory, 36 * (size_t)bvh->quad_count + 16, sizeof *bvh->corners);
    bvh->numbers = mlrt_allocate(&tree->memory, 4 * (size_t)bvh->quad_count + 16, sizeof *bvh->numbers);
    if (bvh->nodes == NULL || bvh->corners == NULL || bvh->numbers == NULL) return MLRT_ERROR_OUT_OF_MEMORY;
    memset(bvh->corners + 36 * (size_t)bvh->quad_count, 0, 16 * sizeof *bvh->corners);
    memset(bvh->numbers + 4 * (size_t)bvh->quad_count, 0, 16 * sizeof *bvh->numbers);
    return MLRT_OK;
}

/* ---- the whole hierarchy ------------------------------------------------------------------------------------- */

static struct mlrt_bvh_size measure_root(const struct build *build)
{
    struct mlrt_bvh_size size = {0, 0, 0};
    measure_forest(build, 0, 1, 0, &size);
    if (build->nodes[0].choice[1] == 0) size.node_count = size.depth = 1;
    return size;
}

static struct mlrt_bvh_size build_binary(struct build *build, uint32_t depth_limit)
{
    struct task root = {mlrt_measure_set(build->references, 0, build->reference_count), 0, 0,
                        leaf_budget(build->reference_count), 0};
    struct mlrt_forest_costs costs;
    uint32_t next_task = 0;
    build->task_count = 0;
    build->depth_limit = depth_limit;
    build->scene_area = mlrt_quad_box_area(&root.set.box);
    memcpy(build->tree->bounds.lo, root.set.box.lo, sizeof build->tree->bounds.lo);
    memcpy(build->tree->bounds.hi, root.set.box.hi, sizeof build->tree->bounds.hi);
    find_tasks(build, &root);
    mlrt_run_items(build->pool, build->task_count, run_task_item, build);
    choose_upper(build, 0, &next_task, &costs);
    return measure_root(build);
}

static int32_t build_hierarchy(struct build *build)
{
    struct mlrt_tree *tree = build->tree;
    if (!allocate_work(build)) return MLRT_ERROR_OUT_OF_MEMORY;
    refer_to_all(build);
    memset(&tree->bounds, 0, sizeof tree->bounds);
    if (build->reference_count == 0) return MLRT_OK;
    struct mlrt_bvh_size size = build_binary(build, BINARY_DEPTH);
    if (size.depth > MLRT_BVH_DEPTH_LIMIT) size = build_binary(build, MLRT_BVH_DEPTH_LIMIT);
    release_references(build);
    int32_t status = allocate_result(tree, &size);
    if (status == MLRT_OK) write_root(build);
    return status;
}

int32_t mlrt_build_bvh(struct mlrt_tree *tree, const mlrt_build_options *options)
{
    static const struct mlrt_bvh NONE;
    static const struct build NOTHING_BUILT;
    struct build build = NOTHING_BUILT;
    build.tree = tree;
    build.pool = options != NULL ? options->pool : NULL;
    build.costs = COSTS;
    build.capacity = tree->triangle_count;
    build.task_size = build.capacity / ITEM_SHARE > ITEM_SIZE ? build.capacity / ITEM_SHARE : ITEM_SIZE;
    build.task_capacity = BINARY_DEPTH * (build.capacity / build.task_size) + 1; // as many on each level
    tree->bvh = NONE;
    if (tree->triangle_count >= MLRT_REFERENCE_MARK) return MLRT_ERROR_TOO_LARGE;
    int32_t status = build_hierarchy(&build);
    release_work(&build);
    if (status != MLRT_OK) {
        mlrt_free_bvh(tree);
        return status;
    }
    mlrt_measure_bvh(tree, &build.costs);
    return MLRT_OK;
}
