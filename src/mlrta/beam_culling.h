/* SPDX-License-Identifier: MIT */
/*
 * A beam against cells: which children of a cell can its rays reach, and can they reach a box at all.
 *
 * A ray that is in front of its origin by x along axis a is at o_j + m x on axis j, with m = d_j / d_a. All tests
 * compare such products with distances from the origin, m x against (h - o_j): four roundings at most, each relative,
 * and the beam's slopes are already widened by 2^-20 of themselves. So an answer "no" is a proof, at any scale;
 * packet.h's limits rule out underflow that could matter. Comparisons with a NaN (0 times infinity) are false: not
 * excluded.
 *
 * Based on: Reshetov et al. 2005, section 3.3: direct culling puts the planes of the beam against the box, inverse
 * culling the planes of the box against the beam.
 */
#ifndef MLRT_MLRTA_BEAM_CULLING_H
#define MLRT_MLRTA_BEAM_CULLING_H

#include "mlrta/beam.h"
#include "mlrta/interval_traversal.h"

enum { NEAR_CHILD = 1, FAR_CHILD = 2, BOTH_CHILDREN = 3 };

/* Bounds of m x for m in [slope_lo, slope_hi] and x between x_lo <= x_hi, which have one sign. */
MLRT_INLINE struct distance_interval offset_range(const struct mlrt_beam *beam, int a, int j, float x_lo, float x_hi)
{
    const float m_lo = beam->slope_lo[a][j], m_hi = beam->slope_hi[a][j];
    if (x_lo >= 0) {
        return (struct distance_interval){m_lo * (m_lo >= 0 ? x_lo : x_hi), m_hi * (m_hi >= 0 ? x_hi : x_lo)};
    }
    return (struct distance_interval){m_hi * (m_hi >= 0 ? x_lo : x_hi), m_lo * (m_lo >= 0 ? x_hi : x_lo)};
}

/*
 * Inverse culling: the plane x_a = c splits a cell that the beam touches. On it, the rays fill a rectangle. Where that
 * lies wholly past the side through which the rays leave the cell, none gets to the far child; where it lies wholly
 * before the side through which they come in, none was in the near child.
 */
MLRT_INLINE int cull_inverse(const struct mlrt_beam *beam, const struct mlrt_box *cell, int a, float c)
{
    const float x_lo = c - beam->origin_hi[a], x_hi = c - beam->origin_lo[a];
    if (beam->negative[a] ? x_lo > 0 : x_hi < 0) return FAR_CHILD; /* the plane is behind every origin */
    if (beam->negative[a] ? x_hi > 0 : x_lo < 0) return BOTH_CHILDREN;
    for (int step = 1; step < 3; ++step) {
        const int j = (a + step) % 3;
        const struct distance_interval q = offset_range(beam, a, j, x_lo, x_hi);
        const int above = q.lo > cell->hi[j] - beam->origin_lo[j];
        const int below = q.hi < cell->lo[j] - beam->origin_hi[j];
        if (beam->negative[j] ? below : above) return NEAR_CHILD;
        if (beam->negative[j] ? above : below) return FAR_CHILD;
    }
    return BOTH_CHILDREN;
}

/* 1 if, seen along axis a, no ray of the beam touches the box. */
MLRT_INLINE int misses_box_along(const struct mlrt_beam *beam, const struct mlrt_box *box, int a)
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
        const struct distance_interval q = offset_range(beam, a, j, x_lo, x_hi);
        if (q.lo > box->hi[j] - beam->origin_lo[j] || q.hi < box->lo[j] - beam->origin_hi[j]) return 1;
    }
    return 0;
}

/* 1 if no ray of the beam touches the box: all six faces against the beam. */
static int misses_box(const struct mlrt_beam *beam, const struct mlrt_box *box)
{
    return misses_box_along(beam, box, 0) || misses_box_along(beam, box, 1) || misses_box_along(beam, box, 2);
}

/* The halves of a cell. */
struct cell_halves {
    struct mlrt_box near;
    struct mlrt_box far;
};

MLRT_INLINE struct cell_halves split_cell(const struct mlrt_beam *beam, const struct mlrt_box *cell, int a, float c)
{
    struct cell_halves halves = {*cell, *cell};
    if (beam->negative[a]) {
        halves.near.lo[a] = halves.far.hi[a] = c;
    } else {
        halves.near.hi[a] = halves.far.lo[a] = c;
    }
    return halves;
}

/* Direct culling: each half of the cell against the planes of the beam. */
MLRT_INLINE int cull_direct(const struct mlrt_beam *beam, const struct mlrt_box *cell, int a, float c)
{
    const struct cell_halves halves = split_cell(beam, cell, a, c);
    return (misses_box_along(beam, &halves.near, beam->main_axis) ? 0 : NEAR_CHILD) |
           (misses_box_along(beam, &halves.far, beam->main_axis) ? 0 : FAR_CHILD);
}

/* The extra check where culling excluded neither half: all six faces of both. */
static int check_children(const struct mlrt_beam *beam, const struct mlrt_box *cell, int a, float c)
{
    const struct cell_halves halves = split_cell(beam, cell, a, c);
    return (misses_box(beam, &halves.near) ? 0 : NEAR_CHILD) | (misses_box(beam, &halves.far) ? 0 : FAR_CHILD);
}

/* The part of a box in the beam's region. 0 if there is none. */
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
