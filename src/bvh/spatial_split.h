/* SPDX-License-Identifier: MIT */
/*
 * Cuts a set of references by a plane. A reference on both sides becomes two. This helps where large triangles lie
 * among small ones: a large one as a whole makes the boxes of both sides overlap, whichever side it is on.
 *
 * Based on: Martin Stich, Heiko Friedrich, Andreas Dietrich, "Spatial Splits in Bounding Volume Hierarchies", 2009.
 */
#ifndef MLRT_BVH_SPATIAL_SPLIT_H
#define MLRT_BVH_SPATIAL_SPLIT_H

#include "base/progress.h"
#include "bvh/split.h"
#include "exact/triangle.h"

/*
 * Adds `count` references, from `first` on, to bins of a set whose box is `box`: to each bin the part of the triangle
 * that lies in it, of which the bounds are estimated.
 */
void mlrt_fill_slabs(const struct mlrt_triangle *triangles, float unit, const struct mlrt_quad_box *references,
                     uint32_t first, uint32_t count, const struct mlrt_quad_box *box, struct mlrt_bvh_bins *bins);

/* Sets *split to the cheapest plane between such bins that has at most `spare` references on both sides. */
void mlrt_choose_plane(const struct mlrt_bvh_costs *costs, const struct mlrt_bvh_bins *bins, uint32_t count,
                       uint32_t spare, struct mlrt_bvh_split *split);

/*
 * Splits a set in place, and sets `sides`. There must be room for split->count[0] + split->count[1] references from
 * set->first on. A reference on both sides stays whole, on one side, where that is cheaper. The upper side lies behind
 * the lower one, possibly with a gap; one side can be empty. If the call is cancelled meanwhile, the references are
 * undefined.
 */
void mlrt_apply_spatial_split(const struct mlrt_triangle *triangles, float unit, struct mlrt_quad_box *references,
                              const struct mlrt_bvh_set *set, const struct mlrt_bvh_split *split,
                              struct mlrt_progress *progress, struct mlrt_bvh_set sides[2]);

#endif
