/* SPDX-License-Identifier: MIT */
/*
 * Which nodes of a binary hierarchy become nodes of sixteen: see bvh_collapse.h.
 */
#include "bvh_collapse.h"

#include "platform.h"

void mlrt_choose_leaf(const struct mlrt_bvh_costs *costs, float area, struct mlrt_binary_node *node,
                      struct mlrt_forest_costs *result)
{
    float cost = area * mlrt_bvh_leaf_cost(costs, node->count);
    for (int i = 0; i < MLRT_BVH_WIDTH; i++) {
        node->choice[i] = 0;
        result->cost[i] = cost;
    }
}

/* The cheapest way to share out `slots` children to the two sides. */
MLRT_INLINE float distribute(const struct mlrt_forest_costs children[2], int slots, uint8_t *lower_slots)
{
    float best = children[0].cost[1] + children[1].cost[slots - 1];
    *lower_slots = 1;
    for (int i = 2; i < slots; i++) {
        float cost = children[0].cost[i] + children[1].cost[slots - i];
        if (cost >= best) continue;
        best = cost;
        *lower_slots = (uint8_t)i;
    }
    return best;
}

void mlrt_choose_cut(const struct mlrt_bvh_costs *costs, float area, const struct mlrt_forest_costs children[2],
                     struct mlrt_binary_node *node, struct mlrt_forest_costs *result)
{
    float best = area * costs->node + distribute(children, MLRT_BVH_WIDTH, &node->choice[0]);
    node->choice[1] = 1;
    if (node->count <= MLRT_BVH_LEAF_LIMIT) {
        float leaf = area * mlrt_bvh_leaf_cost(costs, node->count);
        if (leaf <= best) {
            best = leaf;
            node->choice[1] = 0;
        }
    }
    result->cost[0] = result->cost[1] = best;
    for (int i = 2; i < MLRT_BVH_WIDTH; i++) {
        float cost = distribute(children, i, &node->choice[i]);
        if (cost < best)
            best = cost;
        else
            node->choice[i] = 0;
        result->cost[i] = best;
    }
}
