/* SPDX-License-Identifier: MIT */
/*
 * Where to cut a set of references in two: the surface area heuristic over their centres. The results depend on the
 * references of one set alone.
 *
 * Based on: Ingo Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007 (bins of centres). Jeffrey
 * Goldsmith, John Salmon, "Automatic Creation of Object Hierarchies for Ray Tracing", 1987 (the heuristic).
 */
#ifndef MLRT_BVH_SPLIT_H
#define MLRT_BVH_SPLIT_H

#include "base/progress.h"
#include "bvh/set.h"
#include "exact/triangle.h"

/* build.h */
struct mlrt_bvh_build;

/* Sets of up to so many references are split at the best of all places. In larger sets bins are as good and faster. */
#define MLRT_SWEEP_LIMIT 32

/* With 16 bins expected costs are 0.3 % higher, with 64 they are no lower. */
#define MLRT_BVH_BINS 32

/* How a split deals out references: each by its own rank, by the bin of its centre, or cut by a plane between bins. */
enum mlrt_split_kind { MLRT_SPLIT_BY_RANK, MLRT_SPLIT_BY_BIN, MLRT_SPLIT_BY_PLANE };

/*
 * The first `bin_count` bins of each axis, of equal width. References are put into bins by their centres (BY_BIN), or
 * cut at the planes between bins (BY_PLANE): then a reference has a part in each bin from its first to its last.
 */
struct mlrt_bvh_bins {
    struct mlrt_quad_box box[MLRT_BVH_BINS][3];             /* of the references, or parts, in each bin */
    MLRT_ALIGNED(16) int32_t first_count[MLRT_BVH_BINS][4]; /* how many references have it as their bin, or first bin */
    MLRT_ALIGNED(16) int32_t last_count[MLRT_BVH_BINS][4];  /* BY_PLANE: as their last bin */
    uint32_t bin_count;
    enum mlrt_split_kind kind;
};

/* The bin of x along each axis is the whole part of (x - start) * scale. Elements 3 are 0. */
struct mlrt_binning {
    MLRT_ALIGNED(16) float start[4];
    MLRT_ALIGNED(16) float scale[4]; /* bins per unit of length */
    float width[3];                  /* of a bin; 0 where all are in bin 0 */
};

struct mlrt_bvh_split {
    double cost; /* sum over both sides of area times cost; HUGE_VAL = there is no split */
    enum mlrt_split_kind kind;
    uint32_t axis;
    uint32_t bin;                   /* bins up to this one are the lower side */
    uint32_t count[2];              /* references of each side; by a plane at most, those on both sides counted twice */
    uint8_t rank[MLRT_SWEEP_LIMIT]; /* by rank: of each reference, in the order of centres */
    struct mlrt_quad_box box[2];    /* of both sides; by a plane estimated */
};

/* The set of `count` references from `first` on, at least one. If the call is cancelled, its boxes are unfinished. */
struct mlrt_bvh_set mlrt_measure_set(const struct mlrt_bvh_build *build, uint32_t first, uint32_t count);

/* Sets *split to the cheapest split of a set of 2 to MLRT_SWEEP_LIMIT references. */
void mlrt_sweep_set(const struct mlrt_bvh_build *build, const struct mlrt_bvh_set *set, struct mlrt_bvh_split *split);

/* The bins of coordinates, or centres, that lie in a box. */
struct mlrt_binning mlrt_cut_bins(const struct mlrt_quad_box *box, uint32_t bin_count);

/* Empties the bins of a set of `count` references. */
void mlrt_clear_bins(enum mlrt_split_kind kind, uint32_t count, struct mlrt_bvh_bins *bins);

/*
 * Adds `count` references, from `first` on, to bins of a set whose centres lie in the box `centres`. If the call is
 * cancelled, not all of them.
 */
void mlrt_fill_bins(const struct mlrt_bvh_build *build, uint32_t first, uint32_t count,
                    const struct mlrt_quad_box *centres, struct mlrt_bvh_bins *bins);

/* Adds bins to *sum: then it is as if the references of both had been added to it. */
void mlrt_merge_bins(const struct mlrt_bvh_bins *bins, struct mlrt_bvh_bins *sum);

/* Sets *split to the cheapest split of a set between its bins, BY_BIN. */
void mlrt_choose_split(const struct mlrt_bvh_build *build, const struct mlrt_bvh_bins *bins,
                       const struct mlrt_bvh_set *set, struct mlrt_bvh_split *split);

/*
 * Orders the references of a set by sides, lower ones first, and sets `sides`; by rank or by bin. If the call is
 * cancelled meanwhile, the set still has the same references, in any order.
 */
void mlrt_apply_bvh_split(const struct mlrt_bvh_build *build, const struct mlrt_bvh_set *set,
                          const struct mlrt_bvh_split *split, struct mlrt_bvh_set sides[2]);

/* ---- spatial_split.c: planes that cut references -------------------------------------------------------------- */

/*
 * Adds `count` references, from `first` on, to bins of a set whose box is `box`: to each bin the part of the triangle
 * that lies in it, of which the bounds are estimated. If the call is cancelled, not all of them.
 */
void mlrt_fill_slabs(const struct mlrt_triangle *triangles, float unit, const struct mlrt_quad_box *references,
                     uint32_t first, uint32_t count, const struct mlrt_quad_box *box, struct mlrt_progress *progress,
                     struct mlrt_bvh_bins *bins);

/* Sets *split to the cheapest plane between such bins that has at most `spare` references on both sides. */
void mlrt_choose_plane(const struct mlrt_bvh_build *build, const struct mlrt_bvh_bins *bins, uint32_t count,
                       uint32_t spare, struct mlrt_bvh_split *split);

/*
 * Splits a set in place, and sets `sides`. There must be room for split->count[0] + split->count[1] references from
 * set->first on. A reference on both sides stays whole, on one side, where that is cheaper. The upper side lies behind
 * the lower one, possibly with a gap; one side can be empty. If the call is cancelled meanwhile, the references are
 * undefined.
 */
void mlrt_apply_spatial_split(const struct mlrt_bvh_build *build, const struct mlrt_bvh_set *set,
                              const struct mlrt_bvh_split *split, struct mlrt_bvh_set sides[2]);

#endif
