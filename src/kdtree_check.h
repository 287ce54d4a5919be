/* SPDX-License-Identifier: MIT */
/*
 * Looks over a finished tree: its statistics, and whether it keeps the invariants of kdtree.h.
 */
#ifndef MLRT_KDTREE_CHECK_H
#define MLRT_KDTREE_CHECK_H

#include "kdtree.h"

/*
 * Sets what follows from nodes, references and bounds: float_safe, and in info depth, the counts of nodes and
 * references, tree_hash, sah_cost for these costs, and the bounds.
 */
void mlrt_measure_tree(struct mlrt_tree *tree, double traversal_cost, double intersection_cost);

/*
 * NULL if the tree keeps invariants I1 to I5, or else what is wrong, as a static string. I3 is checked for points of
 * each triangle that double arithmetic holds exactly: its vertices, and points of edges and inside where possible.
 */
const char *mlrt_check_tree(const struct mlrt_tree *tree);

#endif
