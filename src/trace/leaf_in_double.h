/* SPDX-License-Identifier: MIT */
/*
 * The set-up of a leaf (leaf.h) where float is not enough: odd triangles (bvh/unit.h), and signs that are not certain.
 */
#ifndef MLRT_TRACE_LEAF_IN_DOUBLE_H
#define MLRT_TRACE_LEAF_IN_DOUBLE_H

#include "trace/bundle.h"

/* Gives the odd triangles of a leaf their depths, and outlines that all rays meet. */
void mlrt_set_odd_outlines(const struct mlrt_tree *tree, const struct mlrt_waist *waist, struct mlrt_bundle_leaf *leaf);

/*
 * Sets the coefficients of the odd triangles `odd` from their corners as they were given: in double, where nothing
 * overflows or underflows, and then rounded to float once. If N at the waist is not finite in float, all rays that may
 * hit the triangle are left undecided.
 */
void mlrt_set_up_odd_triangles(const struct mlrt_tree *tree, const struct mlrt_waist *waist, uint32_t odd,
                               struct mlrt_bundle_leaf *leaf);

/*
 * Has the judge determine the signs of N that float does not tell, for rays that start at the waist. If N is 0, no ray
 * from there hits the triangle.
 */
void mlrt_settle_signs(const struct mlrt_tree *tree, const struct mlrt_waist *waist, struct mlrt_bundle_leaf *leaf);

#endif
