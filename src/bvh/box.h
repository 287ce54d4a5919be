/* SPDX-License-Identifier: MIT */
/*
 * Boxes of four floats a corner, as the builder of the hierarchy grows them.
 */
#ifndef MLRT_BVH_BOX_H
#define MLRT_BVH_BOX_H

#include <math.h>

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

/* Half the surface area, in double: extents reach from 2^-149 to 2^129. */
MLRT_INLINE double area_of(const struct mlrt_quad_box *box)
{
    double x = (double)box->hi[0] - box->lo[0], y = (double)box->hi[1] - box->lo[1],
           z = (double)box->hi[2] - box->lo[2];
    return x * y + y * z + z * x;
}

/*
 * A centre here is a quarter of lo + hi per axis, in float, each half quartered before: so neither it nor the
 * difference of two overflows. It is only a place to sort by; that it is rounded does no harm as long as it is always
 * the same.
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

MLRT_INLINE struct growing_box nothing(void)
{
    return (struct growing_box){f4_set1(INFINITY), f4_set1(-INFINITY)};
}

MLRT_INLINE void grow(struct growing_box *box, f4 lo, f4 hi)
{
    box->lo = f4_min(box->lo, lo);
    box->hi = f4_max(box->hi, hi);
}

MLRT_INLINE void keep(const struct growing_box *box, struct mlrt_quad_box *kept)
{
    f4_store(kept->lo, box->lo);
    f4_store(kept->hi, box->hi);
}

/* What a set is while references are added to it. */
struct growing_set {
    struct growing_box box;
    struct growing_box centres;
};

MLRT_INLINE struct growing_set no_references(void)
{
    return (struct growing_set){nothing(), nothing()};
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
    keep(&growing->box, &set.box);
    keep(&growing->centres, &set.centres);
    set.first = first;
    set.count = count;
    return set;
}

/*
 * What a set of any size is expected to cost: that of leaves that are full but for the last. Counting whole leaves and
 * quads makes splits that fill them cheaper.
 */
MLRT_INLINE double set_cost(const struct mlrt_bvh_costs *costs, uint32_t count)
{
    return costs->leaf * (float)((count + 15) / 16) + costs->quad * (float)((count + 3) / 4) +
           costs->triangle * (float)count;
}

#endif
