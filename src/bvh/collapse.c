/* SPDX-License-Identifier: MIT */
/*
 * From a binary hierarchy to nodes of sixteen: chooses which binary nodes become nodes and leaves, so that the expected
 * cost is least. write.c writes these.
 *
 * Based on: Henri Ylitie, Tero Karras, Samuli Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
 * Wide BVHs", 2017, section 3 (the cut by dynamic programming).
 */
#include "bvh/build.h"

#include <string.h>

#include "base/tuning.h"

/* The area of a node relative to the scene's, at most 1. */
static float relative_area(const struct mlrt_bvh_build *build, const struct mlrt_binary_node *node)
{
    const double area = area_between(node->lo, node->hi);
    return area < build->scene_area ? (float)(area / build->scene_area) : 1;
}

void mlrt_choose_leaf(const struct mlrt_bvh_build *build, struct mlrt_binary_node *node, struct mlrt_slot_costs *result)
{
    memset(node->choice, 0, sizeof node->choice);
    result->cost[1] = relative_area(build, node) * set_cost(&build->costs, node->count);
    result->slot_count = 1;
}

/*
 * The least cost of two children in `slots` slots, at least 2 and at most those that they can use. Sets *lower_slots to
 * the number that the lower child gets.
 */
static float distribute(const struct mlrt_slot_costs children[2], int slots, uint8_t *lower_slots)
{
    const int spare = slots - children[1].slot_count, first = spare > 1 ? spare : 1;
    const int last = children[0].slot_count < slots ? children[0].slot_count : slots - 1;
    float best = children[0].cost[first] + children[1].cost[slots - first];
    *lower_slots = (uint8_t)first;
    for (int i = first + 1; i <= last; i++) {
        float cost = children[0].cost[i] + children[1].cost[slots - i];
        if (cost >= best) continue;
        best = cost;
        *lower_slots = (uint8_t)i;
    }
    return best;
}

void mlrt_choose_cut(const struct mlrt_bvh_build *build, const struct mlrt_slot_costs children[2],
                     struct mlrt_binary_node *node, struct mlrt_slot_costs *result)
{
    const float area = relative_area(build, node);
    const int usable = children[0].slot_count + children[1].slot_count;
    const int most = usable < MLRT_NODE_CHILDREN ? usable : MLRT_NODE_CHILDREN;
    float best = area * build->costs.node + distribute(children, most, &node->choice[0]);
    memset(node->choice + 1, 0, sizeof node->choice - 1);
    node->choice[1] = 1;
    if (node->count <= MLRT_LEAF_TRIANGLES) {
        float leaf = area * set_cost(&build->costs, node->count);
        if (leaf <= best) {
            best = leaf;
            node->choice[1] = 0;
        }
    }
    result->cost[1] = best;
    result->slot_count = most < MLRT_NODE_CHILDREN ? most : MLRT_NODE_CHILDREN - 1;
    for (int i = 2; i <= result->slot_count; i++) {
        float cost = distribute(children, i, &node->choice[i]);
        if (cost < best)
            best = cost;
        else
            node->choice[i] = 0;
        result->cost[i] = best;
    }
}
