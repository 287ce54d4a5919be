/* SPDX-License-Identifier: MIT */
/*
 * The hierarchy of boxes in memory, its invariants, and the functions that build it, check it, and trace a ray through
 * it.
 *
 * Nodes have up to sixteen children, leaves up to sixteen triangles. Boxes and corners are stored as arrays of each
 * coordinate, so that one vector operation tests as many of them as it has lanes.
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
 * Leaves have the corners of their triangles, so the tree keeps no other copy, but for each triangle a place in a leaf.
 * Triangles that no leaf has, or none as they were given, have places in quads of their own behind those of leaves:
 * those that are left out, and odd ones (unit.h). A hierarchy of MLRT_PLACE_QUADS quads and more keeps the array
 * tree->triangles, and has no places.
 *
 *   P1. If tree->bvh.places is not NULL, the place of triangle i is in the first bvh.quad_count quads, and bvh.numbers
 *       has i there. The place is in a leaf, and the triangle is neither odd nor left out, or it is in one of the quads
 *       behind leaves, where corners are as they were given.
 *
 * For a leaf with q quads from quad f on, the numbers start at numbers[4 f]. Row 3 i + k of its corners, coordinate k
 * of corner i of its 4 q places, starts at corners[36 f + 4 q (3 i + k)]. Kernels may read both arrays up to 16
 * elements behind the leaf, but do not use these elements.
 *
 * Boxes and corners are in units (unit.h).
 */
#ifndef MLRT_BVH_NODE_H
#define MLRT_BVH_NODE_H

#include <stdint.h>

#include "base/platform.h"
#include "base/progress.h"
#include "exact/hit_list.h"
#include "scene/tree.h"

#define MLRT_BVH_WIDTH       16
#define MLRT_BVH_DEPTH_LIMIT 64
#define MLRT_BVH_LEAF_LIMIT  16 /* triangles */

/* The most boxes that wait while a tree is traversed: of each level all but one, and one more. */
#define MLRT_BVH_STACK_LIMIT ((MLRT_BVH_WIDTH - 1) * MLRT_BVH_DEPTH_LIMIT + 1)

/* Kernels number the slots of all nodes in 32 bits. */
#define MLRT_BVH_NODE_LIMIT (UINT32_MAX / MLRT_BVH_WIDTH)

struct mlrt_bvh_node {
    MLRT_ALIGNED(64) float lo[3][MLRT_BVH_WIDTH];
    MLRT_ALIGNED(64) float hi[3][MLRT_BVH_WIDTH];
    /* A node: its number << 3. A leaf: (first quad << 3) | number of quads, 1..4. An empty slot: 0. */
    MLRT_ALIGNED(64) uint32_t child[MLRT_BVH_WIDTH];
};

/* How many quads a leaf has; 0 for a node. */
static inline uint32_t mlrt_bvh_quad_count(uint32_t child)
{
    return child & 7;
}

/* The number of a node, or the first quad of a leaf. */
static inline uint32_t mlrt_bvh_offset(uint32_t child)
{
    return child >> 3;
}

/* How many triangles a leaf has. */
static inline uint32_t mlrt_bvh_leaf_count(const struct mlrt_bvh *bvh, uint32_t child)
{
    const uint32_t *numbers = bvh->numbers + 4 * (size_t)mlrt_bvh_offset(child);
    uint32_t count = 0;
    while (count < 4 * mlrt_bvh_quad_count(child) && numbers[count] != MLRT_NONE) count++;
    return count;
}

/* ---- build.c --------------------------------------------------------------------------------------------------- */

/*
 * Builds the hierarchy. On entry, tree->triangles and triangle_count are set and the rest is 0, `options` is checked,
 * and the floating-point environment is the library's. Returns a status. With MLRT_OK, tree->bvh, bounds and tree->info
 * are set, except what api/tree.c sets. After an error the hierarchy is empty, and tree->memory holds what it held.
 * MLRT_ERROR_TOO_LARGE: more nodes or quads than there are bits for. Adds about MLRT_BVH_WORK per triangle to
 * `progress` (NULL = none).
 */
int32_t mlrt_build_bvh(struct mlrt_tree *tree, const mlrt_tree_options *options, struct mlrt_progress *progress);

/* The work per triangle, where copying a triangle is 1 (MLRT_COPY_WORK, scene/meshes.h). */
#define MLRT_BVH_WORK 10.0

/*
 * About how many bytes a hierarchy of mlrt_build_bvh takes when it is finished, and at most while it is built, with an
 * mlrt_tree_options that was checked.
 */
struct mlrt_demand mlrt_foresee_bvh(const void *tree_options, uint32_t triangle_count);

/* ---- write.c --------------------------------------------------------------------------------------------------- */

/* Frees the hierarchy of mlrt_build_bvh. tree->bvh is empty then. */
void mlrt_free_bvh(struct mlrt_tree *tree);

/* ---- check.c --------------------------------------------------------------------------------------------------- */

/*
 * Checks that places, if there are any, are within the quads: then mlrt_triangle_at may be called. Returns NULL or the
 * error, a static string.
 */
const char *mlrt_check_places(const struct mlrt_tree *tree);

/*
 * Checks that tracing any ray through the hierarchy is safe: all invariants, but of B3 only that boxes lie within the
 * bounds. Relies on nothing but the lengths of the arrays, finite bounds, and the counts of triangles left out. Returns
 * NULL, or a static string with the first error. Takes linear time.
 */
const char *mlrt_check_boxes(const struct mlrt_tree *tree);

/* ---- ray.c ----------------------------------------------------------------------------------------------------- */

/* Traces one ray in double: trace_ray of the structure (job/structure.h). */
uint32_t mlrt_trace_boxes(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                          struct mlrt_hit_list *list, mlrt_counters *counters);

#endif
