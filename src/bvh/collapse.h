/* SPDX-License-Identifier: MIT */
/*
 * From a binary hierarchy to nodes of sixteen: chooses which binary nodes become nodes and leaves, so that the expected
 * cost is least. write.c writes these.
 *
 * Based on: Henri Ylitie, Tero Karras, Samuli Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
 * Wide BVHs", 2017, section 3 (the cut by dynamic programming).
 */
#ifndef MLRT_BVH_COLLAPSE_H
#define MLRT_BVH_COLLAPSE_H

#include "bvh/node.h"
#include "bvh/set.h"

/*
 * A node of the binary hierarchy. Its lower child is the next one in the array.
 *
 * `choice` is the cheapest way to make the node at most i slots (children) of a node above. choice[i], 2 <= i <= 15:
 * how many of the i slots the lower child gets, and the upper child the others; 0 = as for i - 1 slots. choice[1]:
 * 0 = one slot is a leaf, 1 = it is a node. choice[0]: how many of that node's sixteen slots the lower child gets.
 */
struct mlrt_binary_node {
    float lo[3];
    float hi[3];
    uint32_t first; /* its references: `count` of them from this one on */
    uint32_t count;
    uint32_t upper; /* the upper child; 0 = the node has no children */
    uint8_t choice[MLRT_BVH_WIDTH];
};

/*
 * cost[i], 1 <= i <= slot_count: the least cost, times area, of a binary node and all below it as at most i slots. More
 * slots would be of no use, or there are no more.
 */
struct mlrt_forest_costs {
    float cost[MLRT_BVH_WIDTH];
    int slot_count;
};

/* Sets choices and costs of a binary node without children, of 1 to 16 triangles. `area` is relative to the scene's. */
void mlrt_choose_leaf(const struct mlrt_bvh_costs *costs, float area, struct mlrt_binary_node *node,
                      struct mlrt_forest_costs *result);

/* Sets choices and costs of a binary node with two children, from the costs of these. */
void mlrt_choose_cut(const struct mlrt_bvh_costs *costs, float area, const struct mlrt_forest_costs children[2],
                     struct mlrt_binary_node *node, struct mlrt_forest_costs *result);

#endif
