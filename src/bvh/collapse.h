/* SPDX-License-Identifier: MIT */
/*
 * From a binary hierarchy to nodes of sixteen: which of its nodes become nodes and leaves, so that the expected cost is
 * the least there is.
 *
 * Based on: Henri Ylitie, Tero Karras, Samuli Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
 * Wide BVHs", 2017, section 3 (the cut by dynamic programming).
 */
#ifndef MLRT_BVH_COLLAPSE_H
#define MLRT_BVH_COLLAPSE_H

#include "base/progress.h"
#include "bvh/node.h"
#include "bvh/split.h"
#include "scene/tree.h"

/*
 * A node of the binary hierarchy. The lower child is the next in the array.
 *
 * `choice` says what is cheapest. choice[i], 2 <= i <= 15: as at most i children of a node above, the lower child gets
 * so many of them and the upper one the others; 0 = i - 1 children are enough. choice[1]: 0 = as one child it is a
 * leaf, 1 = it is a node. choice[0]: of that node's sixteen children, the lower child gets so many.
 */
struct mlrt_binary_node {
    float lo[3];
    float hi[3];
    uint32_t first; /* its triangles among all references */
    uint32_t count;
    uint32_t upper; /* the upper child; 0 = it has no children */
    uint8_t choice[MLRT_BVH_WIDTH];
};

/* cost[i]: what a binary node costs as at most i children of a node, times its area. cost[0] is not used. */
struct mlrt_forest_costs {
    float cost[MLRT_BVH_WIDTH];
};

/* The choices and costs of a binary node with no children: 1 to 16 triangles. `area` is relative to the scene's. */
void mlrt_choose_leaf(const struct mlrt_bvh_costs *costs, float area, struct mlrt_binary_node *node,
                      struct mlrt_forest_costs *result);

/* The choices and costs of one with two, by theirs. */
void mlrt_choose_cut(const struct mlrt_bvh_costs *costs, float area, const struct mlrt_forest_costs children[2],
                     struct mlrt_binary_node *node, struct mlrt_forest_costs *result);

/* What a binary node becomes as at most so many children of a node: one, or those of its own children. */
struct mlrt_cut {
    enum { MLRT_CUT_LEAF, MLRT_CUT_NODE, MLRT_CUT_BOTH } kind;
    uint32_t slots[2]; /* of its children, if it is not a leaf */
};

struct mlrt_cut mlrt_cut_of(const struct mlrt_binary_node *node, uint32_t slots);

/* The binary hierarchy, and the numbers of the triangles that it refers to. */
struct mlrt_binary_tree {
    struct mlrt_binary_node *nodes;
    uint32_t *triangles;
};

/* What a binary node and all below it become. */
struct mlrt_bvh_size {
    uint64_t node_count;
    uint64_t quad_count;
    uint32_t slot_count; /* children of the node above */
    uint32_t depth;      /* nodes on the longest path */
};

/* Where nodes and quads go next, and the node whose children are written. */
struct mlrt_bvh_cursor {
    uint32_t node;
    uint32_t quad;
    uint32_t slot;
    struct mlrt_bvh_node *parent;
};

/* Adds what binary node `number` becomes as at most `slots` children of a node at that depth. */
void mlrt_measure_forest(const struct mlrt_binary_tree *binary, uint32_t number, uint32_t slots, uint32_t depth,
                         struct mlrt_bvh_size *size);

/* Writes it, or a part of it if the call is to end. There is room for it in tree->bvh. */
void mlrt_write_forest(const struct mlrt_binary_tree *binary, uint32_t number, uint32_t slots, struct mlrt_tree *tree,
                       struct mlrt_progress *progress, struct mlrt_bvh_cursor *cursor);

/* Writes a binary node as a node of sixteen with no children yet. Returns where these go. */
struct mlrt_bvh_cursor mlrt_start_node(const struct mlrt_binary_node *node, struct mlrt_tree *tree,
                                       struct mlrt_bvh_cursor *cursor);

/* Makes all slots of a node empty. */
void mlrt_clear_node(struct mlrt_bvh_node *node);

#endif
