/* SPDX-License-Identifier: MIT */
/*
 * A beam against cells: which children of a cell its rays can reach, and whether they can reach a box at all.
 *
 * A ray that has gone a distance x from its origin along axis a is at o_j + m x on axis j, with m = d_j / d_a. Every
 * test compares such a product m x with a distance from the origin, h - o_j. That takes four roundings at most, each
 * relative, and the beam's slopes are already moved outward by 2^-20 of themselves. So a child or box is excluded only
 * if that is proven, at any scale; the limits of packet.h rule out underflow that could matter. A comparison with a NaN
 * (0 times infinity) is false and excludes nothing.
 *
 * Based on: Reshetov et al. 2005, section 3.3: direct culling tests the box against the planes of the beam, inverse
 * culling the beam against the planes of the box.
 */
#ifndef MLRT_MLRTA_BEAM_CULLING_H
#define MLRT_MLRTA_BEAM_CULLING_H

#include "base/platform.h"
#include "mlrta/beam.h"

/* Sets of children, as bits. */
enum { NEAR_CHILD = 1, FAR_CHILD = 2, BOTH_CHILDREN = 3 };

struct offset_interval {
    float lo;
    float hi;
};

/* Bounds of m x for m in [slope_lo, slope_hi] and x in [x_lo, x_hi], two numbers of the same sign. */
MLRT_INLINE struct offset_interval offset_range(const struct mlrt_beam *beam, int a, int j, float x_lo, float x_hi)
{
    const float m_lo = beam->slope_lo[a][j], m_hi = beam->slope_hi[a][j];
    if (x_lo >= 0) return (struct offset_interval){m_lo * (m_lo >= 0 ? x_lo : x_hi), m_hi * (m_hi >= 0 ? x_hi : x_lo)};
    return (struct offset_interval){m_hi * (m_hi >= 0 ? x_lo : x_hi), m_lo * (m_lo >= 0 ? x_hi : x_lo)};
}

/*
 * Inverse culling: the children that rays can reach, of a cell that the beam touches and the plane x_a = c splits. The
 * rays meet that plane in a rectangle. If the rectangle lies wholly past a side through which the rays leave the cell,
 * no ray reaches the far child. If it lies wholly before a side through which they enter, no ray was in the near child.
 */
MLRT_INLINE int cull_inverse(const struct mlrt_beam *beam, const struct mlrt_box *cell, int a, float c)
{
    const float x_lo = c - beam->origin_hi[a], x_hi = c - beam->origin_lo[a];
    if (beam->negative[a] ? x_lo > 0 : x_hi < 0) return FAR_CHILD; /* the plane is behind every origin */
    if (beam->negative[a] ? x_hi > 0 : x_lo < 0) return BOTH_CHILDREN;
    for (int step = 1; step < 3; ++step) {
        const int j = (a + step) % 3;
        const struct offset_interval q = offset_range(beam, a, j, x_lo, x_hi);
        const int above = q.lo > cell->hi[j] - beam->origin_lo[j];
        const int below = q.hi < cell->lo[j] - beam->origin_hi[j];
        if (beam->negative[j] ? below : above) return NEAR_CHILD;
        if (beam->negative[j] ? above : below) return FAR_CHILD;
    }
    return BOTH_CHILDREN;
}

/* 1 if the slopes over axis a show that no ray of the beam touches the box. Inlined, it would take 2 kB more. */
static MLRT_NOINLINE int misses_box_along(const struct mlrt_beam *beam, const struct mlrt_box *box, int a)
{
    float x_lo = box->lo[a] - beam->origin_hi[a], x_hi = box->hi[a] - beam->origin_lo[a];
    if (beam->negative[a]) {
        if (x_lo > 0) return 1;
        if (x_hi > 0) x_hi = 0;
    } else {
        if (x_hi < 0) return 1;
        if (x_lo < 0) x_lo = 0;
    }
    for (int step = 1; step < 3; ++step) {
        const int j = (a + step) % 3;
        const struct offset_interval q = offset_range(beam, a, j, x_lo, x_hi);
        if (q.lo > box->hi[j] - beam->origin_lo[j] || q.hi < box->lo[j] - beam->origin_hi[j]) return 1;
    }
    return 0;
}

/* 1 if the slopes over the main axis, or over any with `all_axes`, show that no ray of the beam touches the box. */
static int misses_box(const struct mlrt_beam *beam, const struct mlrt_box *box, int all_axes)
{
    const int a = beam->main_axis;
    return misses_box_along(beam, box, a) ||
           (all_axes && (misses_box_along(beam, box, (a + 1) % 3) || misses_box_along(beam, box, (a + 2) % 3)));
}

/*
 * Direct culling: tests the box of each child against the planes of the beam, the slopes over its main axis. With
 * `all_axes`, this is the extra check after culling that excluded neither child.
 */
static int cull_direct(const struct mlrt_beam *beam, const struct mlrt_box *cell, int a, float c, int all_axes)
{
    int children = BOTH_CHILDREN;
    for (int far = 0; far < 2; ++far) {
        struct mlrt_box half = *cell;
        *(far == beam->negative[a] ? &half.hi[a] : &half.lo[a]) = c;
        if (misses_box(beam, &half, all_axes)) children &= far ? ~FAR_CHILD : ~NEAR_CHILD;
    }
    return children;
}

/* Cuts a box down to the beam's region. Returns 0 if nothing is left. */
MLRT_INLINE int clip_to_region(const struct mlrt_beam *beam, struct mlrt_box *box)
{
    for (int k = 0; k < 3; ++k) {
        if (beam->region.lo[k] > box->lo[k]) box->lo[k] = beam->region.lo[k];
        if (beam->region.hi[k] < box->hi[k]) box->hi[k] = beam->region.hi[k];
        if (box->lo[k] > box->hi[k]) return 0;
    }
    return 1;
}

#endif
