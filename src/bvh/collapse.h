/* SPDX-License-Identifier: MIT */
/*
 * From a binary hierarchy to nodes of sixteen: chooses which binary nodes become nodes and leaves, so that the expected
 * cost is least, and writes these.
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

/* A binary node becomes a leaf, a node of sixteen, or (BOTH) the slots of its two children. */
struct mlrt_cut {
    enum { MLRT_CUT_LEAF, MLRT_CUT_NODE, MLRT_CUT_BOTH } kind;
    uint32_t slots[2]; /* slots of each child, unless it is a leaf */
};

/* The cheapest cut of a binary node that is at most `slots` slots. */
struct mlrt_cut mlrt_cut_of(const struct mlrt_binary_node *node, uint32_t slots);

/* The binary hierarchy. */
struct mlrt_binary_tree {
    struct mlrt_binary_node *nodes;
    uint32_t *triangles; /* the word of each reference: mlrt_reference_word */
};

/* The size of a part of the hierarchy. Counts stay below 2^32, since there are fewer leaves than MLRT_REFERENCE_MARK. */
struct mlrt_bvh_size {
    uint32_t node_count;
    uint32_t quad_count;
    uint32_t slot_count; /* of the node above */
    uint32_t depth;      /* nodes on the longest path from the root */
};

/* Adds the size of the next part, in depth-first order. */
void mlrt_add_size(const struct mlrt_bvh_size *part, struct mlrt_bvh_size *sum);

/* Where the next node, quad and slot are written: behind those that `size` counts. */
struct mlrt_bvh_cursor {
    struct mlrt_bvh_size size;
    uint32_t depth;               /* of the parent */
    struct mlrt_bvh_node *parent; /* the node whose children are written; NULL = nothing is written, only counted */
};

/*
 * Writes what binary node `number` and all below it become, as at most `slots` slots of a node above, into tree->bvh,
 * which has room for it; not all of it if the call is cancelled. Moves the cursor behind it.
 */
void mlrt_write_forest(const struct mlrt_binary_tree *binary, uint32_t number, uint32_t slots, struct mlrt_tree *tree,
                       struct mlrt_progress *progress, struct mlrt_bvh_cursor *cursor);

/* Writes a binary node as a node of sixteen without children, and moves the cursor to its children. */
void mlrt_enter_node(const struct mlrt_binary_node *node, struct mlrt_tree *tree, struct mlrt_bvh_cursor *cursor);

/* Moves the cursor from the end of these children behind their node. `above` is the cursor as it entered the node. */
void mlrt_leave_node(const struct mlrt_bvh_cursor *above, struct mlrt_bvh_cursor *cursor);

/* Makes all slots of a node empty. */
void mlrt_clear_node(struct mlrt_bvh_node *node);

#endif
