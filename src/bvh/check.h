/* SPDX-License-Identifier: MIT */
/* The statistics of a finished hierarchy of boxes, and a check of the invariants of node.h. */
#ifndef MLRT_BVH_CHECK_H
#define MLRT_BVH_CHECK_H

#include "base/progress.h"
#include "bvh/split.h"
#include "scene/tree.h"

/*
 * Sets the members of tree->info that follow from the hierarchy: depth, the counts of nodes,
 * leaves and references, tree_hash, sah_cost (in units of costs->node), the bounds, and the peak of memory. If the call
 * is cancelled meanwhile, these values may be wrong.
 */
void mlrt_measure_bvh(struct mlrt_tree *tree, const struct mlrt_bvh_costs *costs, struct mlrt_progress *progress);

/*
 * Checks that tracing any ray through the hierarchy is safe: all invariants, but of B3 only that boxes lie within the
 * bounds. Relies on nothing but the lengths of the arrays, finite bounds, and the counts of triangles left out. Returns
 * NULL, or a static string with the first error. Takes linear time and little stack.
 */
const char *mlrt_check_boxes(const struct mlrt_tree *tree);

#endif
