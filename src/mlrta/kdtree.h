/* SPDX-License-Identifier: MIT */
/*
 * The kd-tree in memory, its invariants, and the functions that build it, check it, and trace a ray through it.
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
#include "base/progress.h"
#include "exact/hit_list.h"
#include "scene/tree.h"

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

/* ---- build.c -------------------------------------------------------------------------------------------------- */

/*
 * Builds the kd-tree. Before the call, tree->triangles and triangle_count are set and the rest is 0, `options` is an
 * mlrt_kdtree_options that was checked, and the floating-point environment is the library's. `progress` (may be NULL)
 * advances by MLRT_KDTREE_WORK per triangle. Returns a status:
 *
 *   - MLRT_OK: tree->kdtree, bounds and tree->info are set, except what of info api/tree.c sets.
 *   - MLRT_ERROR_OUT_OF_MEMORY, or MLRT_ERROR_TOO_LARGE for more than 2^30 - 1 triangles: nodes and references are
 *     NULL, and tree->memory holds as much as before.
 *   - MLRT_ERROR_CANCELLED: likewise, unless the call is cancelled after the last node: then both are set.
 */
int32_t mlrt_build_nodes(struct mlrt_tree *tree, const void *options, struct mlrt_progress *progress);

/* The work of building per triangle, where copying one is MLRT_COPY_WORK (scene/meshes.h). */
#define MLRT_KDTREE_WORK 60.0

/* Guesses how many bytes mlrt_build_nodes will hold at its end, and at most while it runs. */
struct mlrt_demand mlrt_foresee_nodes(const void *options, uint32_t triangle_count);

/* ---- check.c -------------------------------------------------------------------------------------------------- */

/*
 * Sets all that follows from nodes, references and bounds: float_safe and reach, and in tree->info the depth, the
 * counts of nodes, leaves and references, tree_hash, the bounds, and sah_cost for the two costs given. If the call is
 * cancelled meanwhile, these may be wrong.
 */
void mlrt_measure_tree(struct mlrt_tree *tree, double traversal_cost, double intersection_cost,
                       struct mlrt_progress *progress);

/* Sets float_safe and reach, from planes and bounds. */
void mlrt_find_float_limits(struct mlrt_tree *tree);

/*
 * Checks that any ray can be traced through nodes and references: all invariants but I3, leaves in depth-first order,
 * and no leaf that names a triangle that was left out. Returns NULL, or the first error as a static string. Relies only
 * on the lengths of the arrays, finite bounds, and the counts of triangles left out. Takes linear time.
 */
const char *mlrt_check_nodes(const struct mlrt_tree *tree);

/* ---- ray.c ---------------------------------------------------------------------------------------------------- */

/* Traces one ray, the textbook way, in double: trace_ray of the structure (job/structure.h). */
uint32_t mlrt_trace_cells(const struct mlrt_tree *tree, const struct mlrt_ray_segment *ray, uint32_t skip, int any,
                          struct mlrt_hit_list *list, mlrt_counters *counters);

#endif
