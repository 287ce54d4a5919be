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
MLRT_INLINE double area_between(const float lo[3], const float hi[3])
{
    const double x = (double)hi[0] - lo[0], y = (double)hi[1] - lo[1], z = (double)hi[2] - lo[2];
    return x * y + y * z + z * x;
}

MLRT_INLINE double area_of(const struct mlrt_quad_box *box)
{
    return area_between(box->lo.x, box->hi.x);
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
 * The costs for a ray that meets a node or a leaf. A leaf costs 1, and `triangle` for each of its triangles. All
 * sixteen children of a node are tested in one step, and all triangles of a leaf nearly so.
 */
struct mlrt_bvh_costs {
    float node;
    float triangle; /* what each triangle adds to its leaf */
};

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

MLRT_INLINE void add_reference(const struct mlrt_quad_box *reference, struct mlrt_bvh_set *set)
{
    const f4 centre = centre_of(reference->lo.v, reference->hi.v);
    grow(&set->box, reference->lo.v, reference->hi.v);
    grow(&set->centres, centre, centre);
    set->count++;
}

/*
 * The expected cost of a set of any size, not yet times its area: that of leaves that are full except the last. Because
 * whole leaves are counted, splits that fill them are cheaper. Signed integers become floats in one step of a vector.
 */
MLRT_INLINE float set_cost(const struct mlrt_bvh_costs *costs, uint32_t count)
{
    const uint32_t leaf_count = (count + MLRT_LEAF_TRIANGLES - 1) / MLRT_LEAF_TRIANGLES;
    return (float)(int32_t)leaf_count + costs->triangle * (float)(int32_t)count;
}

#endif
