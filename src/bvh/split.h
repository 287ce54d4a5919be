/* SPDX-License-Identifier: MIT */
/*
 * Where to cut a set of references in two: the surface area heuristic over their centres. Pure functions: they look at
 * the references of one set and keep nothing.
 *
 * Based on: Ingo Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007 (bins of centres). Jeffrey
 * Goldsmith, John Salmon, "Automatic Creation of Object Hierarchies for Ray Tracing", 1987 (the heuristic).
 */
#ifndef MLRT_BVH_SPLIT_H
#define MLRT_BVH_SPLIT_H

#include "base/progress.h"
#include "bvh/set.h"

/* Sets up to this are split at the best of all places. Above, bins are as good and take less time. */
#define MLRT_SWEEP_LIMIT 32

/* With 16 expected costs are 0.3 % higher, with 64 no lower. */
#define MLRT_BVH_BINS 32

struct mlrt_bvh_bins {
    struct mlrt_quad_box box[3][MLRT_BVH_BINS];
    uint32_t count[3][MLRT_BVH_BINS];
};

struct mlrt_bvh_split {
    double cost; /* area times cost of both sides; HUGE_VAL = there is no such split */
    uint32_t axis;
    uint32_t bin;                    /* bins up to this one are the lower side */
    uint32_t lower_count;            /* references on the lower side */
    int sorted;                      /* 1 = the lower side is the first lower_count of `order`; there are no bins */
    uint8_t order[MLRT_SWEEP_LIMIT]; /* positions in the set */
    struct mlrt_quad_box box[2];     /* of both sides, where there are bins */
};

/* Half the surface area of a box. Finite for all floats. */
double mlrt_quad_box_area(const struct mlrt_quad_box *box);

/* The set of the references from `first` on, at least one. */
struct mlrt_bvh_set mlrt_measure_set(const struct mlrt_quad_box *references, uint32_t first, uint32_t count,
                                     struct mlrt_progress *progress);

/* What a leaf of so many triangles costs, not yet times its area. */
float mlrt_bvh_leaf_cost(const struct mlrt_bvh_costs *costs, uint32_t count);

/* The cheapest split of a set of 2 to MLRT_SWEEP_LIMIT references. */
void mlrt_sweep_set(const struct mlrt_bvh_costs *costs, const struct mlrt_quad_box *references,
                    const struct mlrt_bvh_set *set, struct mlrt_bvh_split *split);

void mlrt_clear_bins(struct mlrt_bvh_bins *bins);

/* Adds `count` references, from `first` on, of a set whose centres are in that box. */
void mlrt_fill_bins(const struct mlrt_quad_box *references, uint32_t first, uint32_t count,
                    const struct mlrt_quad_box *centres, struct mlrt_bvh_bins *bins);

/* The same result as if the references of both had been added to one. */
void mlrt_merge_bins(const struct mlrt_bvh_bins *bins, struct mlrt_bvh_bins *sum);

/* The cheapest split between bins. */
void mlrt_choose_split(const struct mlrt_bvh_costs *costs, const struct mlrt_bvh_bins *bins, uint32_t count,
                       struct mlrt_bvh_split *split);

/*
 * Deals the references of a set out to its two sides, lower ones first. Without a split the sides are halves. If the
 * call is cancelled meanwhile, the references are those of before, in any order.
 */
void mlrt_apply_bvh_split(struct mlrt_quad_box *references, const struct mlrt_bvh_set *set,
                          const struct mlrt_bvh_split *split, struct mlrt_progress *progress,
                          struct mlrt_bvh_set sides[2]);

#endif
