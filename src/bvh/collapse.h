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

#include "bvh/node.h"
#include "bvh/split.h"

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

/* When a leaf is written, the triangles of the references so many places behind its own are prefetched. */
#define MLRT_WORDS_AHEAD 32

/*
 * The binary hierarchy. `words` has mlrt_reference_word of each reference. Between sets, and in MLRT_WORDS_AHEAD more
 * places at the end, it is not set.
 */
struct mlrt_binary_tree {
    struct mlrt_binary_node *nodes;
    uint32_t *words;
};

/* The size of a part of the hierarchy. Counts stay below 2^32: there are fewer leaves than MLRT_REFERENCE_MARK. */
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

/* A binary node that one worker makes, and all below it. */
struct mlrt_forest {
    uint32_t node;
    struct mlrt_forest_costs costs;
    uint32_t slots;              /* of the node above, that it may take at most */
    struct mlrt_bvh_cursor from; /* where it is written */
    struct mlrt_bvh_size size;   /* 0 until it is measured */
};

/*
 * Writes what binary node `number` and all below it become, as at most `slots` slots of a node above, into tree->bvh,
 * which has room for it; not all of it if the call is cancelled. Moves the cursor behind it. The forests from `next` on
 * (NULL = there are none), which end with one of no node, are left out: sets `slots` and `from` of each, and moves the
 * cursor by its size.
 */
void mlrt_write_forest(const struct mlrt_binary_tree *binary, uint32_t number, uint32_t slots, struct mlrt_tree *tree,
                       struct mlrt_progress *progress, struct mlrt_forest *next, struct mlrt_bvh_cursor *cursor);

/* Makes all slots of a node empty. */
void mlrt_clear_node(struct mlrt_bvh_node *node);

#endif
