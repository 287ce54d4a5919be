/* SPDX-License-Identifier: MIT */
/*
 * The bounding volume hierarchy in memory: sixteen boxes a node, up to sixteen triangles a leaf, both as arrays so that
 * one instruction looks at as many of them as it is wide. With what always holds; check.c verifies it.
 *
 *   B1. The root is nodes[0]; a hierarchy over no triangles has no nodes. Children lie behind their parent, every node
 *       but the root has one parent, and nodes lie in depth-first order.
 *   B2. The children of a node are in slots 0 .. n - 1, 1 <= n <= 16, in no particular order. The boxes of the other
 *       slots are empty: lo = +inf, hi = -inf.
 *   B3. A child's box contains every part of the triangles below it that the child stands for; for every triangle that
 *       was not left out, and every point p of it, some leaf whose closed box, and those of the nodes above it, contain
 * p holds the triangle. Here arithmetic is exact: boxes are rounded outward wherever they are computed. (A builder
 *       without spatial splits has each triangle in one leaf, all of it in the box.)
 *   B4. No path has more than MLRT_BVH_DEPTH_LIMIT nodes.
 *   B5. A leaf holds triangles by their numbers, each once, and 1 to 16 of them. It takes whole groups of four places
 *       ("quads"); places behind the last triangle have number MLRT_NONE and corners that are NaN. So are those of odd
 *       triangles.
 *
 * Leaves with q quads from quad f on: row 3 i + k of the corners, which is coordinate k of corner i of all its 4 q
 * triangles, starts at corners[36 f + 4 q (3 i + k)], and their numbers at numbers[4 f]. Both arrays may be read (not
 * used) up to 16 elements behind what belongs to a leaf.
 *
 * Boxes and corners are in units (unit.h).
 */
#ifndef MLRT_BVH_NODE_H
#define MLRT_BVH_NODE_H

#include <stdint.h>

#include "base/platform.h"

#define MLRT_BVH_WIDTH       16
#define MLRT_BVH_DEPTH_LIMIT 32
#define MLRT_BVH_LEAF_LIMIT  16 /* triangles */

/* Boxes are in units (unit.h). */
struct mlrt_bvh_node {
    MLRT_ALIGNED(64) float lo[3][MLRT_BVH_WIDTH];
    MLRT_ALIGNED(64) float hi[3][MLRT_BVH_WIDTH];
    /* Inner: node << 3. Leaf: (first quad << 3) | quads of it, 1..4. Empty slot: 0. */
    MLRT_ALIGNED(64) uint32_t child[MLRT_BVH_WIDTH];
};

static inline uint32_t mlrt_bvh_quad_count(uint32_t child)
{
    return child & 7;
}

static inline uint32_t mlrt_bvh_offset(uint32_t child)
{
    return child >> 3;
}

#endif
