/* SPDX-License-Identifier: MIT */
/*
 * Looks over a finished tree: its statistics, and whether it keeps the invariants of kdtree.h.
 */
#ifndef MLRT_MLRTA_CHECK_H
#define MLRT_MLRTA_CHECK_H

#include "base/progress.h"
#include "scene/tree.h"

/*
 * Sets what follows from nodes, references and bounds: float_safe, and in info depth, the counts of nodes and
 * references, tree_hash, sah_cost for these costs, and the bounds. If the call is cancelled meanwhile, all this may be
 * wrong.
 */
void mlrt_measure_tree(struct mlrt_tree *tree, double traversal_cost, double intersection_cost,
                       struct mlrt_progress *progress);

/* Sets float_safe, from planes and bounds. */
void mlrt_find_float_safety(struct mlrt_tree *tree);

/*
 * NULL if nodes and references are such that any ray may go through them, or else what is wrong: all invariants but I3,
 * and leaves in depth-first order that name no triangle that was left out. Nothing is trusted but the length of the
 * arrays, that bounds are finite, and the counts of triangles left out. Takes linear time and little stack.
 */
const char *mlrt_check_nodes(const struct mlrt_tree *tree);

/*
 * NULL if the tree keeps invariants I1 to I5, or else what is wrong, as a static string. I3 is checked for points of
 * each triangle that double arithmetic holds exactly: its vertices, and points of edges and inside where possible.
 */
const char *mlrt_check_tree(const struct mlrt_tree *tree);

#endif
