/* SPDX-License-Identifier: MIT */
/*
 * Cuts a set of references by a plane, so that those on both sides become two: for large triangles among small ones,
 * whose boxes would overlap whatever set they are in.
 *
 * Based on: Martin Stich, Heiko Friedrich, Andreas Dietrich, "Spatial Splits in Bounding Volume Hierarchies", 2009.
 */
#ifndef MLRT_BVH_SPATIAL_H
#define MLRT_BVH_SPATIAL_H

#include "base/progress.h"
#include "bvh/split.h"
#include "exact/triangle.h"

/* 16 take an eighth less time to build; expected costs are then 1 % higher in buildings, the same elsewhere. */
#define MLRT_SPATIAL_BINS 32

/* Slabs of equal thickness along each axis, and what they hold of the references. */
struct mlrt_spatial_bins {
    struct mlrt_quad_box box[3][MLRT_SPATIAL_BINS];
    uint32_t first_count[3][MLRT_SPATIAL_BINS]; /* references of which this is the first slab, */
    uint32_t last_count[3][MLRT_SPATIAL_BINS];  /* the last */
};

/* Slabs up to `bin` are the lower side. */
struct mlrt_spatial_split {
    double cost; /* as in mlrt_bvh_split */
    uint32_t axis;
    uint32_t bin;
    uint32_t count[2];           /* references of each side at most: those on both sides count twice */
    struct mlrt_quad_box box[2]; /* about what they are in */
};

void mlrt_clear_spatial_bins(struct mlrt_spatial_bins *bins);

/* Adds `count` references, from `first` on, of a set that lies in `box`. */
void mlrt_fill_spatial_bins(const struct mlrt_triangle *triangles, float unit, const struct mlrt_quad_box *references,
                            uint32_t first, uint32_t count, const struct mlrt_quad_box *box,
                            struct mlrt_spatial_bins *bins);

/* The same result as if the references of both had been added to one. */
void mlrt_merge_spatial_bins(const struct mlrt_spatial_bins *bins, struct mlrt_spatial_bins *sum);

/* The cheapest plane between slabs that makes no more than `spare` references of a set two. */
void mlrt_choose_spatial_split(const struct mlrt_bvh_costs *costs, const struct mlrt_spatial_bins *bins, uint32_t count,
                               uint32_t spare, struct mlrt_spatial_split *split);

/*
 * Deals the references of a set out to both sides, in place; there is room for split->count[0] + split->count[1] of
 * them from set->first on. References that would better be in one side as a whole are. Sides lie one behind the other,
 * maybe with a gap; one can be empty. If the call is cancelled meanwhile, they hold anything.
 */
void mlrt_apply_spatial_split(const struct mlrt_triangle *triangles, float unit, struct mlrt_quad_box *references,
                              const struct mlrt_bvh_set *set, const struct mlrt_spatial_split *split,
                              struct mlrt_progress *progress, struct mlrt_bvh_set sides[2]);

#endif
