/* SPDX-License-Identifier: MIT */
/*
 * Where to cut a set of references in two: the surface area heuristic over their centres. The functions have no state:
 * their results depend on the references of one set alone.
 *
 * Based on: Ingo Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007 (bins of centres). Jeffrey
 * Goldsmith, John Salmon, "Automatic Creation of Object Hierarchies for Ray Tracing", 1987 (the heuristic).
 */
#ifndef MLRT_BVH_SPLIT_H
#define MLRT_BVH_SPLIT_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "base/platform.h"
#include "base/progress.h"
#include "base/tuning.h"
#include "exact/triangle.h"
#include "simd/quad.h"

/* ---- sets of references: boxes of four floats per corner on their way into leaves, and costs ---- */

/* Four floats, one by one or as a vector. */
union mlrt_quad {
    MLRT_ALIGNED(16) float x[4];
    f4 v;
};

/* A box. The fourth elements do not matter, but should be normal floats or 0, so that arithmetic is fast. */
struct mlrt_quad_box {
    union mlrt_quad lo;
    union mlrt_quad hi;
};

MLRT_INLINE struct mlrt_quad_box empty_box(void)
{
    return (struct mlrt_quad_box){{.v = f4_set1(INFINITY)}, {.v = f4_set1(-INFINITY)}};
}

MLRT_INLINE void grow(struct mlrt_quad_box *box, f4 lo, f4 hi)
{
    box->lo.v = f4_min(box->lo.v, lo);
    box->hi.v = f4_max(box->hi.v, hi);
}

/* Half the surface area, in double because extents are 2^-149 to 2^129. */
MLRT_INLINE double area_of(const struct mlrt_quad_box *box)
{
    double x = (double)box->hi.x[0] - box->lo.x[0], y = (double)box->hi.x[1] - box->lo.x[1],
           z = (double)box->hi.x[2] - box->lo.x[2];
    return x * y + y * z + z * x;
}

/*
 * A centre is a quarter of lo + hi per axis, in float. lo and hi are multiplied by 1/4 first, so neither a centre nor
 * the difference of two overflows. Centres only sort references: their rounding does no harm, because a reference
 * always has the same centre.
 */
MLRT_INLINE f4 centre_of(f4 lo, f4 hi)
{
    f4 quarter = f4_set1(0.25f);
    return f4_add(f4_mul(lo, quarter), f4_mul(hi, quarter));
}

/*
 * A reference is the box of a triangle, or of a part of one, that is to be put into a leaf. The fourth element of its
 * lo has the bits of the triangle's number | 2^30: as a float its magnitude is at least 2, not denormal, so arithmetic
 * on all four elements runs at full speed. Of the parts of a triangle all but one are copies, with one bit more: the
 * leaf of the other is the triangle's place (node.h).
 */
#define MLRT_REFERENCE_MARK 0x40000000u
#define MLRT_REFERENCE_COPY 0x80000000u

/* The number of a reference's triangle, and MLRT_REFERENCE_COPY if it is a copy. */
static inline uint32_t mlrt_reference_word(const struct mlrt_quad_box *reference)
{
    uint32_t bits;
    memcpy(&bits, &reference->lo.x[3], sizeof bits);
    return bits & ~MLRT_REFERENCE_MARK;
}

/* The number of a reference's triangle. */
static inline uint32_t mlrt_reference_triangle(const struct mlrt_quad_box *reference)
{
    return mlrt_reference_word(reference) & ~MLRT_REFERENCE_COPY;
}

static inline void mlrt_mark_copy(struct mlrt_quad_box *reference)
{
    const uint32_t bits = mlrt_reference_word(reference) | MLRT_REFERENCE_MARK | MLRT_REFERENCE_COPY;
    memcpy(&reference->lo.x[3], &bits, sizeof bits);
}

/*
 * The costs for a ray that meets a node or a leaf, relative to a node's. All sixteen children of a node are tested in
 * one step, and all triangles of a leaf nearly so.
 */
struct mlrt_bvh_costs {
    float node;
    float leaf;     /* of each leaf, whatever its triangles */
    float triangle; /* of each triangle of a leaf */
};

/* The cost of a leaf of `count` triangles, not yet times its area. */
static inline float mlrt_bvh_leaf_cost(const struct mlrt_bvh_costs *costs, uint32_t count)
{
    return costs->leaf + costs->triangle * (float)count;
}

/* A set of references: `count` of them from `first` on. */
struct mlrt_bvh_set {
    struct mlrt_quad_box box;     /* of all boxes */
    struct mlrt_quad_box centres; /* of their centres */
    uint32_t first;
    uint32_t count;
};

/* A set without references so far, which begins with the reference `first`. */
MLRT_INLINE struct mlrt_bvh_set empty_set(uint32_t first)
{
    return (struct mlrt_bvh_set){empty_box(), empty_box(), first, 0};
}

MLRT_INLINE void add_reference(struct mlrt_bvh_set *set, f4 lo, f4 hi)
{
    const f4 centre = centre_of(lo, hi);
    grow(&set->box, lo, hi);
    grow(&set->centres, centre, centre);
    set->count++;
}

/*
 * The expected cost of a set of any size, not yet times its area: that of leaves that are full except the last. Because
 * whole leaves are counted, splits that fill them are cheaper.
 */
MLRT_INLINE double set_cost(const struct mlrt_bvh_costs *costs, uint32_t count)
{
    return costs->leaf * (float)((count + MLRT_LEAF_TRIANGLES - 1) / MLRT_LEAF_TRIANGLES) +
           costs->triangle * (float)count;
}

/* ---- split.c ---- */

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
struct mlrt_bvh_set mlrt_measure_set(const struct mlrt_quad_box *references, uint32_t first, uint32_t count,
                                     struct mlrt_progress *progress);

/* Sets *split to the cheapest split of a set of 2 to MLRT_SWEEP_LIMIT references. */
void mlrt_sweep_set(const struct mlrt_bvh_costs *costs, const struct mlrt_quad_box *references,
                    const struct mlrt_bvh_set *set, struct mlrt_bvh_split *split);

/* The bins of coordinates, or centres, that lie in a box. */
struct mlrt_binning mlrt_cut_bins(const struct mlrt_quad_box *box, uint32_t bin_count);

/* Empties the bins of a set of `count` references. */
void mlrt_clear_bins(enum mlrt_split_kind kind, uint32_t count, struct mlrt_bvh_bins *bins);

/* Adds `count` references, from `first` on, to bins of a set whose centres lie in the box `centres`. */
void mlrt_fill_bins(const struct mlrt_quad_box *references, uint32_t first, uint32_t count,
                    const struct mlrt_quad_box *centres, struct mlrt_bvh_bins *bins);

/* Adds bins to *sum: then it is as if the references of both had been added to it. */
void mlrt_merge_bins(const struct mlrt_bvh_bins *bins, struct mlrt_bvh_bins *sum);

/* Sets *split to the cheapest split of a set between its bins, BY_BIN. */
void mlrt_choose_split(const struct mlrt_bvh_costs *costs, const struct mlrt_bvh_bins *bins,
                       const struct mlrt_bvh_set *set, struct mlrt_bvh_split *split);

/*
 * Orders the references of a set by sides, lower ones first, and sets `sides`; by rank or by bin. If split->cost is
 * HUGE_VAL, the sides are halves. If the call is cancelled meanwhile, the set still has the same references, in any order.
 */
void mlrt_apply_bvh_split(struct mlrt_quad_box *references, const struct mlrt_bvh_set *set,
                          const struct mlrt_bvh_split *split, struct mlrt_progress *progress,
                          struct mlrt_bvh_set sides[2]);

/* ---- spatial_split.c: planes that cut references -------------------------------------------------------------- */

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
