/* SPDX-License-Identifier: MIT */
/*
 * The statistics of a finished kd-tree, and whether it keeps the invariants of kdtree.h.
 */
#ifndef MLRT_MLRTA_CHECK_H
#define MLRT_MLRTA_CHECK_H

#include "base/progress.h"
#include "scene/tree.h"

/*
 * Sets all that follows from nodes, references and bounds: float_safe, and in tree->info the depth, the counts of
 * nodes, leaves and references, tree_hash, the bounds, and sah_cost for the two costs given. If the call is cancelled
 * meanwhile, these may be wrong.
 */
void mlrt_measure_tree(struct mlrt_tree *tree, double traversal_cost, double intersection_cost,
                       struct mlrt_progress *progress);

/* Sets float_safe, from planes and bounds. */
void mlrt_find_float_safety(struct mlrt_tree *tree);

/*
 * Checks that any ray can be traced through nodes and references: all invariants but I3, leaves in depth-first order,
 * and no leaf that names a triangle that was left out. Returns NULL, or the first error as a static string. Relies only
 * on the lengths of the arrays, finite bounds, and the counts of triangles left out. Takes linear time and little
 * stack.
 */
const char *mlrt_check_nodes(const struct mlrt_tree *tree);

#endif
