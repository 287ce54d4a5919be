/* SPDX-License-Identifier: MIT */
/*
 * Looks over a finished hierarchy of boxes: its statistics, and whether it keeps the invariants of node.h.
 */
#ifndef MLRT_BVH_CHECK_H
#define MLRT_BVH_CHECK_H

#include "base/progress.h"
#include "bvh/split.h"
#include "scene/tree.h"

/*
 * Sets tree->bvh.float_safe, tree->float_safe and what follows from the hierarchy in tree->info: depth, the counts of nodes and references, tree_hash, sah_cost for these costs in units of a node's,
 * the bounds, and the peak of memory. If the call is cancelled meanwhile, all this may be wrong.
 */
void mlrt_measure_bvh(struct mlrt_tree *tree, const struct mlrt_bvh_costs *costs, struct mlrt_progress *progress);

/*
 * NULL if the hierarchy is such that any ray may go through it, or else what is wrong: all invariants, but of B3 only
 * that boxes lie within the bounds. Nothing is trusted but the length of the arrays, that bounds are finite, and the
 * counts of triangles left out. Takes linear time and little stack.
 */
const char *mlrt_check_boxes(const struct mlrt_tree *tree);

/*
 * NULL if the hierarchy keeps invariants B1 to B5, or else what is wrong, as a static string. B3 is checked for points
 * of each triangle that double arithmetic holds exactly: its vertices, and points of edges and inside where possible.
 */
const char *mlrt_check_bvh(const struct mlrt_tree *tree);

#endif
