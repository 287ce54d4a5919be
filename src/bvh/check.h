/* SPDX-License-Identifier: MIT */
/* The statistics of a finished hierarchy of boxes, and a check of the invariants of node.h. */
#ifndef MLRT_BVH_CHECK_H
#define MLRT_BVH_CHECK_H

#include "base/progress.h"
#include "bvh/split.h"
#include "scene/tree.h"

/*
 * A finished hierarchy is measured in parts, each a share of the nodes and of the numbers in leaves. How many they are
 * does not depend on threads, so sums of doubles do not, either.
 */
#define MLRT_BVH_PART_LIMIT 64

struct mlrt_bvh_part {
    double cost; /* sum of cost times area of the children of its nodes */
    uint64_t leaf_count;
    uint64_t reference_count;
    uint64_t hash;
};

/* The number of parts, at most MLRT_BVH_PART_LIMIT. */
uint32_t mlrt_count_parts(const struct mlrt_bvh *bvh);

/* Measures a part. If the call is cancelled meanwhile, values may be wrong. */
void mlrt_measure_part(const struct mlrt_tree *tree, const struct mlrt_bvh_costs *costs, uint32_t number,
                       struct mlrt_progress *progress, struct mlrt_bvh_part *part);

/*
 * Sets the members of tree->info that follow from the hierarchy and all its parts, except depth: the counts of nodes, leaves and
 * references, tree_hash, sah_cost (in units of costs->node), and the bounds.
 */
void mlrt_join_parts(const struct mlrt_bvh_part *parts, const struct mlrt_bvh_costs *costs, struct mlrt_tree *tree);

/*
 * Checks that tracing any ray through the hierarchy is safe: all invariants, but of B3 only that boxes lie within the
 * bounds. Relies on nothing but the lengths of the arrays, finite bounds, and the counts of triangles left out. Returns
 * NULL, or a static string with the first error. Takes linear time and little stack.
 */
const char *mlrt_check_boxes(const struct mlrt_tree *tree);

#endif
