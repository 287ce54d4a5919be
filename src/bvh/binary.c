/* SPDX-License-Identifier: MIT */
/*
 * The binary hierarchy. Its upper sets are cut level by level. All workers of the pool fill the bins of a set that has
 * much of its level; the other sets of the level are cut by one worker each. Below them are subtrees (tasks), each
 * built by one worker.
 */
#include "bvh/build.h"

#include <string.h>

/* Sets the binary node of a portion, without children. Returns it. */
static struct mlrt_binary_node *start_node(const struct mlrt_bvh_build *build, const struct mlrt_portion *portion)
{
    struct mlrt_binary_node *node = &build->binary.nodes[portion->node];
    memcpy(node->lo, portion->set.box.lo.x, sizeof node->lo);
    memcpy(node->hi, portion->set.box.hi.x, sizeof node->hi);
    node->first = portion->set.first;
    node->count = portion->set.count;
    node->upper = 0;
    return node;
}

/* Builds a subtree, with its binary nodes one behind the other. Returns the number behind the last of them. */
static uint32_t build_subtree(struct mlrt_bvh_build *build, struct mlrt_portion *portion, struct mlrt_slot_costs *costs)
{
    struct mlrt_binary_node *node = start_node(build, portion);
    struct mlrt_portion sides[2];
    struct mlrt_slot_costs side_costs[2];
    if (!mlrt_cut_portion(build, portion, sides)) {
        mlrt_choose_leaf(build, node, costs);
        for (uint32_t i = node->first; i < node->first + node->count; i++)
            build->binary.words[i] = mlrt_reference_word(&build->references.boxes[i]);
        return portion->node + 1;
    }
    sides[1].node = node->upper = build_subtree(build, &sides[0], &side_costs[0]);
    const uint32_t end = build_subtree(build, &sides[1], &side_costs[1]);
    mlrt_choose_cut(build, side_costs, node, costs);
    return end;
}

static void build_task(struct mlrt_bvh_build *build, uint32_t item, uint32_t worker)
{
    (void)worker;
    build_subtree(build, build->work.tasks[item], &build->work.subtrees[item].costs);
}

/* Cuts a set of the level, unless cut_level has cut it already, with bins that all workers filled. */
static void cut_item(struct mlrt_bvh_build *build, uint32_t item, uint32_t worker)
{
    struct mlrt_portion *portion = build->work.level[item];
    struct mlrt_portion *sides = &build->work.portions[build->work.portion_count + 2 * item];
    (void)worker;
    if (build->work.shared == NULL && portion->set.count >= build->work.least_shared) return;
    struct mlrt_binary_node *node = start_node(build, portion);
    if (mlrt_cut_portion(build, portion, sides)) node->upper = sides[1].node;
}

/* Cuts the sets of a level: first those that have much of it, with bins that all workers fill, then the others. */
static void cut_level(struct mlrt_bvh_build *build, uint32_t count)
{
    const uint64_t worker_count = mlrt_worker_count(build->pool);
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += build->work.level[i]->set.count;
    const uint64_t much = 3 * sum / (2 * worker_count), least = 2 * MLRT_CHUNK_SIZE + 1;
    build->work.least_shared = much > least ? much : least; /* more than `sum` for one worker */
    for (uint32_t i = 0; i < count; i++) {
        build->work.shared = build->work.level[i];
        if (build->work.level[i]->set.count >= build->work.least_shared) cut_item(build, i, 0);
    }
    build->work.shared = NULL;
    mlrt_run_step(build, count, cut_item);
    build->work.portion_count += 2 * count;
}

/* Adds a task to those in depth-first order, which is that of the numbers of their nodes. */
static void add_task(struct mlrt_bvh_build *build, struct mlrt_portion *portion)
{
    uint32_t i = build->work.task_count++;
    for (; i > 0 && build->work.tasks[i - 1]->node > portion->node; i--)
        build->work.tasks[i] = build->work.tasks[i - 1];
    build->work.tasks[i] = portion;
}

/* Adds a set to the first `count` of a level: the largest comes first, so that no worker begins it when others end. */
static void add_to_level(struct mlrt_bvh_build *build, struct mlrt_portion *portion, uint32_t count)
{
    uint32_t i = count;
    for (; i > 0 && build->work.level[i - 1]->set.count < portion->set.count; i--)
        build->work.level[i] = build->work.level[i - 1];
    build->work.level[i] = portion;
}

/* Cuts portions[0], level by level, until the parts are small enough for tasks. */
static void find_tasks(struct mlrt_bvh_build *build)
{
    build->work.portion_count = 1;
    for (uint32_t i = 0; i < build->work.portion_count && !mlrt_is_cancelled(build->progress);) {
        uint32_t count = 0;
        for (; i < build->work.portion_count; i++) {
            struct mlrt_portion *portion = &build->work.portions[i];
            if (portion->set.count <= build->limits.task_size)
                add_task(build, portion);
            else
                add_to_level(build, portion, count++);
        }
        cut_level(build, count);
    }
    for (uint32_t i = 0; i <= build->work.task_count; i++)
        build->work.subtrees[i] =
            (struct mlrt_bvh_subtree){.node = i < build->work.task_count ? build->work.tasks[i]->node : UINT32_MAX};
}

/* Sets the choices of the nodes above the tasks, all of which have set theirs. `next` is the first task of the rest. */
static void choose_upper(const struct mlrt_bvh_build *build, uint32_t number, const struct mlrt_bvh_subtree **next,
                         struct mlrt_slot_costs *costs)
{
    if ((*next)->node == number) {
        *costs = (*next)++->costs;
        return;
    }
    struct mlrt_binary_node *node = &build->binary.nodes[number];
    struct mlrt_slot_costs side_costs[2];
    choose_upper(build, number + 1, next, &side_costs[0]);
    choose_upper(build, node->upper, next, &side_costs[1]);
    mlrt_choose_cut(build, side_costs, node, costs);
}

int32_t mlrt_build_binary(struct mlrt_bvh_build *build)
{
    struct mlrt_portion *root = &build->work.portions[0];
    root->set = build->references.whole;
    root->spare = build->limits.capacity - build->references.whole.count;
    root->node = root->depth = root->failed_count = 0;
    root->budget = build->limits.leaf_limit;
    struct mlrt_slot_costs costs;
    const struct mlrt_bvh_subtree *next = build->work.subtrees;
    build->scene_area = area_between(build->tree->bvh.core.lo, build->tree->bvh.core.hi);
    build->work.task_count = 0;
    find_tasks(build);
    if (!mlrt_is_cancelled(build->progress)) mlrt_run_step(build, build->work.task_count, build_task);
    if (mlrt_is_cancelled(build->progress)) return MLRT_ERROR_CANCELLED;
    choose_upper(build, 0, &next, &costs);
    return MLRT_OK;
}
