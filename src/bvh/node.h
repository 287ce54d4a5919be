/* SPDX-License-Identifier: MIT */
/*
 * The hierarchy of boxes in memory: nodes of up to sixteen children, leaves of up to sixteen triangles. Boxes and
 * corners are stored as arrays of each coordinate, so that one vector operation tests as many of them as it has lanes.
 * These invariants always hold; check.c verifies them.
 *
 *   B1. The root is nodes[0]; a hierarchy over no triangles has no nodes. Children lie behind their parent, every node
 *       but the root has one parent, and nodes lie in depth-first order.
 *   B2. The children of a node are in slots 0 .. n - 1, 1 <= n <= 16, in no particular order. The boxes of the other
 *       slots are empty: lo = +inf, hi = -inf.
 *   B3. For every triangle that is not left out, and every point p of it, there is a leaf that holds the triangle, and
 *       whose closed box contains p, as do the boxes of all nodes above it. This holds in exact arithmetic: boxes are
 *       rounded outward wherever they are computed. (Without spatial splits a triangle is in one leaf, and all of it
 *       in that leaf's box.)
 *   B4. No path has more than MLRT_BVH_DEPTH_LIMIT nodes.
 *   B5. A leaf holds the numbers of 1 to 16 triangles, each once. It has whole groups of four places ("quads"). Places
 *       behind the last triangle have the number MLRT_NONE and corners that are NaN. The corners of odd triangles
 *       (unit.h) are NaN too.
 *
 * For a leaf with q quads from quad f on, the numbers start at numbers[4 f]. Row 3 i + k of its corners, coordinate k
 * of corner i of its 4 q places, starts at corners[36 f + 4 q (3 i + k)]. Kernels may read both arrays up to 16
 * elements behind the leaf, but do not use these elements.
 *
 * Boxes and corners are in units (unit.h). The arrays also have quads of no leaf, behind those of leaves (places.h).
 */
#ifndef MLRT_BVH_NODE_H
#define MLRT_BVH_NODE_H

#include <stdint.h>

#include "base/platform.h"

#define MLRT_BVH_WIDTH       16
#define MLRT_BVH_DEPTH_LIMIT 32
#define MLRT_BVH_LEAF_LIMIT  16 /* triangles */

/* Kernels number the slots of all nodes in 32 bits. */
#define MLRT_BVH_NODE_LIMIT (UINT32_MAX / MLRT_BVH_WIDTH)

struct mlrt_bvh_node {
    MLRT_ALIGNED(64) float lo[3][MLRT_BVH_WIDTH];
    MLRT_ALIGNED(64) float hi[3][MLRT_BVH_WIDTH];
    /* A node: its number << 3. A leaf: (first quad << 3) | number of quads, 1..4. An empty slot: 0. */
    MLRT_ALIGNED(64) uint32_t child[MLRT_BVH_WIDTH];
};

/* The quads of a leaf; 0 for a node. */
static inline uint32_t mlrt_bvh_quad_count(uint32_t child)
{
    return child & 7;
}

/* The number of a node, or the first quad of a leaf. */
static inline uint32_t mlrt_bvh_offset(uint32_t child)
{
    return child >> 3;
}

#endif
