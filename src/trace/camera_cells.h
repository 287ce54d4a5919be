/* SPDX-License-Identifier: MIT */
/*
 * A camera's packets, or its tiles, as a bundle without rays: each is a rectangle of slopes.
 */
#ifndef MLRT_TRACE_CAMERA_CELLS_H
#define MLRT_TRACE_CAMERA_CELLS_H

#include <math.h>

#include "rays/extremes.h"
#include "rays/slope_limits.h"
#include "simd/simd.h"
#include "trace/bundle.h"
#include "trace/cells.h"

/* For a vector of cells: the least depth of the directions at their corners, and bounds of their slopes. */
struct corner_slopes {
    vf least_depth;
    vf lo[2];
    vf hi[2];
};

/* Extends `of` by the corners at these columns and rows, one of each cell. */
static MLRT_NOINLINE void add_corner(const mlrt_camera *view, const struct mlrt_waist *waist, const float *columns,
                                     const float *rows, struct corner_slopes *of)
{
    const int a = waist->main_axis;
    const vf xs = v_load(columns), ys = v_load(rows);
    vf d[3];
    for (int k = 0; k < 3; ++k) {
        d[k] = v_add(v_add(v_set1(view->d00[k]), v_mul(xs, v_set1(view->dx[k]))), v_mul(ys, v_set1(view->dy[k])));
    }
    const vf depth = v_flip(d[a], v_set1(waist->sign)), inverse = v_div(v_set1(1), depth);
    of->least_depth = v_min(depth, of->least_depth);
    for (int j = 0; j < 2; ++j) {
        const vf slope = v_mul(d[mlrt_slope_axis(a, j)], inverse);
        of->lo[j] = v_min(slope, of->lo[j]);
        of->hi[j] = v_max(slope, of->hi[j]);
    }
}

/* Begins the cells `there` of a bundle: closed, all rays start at the waist, and look from there without an end. */
static void begin_cells(uint32_t there, struct mlrt_bundle *bundle)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    bundle->state.going = bundle->state.closed = bundle->state.apexes = there;
    bundle->ends_at_skip = 0;
    bundle->arrays = NULL;
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        const vf zero = v_set1(0);
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            v_store(hulls->term[MLRT_PLACE_J + i].lo + v, zero);
            v_store(hulls->term[MLRT_PLACE_J + i].hi + v, zero);
        }
        v_store(hulls->first + v, zero);
        v_store(hulls->filter.away + v, zero);
        v_store(hulls->last + v, v_set1(INFINITY));
        v_store(hulls->closed.core_first + v, zero);
        v_store(hulls->closed.core_last + v, v_set1(INFINITY));
        v_store(hulls->begin + v, zero);
        i_store(hulls->closed.skip + v, i_set1(MLRT_NONE));
    }
}

/*
 * Makes a bundle of the cells of `side` x `side` pixels that `area` of a camera's picture consists of. Returns 0 if the
 * rays are parallel, have limits of t or no main axis in common, or if float does not carry them.
 *
 * A ray's direction before rounding is affine in column and row, so that ratios of two components have their extremes
 * over a cell at its corners. Rounding moves component k of any ray by at most 3.001 u (|d00_k| + |x dx_k| + |y dy_k|)
 * (mlrta/beam.c); `pad` is 8 u of that sum, and 2^-100 for underflow. So a ratio exceeds the extreme of those
 * computed at the corners by at most 2 (p_j + |slope| p_main) / (|d_main| - 2 p_main), with p = 0.38 pad. That is less
 * than 2 (pad_j + |slope| pad_main) / |d_main|, which is used, since |d_main| is more than 4 pad_main. So |d_main| is
 * more than 2^-98, and reciprocals are finite: an infinite slope times 0 would be a NaN.
 *
 * Slopes of a camera's rays may be denormal, where SLOPE_SLACK vanishes and a rounding is a large part of the slope: so
 * all slopes are moved by SLOPE_FLOOR too. (Those of packets that have rays are 0 or at least LEAST_SLOPE.)
 */
static int gather_camera_cells(const struct mlrt_job *job, const struct mlrt_rectangle *area, uint32_t side,
                               struct mlrt_bundle *bundle)
{
    struct mlrt_waist *waist = &bundle->waist;
    struct mlrt_camera_samples samples;
    if (!mlrt_sample_camera_cells(&job->source.view, job->tree->bvh.unit, area, side, waist, &samples)) return 0;
    const int a = waist->main_axis;
    const float *pad = samples.pad;
    for (int v = 0; v < MLRT_CELL_COUNT; v += VW) {
        struct corner_slopes of = {
            v_set1(INFINITY), {v_set1(INFINITY), v_set1(INFINITY)}, {v_set1(-INFINITY), v_set1(-INFINITY)}};
        for (int corner = 0; corner < 4; ++corner) {
            add_corner(&samples.view, waist, samples.positions[corner & 1] + v,
                       samples.positions[2 + (corner >> 1)] + v, &of);
        }
        const vm forward = v_gt(of.least_depth, v_set1(4 * pad[a]));
        const vm there = m_from_bits(samples.all >> v);
        if (m_bits(m_andnot(there, forward))) return 0;
        const vf inverse = v_div(v_set1(2), of.least_depth);
        for (int j = 0; j < 2; ++j) {
            const vf steepest = v_max(v_abs(of.lo[j]), v_abs(of.hi[j]));
            if (m_bits(m_andnot(there, v_le(steepest, v_set1(STEEPEST_SLOPE))))) return 0;
            const vf error = v_mul(v_add(v_set1(pad[mlrt_slope_axis(a, j)]), v_mul(steepest, v_set1(pad[a]))), inverse);
            const vf slack = v_add(v_add(error, v_mul(steepest, v_set1(SLOPE_SLACK))), v_set1(SLOPE_FLOOR));
            v_store(bundle->hulls.term[j].lo + v, v_sub(of.lo[j], slack));
            v_store(bundle->hulls.term[j].hi + v, v_add(of.hi[j], slack));
        }
    }
    begin_cells(samples.all, bundle);
    return 1;
}

#endif
