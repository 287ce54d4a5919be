/* SPDX-License-Identifier: MIT */
/*
 * The kd-tree in memory and its invariants, which check.c checks.
 *
 * Nodes are 8 bytes. The root is nodes[0]; the two children of an inner node are adjacent, the lower one first, and the
 * tree lies in depth-first order: all nodes below the first child come before all below the second.
 *
 *   I1. Children lie behind their parent: child > parent. Every node but the root has one parent; node_count is odd.
 *   I2. A cell is a closed box. The root's is `bounds`; a plane x_k = c with lo_k <= c <= hi_k splits a cell into
 *       [lo, hi with hi_k = c] and [lo with lo_k = c, hi]. c == lo_k or c == hi_k makes a cell of zero thickness.
 *   I3. For every triangle that was not left out, and every point p of it, at least one leaf whose closed cell contains
 *       p refers to the triangle. (Not every such leaf: a triangle that only touches a plane is on one side of it.)
 *       This holds in exact arithmetic, since bounds are rounded outward wherever they are computed.
 *   I4. No path has more than MLRT_DEPTH_LIMIT inner nodes.
 *   I5. The entries of a leaf are ascending triangle numbers, each once.
 */
#ifndef MLRT_MLRTA_KDTREE_H
#define MLRT_MLRTA_KDTREE_H

#include "base/forms.h"

struct mlrt_node {
    union {
        float split;     /* inner: the plane x_axis = split */
        uint32_t offset; /* leaf: its first entry in references[] */
    } u;
    uint32_t word; /* inner: (first child << 2) | axis; leaf: (entry count << 2) | 3 */
};

static inline int mlrt_node_is_leaf(const struct mlrt_node *node)
{
    return (node->word & 3) == 3;
}

static inline uint32_t mlrt_node_axis(const struct mlrt_node *node)
{
    return node->word & 3;
}

static inline uint32_t mlrt_node_child(const struct mlrt_node *node)
{
    return node->word >> 2;
}

static inline uint32_t mlrt_leaf_count(const struct mlrt_node *node)
{
    return node->word >> 2;
}

#endif
