/* SPDX-License-Identifier: MIT */
/* Boxes of four floats per corner, references to triangles on their way into leaves, sets of them, and costs. */
#ifndef MLRT_BVH_SET_H
#define MLRT_BVH_SET_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "base/platform.h"
#include "base/tuning.h"
#include "simd/quad.h"

/* A box as two f4. The fourth elements do not matter, but should be normal floats or 0, so that arithmetic is fast. */
struct mlrt_quad_box {
    MLRT_ALIGNED(16) float lo[4];
    MLRT_ALIGNED(16) float hi[4];
};

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
    memcpy(&bits, &reference->lo[3], sizeof bits);
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
    memcpy(&reference->lo[3], &bits, sizeof bits);
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
