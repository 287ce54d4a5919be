/* SPDX-License-Identifier: MIT */
/* Boxes of four floats per corner, and how the builder of the hierarchy grows them. */
#ifndef MLRT_BVH_BOX_H
#define MLRT_BVH_BOX_H

#include <math.h>

#include "base/tuning.h"
#include "bvh/set.h"
#include "simd/quad.h"

MLRT_INLINE void clear_box(struct mlrt_quad_box *box)
{
    f4_store(box->lo, f4_set1(INFINITY));
    f4_store(box->hi, f4_set1(-INFINITY));
}

MLRT_INLINE void extend_box(struct mlrt_quad_box *box, f4 lo, f4 hi)
{
    f4_store(box->lo, f4_min(f4_load(box->lo), lo));
    f4_store(box->hi, f4_max(f4_load(box->hi), hi));
}

/* Half the surface area, in double because extents are 2^-149 to 2^129. */
MLRT_INLINE double area_of(const struct mlrt_quad_box *box)
{
    double x = (double)box->hi[0] - box->lo[0], y = (double)box->hi[1] - box->lo[1],
           z = (double)box->hi[2] - box->lo[2];
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

/* A box that grows in registers. */
struct growing_box {
    f4 lo;
    f4 hi;
};

MLRT_INLINE struct growing_box empty_box(void)
{
    return (struct growing_box){f4_set1(INFINITY), f4_set1(-INFINITY)};
}

MLRT_INLINE void grow(struct growing_box *box, f4 lo, f4 hi)
{
    box->lo = f4_min(box->lo, lo);
    box->hi = f4_max(box->hi, hi);
}

MLRT_INLINE void store_box(const struct growing_box *box, struct mlrt_quad_box *stored)
{
    f4_store(stored->lo, box->lo);
    f4_store(stored->hi, box->hi);
}

/* The boxes of a set while references are added to it. */
struct growing_set {
    struct growing_box box;
    struct growing_box centres;
};

MLRT_INLINE struct growing_set empty_set(void)
{
    return (struct growing_set){empty_box(), empty_box()};
}

MLRT_INLINE void add_reference(struct growing_set *set, f4 lo, f4 hi)
{
    f4 centre = centre_of(lo, hi);
    grow(&set->box, lo, hi);
    grow(&set->centres, centre, centre);
}

MLRT_INLINE struct mlrt_bvh_set finish_set(const struct growing_set *growing, uint32_t first, uint32_t count)
{
    struct mlrt_bvh_set set;
    store_box(&growing->box, &set.box);
    store_box(&growing->centres, &set.centres);
    set.first = first;
    set.count = count;
    return set;
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

#endif
