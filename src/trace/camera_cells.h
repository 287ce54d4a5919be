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
#include "trace/ray_tile.h"

/*
 * The positions of the first and the last column (or row) of pixels of four cells of `side` pixels each, within an area
 * that is `length` pixels long. A cell that begins beyond the area gets the positions of the first one.
 */
static MLRT_NOINLINE void set_cell_samples(uint32_t first, uint32_t begin, uint32_t side, uint32_t length, float sample,
                                  float samples[2][4])
{
    for (uint32_t i = 0; i < 4; ++i) {
        const uint32_t low = i * side < length ? i * side : 0, high = low + side < length ? low + side : length;
        samples[0][i] = mlrt_sample_position(first, begin + low, sample);
        samples[1][i] = mlrt_sample_position(first, begin + high - 1, sample);
    }
}

/* For a vector of cells: the least depth of the directions at their corners, and bounds of their slopes. */
struct corner_slopes {
    vf least_depth;
    vf lo[2];
    vf hi[2];
};

/* Extends `of` by the corners at these columns and rows, one of each cell. */
static MLRT_NOINLINE void add_corner(const struct mlrt_view *view, const struct mlrt_waist *waist, const float *columns,
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

/*
 * Copies a view with its directions brought near 1 by a power of two, which leaves slopes as they are. *floor receives
 * a bound of the underflow of its rays before that, and *limit the greatest size with which they are finite.
 */
static MLRT_NOINLINE void scale_view(const struct mlrt_view *view, struct mlrt_view *scaled, float *floor, float *limit)
{
    float largest = 0;
    int exponent;
    *scaled = *view;
    for (int k = 0; k < 3; ++k) largest = larger_of(fabsf(view->d00[k]), largest);
    (void)frexp((double)largest, &exponent);
    for (int k = 0; k < 3; ++k) {
        scaled->d00[k] = (float)ldexp((double)view->d00[k], -exponent);
        scaled->dx[k] = (float)ldexp((double)view->dx[k], -exponent);
        scaled->dy[k] = (float)ldexp((double)view->dy[k], -exponent);
    }
    *floor = (float)(0x1p-100 + ldexp(1, -147 - exponent));
    *limit = exponent < 66 ? MLRT_SAFE_MAX : (float)ldexp(1, 126 - exponent);
}

/* Begins the cells `there` of a bundle: closed, all rays start at the waist, and look from there without an end. */
static void begin_cells(uint32_t there, struct mlrt_bundle *bundle)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    bundle->going = bundle->closed = bundle->apexes = there;
    bundle->ends_at_skip = 0;
    for (int v = 0; v < MLRT_BUNDLE_PACKETS; v += VW) {
        const vf zero = v_set1(0);
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            v_store(hulls->term[MLRT_PLACE_J + i].lo + v, zero);
            v_store(hulls->term[MLRT_PLACE_J + i].hi + v, zero);
        }
        v_store(hulls->first + v, zero);
        v_store(hulls->away + v, zero);
        v_store(hulls->last + v, v_set1(INFINITY));
        v_store(hulls->core_first + v, zero);
        v_store(hulls->core_last + v, v_set1(INFINITY));
        v_store(hulls->begin + v, zero);
        i_store(hulls->skip + v, i_set1(MLRT_NONE));
    }
}

/*
 * Makes a bundle of the cells of `side` x `side` pixels that `area` of a camera's picture consists of. Returns 0 if the
 * rays are parallel, have limits of t or no main axis in common, or if float does not carry them.
 *
 * A ray's direction before rounding is affine in column and row, so that ratios of two components have their extremes
 * over a cell at its corners. Rounding moves component k of any ray by at most 3.001 u (|d00_k| + |x dx_k| + |y dy_k|)
 * (mlrta/view_beam.c); `pad` is 8 u of that sum, and 2^-100 for underflow. So a ratio exceeds the extreme of those
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
    const struct mlrt_view *view = &job->source.view;
    const float unit = job->tree->bvh.unit;
    float floor = 0x1p-100f, limit = MLRT_SAFE_MAX;
    struct mlrt_view scaled;
    if (MLRT_UNLIKELY(unit != 1)) {
        scale_view(view, &scaled, &floor, &limit);
        view = &scaled;
    }
    const uint32_t x = area->x, y = area->y, width = area->width, height = area->height;
    if (view->parallel || view->t_min != 0 || !isinf(view->t_max)) return 0;
    float columns[2][4], rows[2][4], pad[3], middle[3];
    set_cell_samples(view->first_x, x, side, width, view->sample_x, columns);
    set_cell_samples(view->first_y, y, side, height, view->sample_y, rows);
    const float x_max =
        larger_of(fabsf(columns[0][0]), fabsf(mlrt_sample_position(view->first_x, x + width - 1, view->sample_x)));
    const float y_max =
        larger_of(fabsf(rows[0][0]), fabsf(mlrt_sample_position(view->first_y, y + height - 1, view->sample_y)));
    for (int k = 0; k < 3; ++k) {
        const float whole = fabsf(view->d00[k]) + x_max * fabsf(view->dx[k]) + y_max * fabsf(view->dy[k]);
        waist->point[k] = view->eye[k] * unit;
        if (!(whole <= limit) || !mlrt_is_float_safe(waist->point[k])) return 0;
        if (waist->point[k] / unit != view->eye[k]) return 0;
        pad[k] = whole * (8 * 0x1p-24f) + floor;
        middle[k] = (view->d00[k] + columns[0][0] * view->dx[k]) + rows[0][0] * view->dy[k];
    }
    mlrt_set_main_axis(middle, waist);

    const int a = waist->main_axis;
    uint32_t all = 0;
    MLRT_ALIGNED(64) float samples[4][MLRT_CELL_COUNT];
    for (uint32_t i = 0; i < MLRT_CELL_COUNT; ++i) {
        const uint32_t column = i % 4, row = i / 4;
        all |= (uint32_t)(column * side < width && row * side < height) << i;
        for (int end = 0; end < 2; ++end) {
            samples[end][i] = columns[end][column];
            samples[2 + end][i] = rows[end][row];
        }
    }
    for (int v = 0; v < MLRT_CELL_COUNT; v += VW) {
        struct corner_slopes of = {
            v_set1(INFINITY), {v_set1(INFINITY), v_set1(INFINITY)}, {v_set1(-INFINITY), v_set1(-INFINITY)}};
        for (int corner = 0; corner < 4; ++corner) {
            add_corner(view, waist, samples[corner & 1] + v, samples[2 + (corner >> 1)] + v, &of);
        }
        const vm forward = v_gt(of.least_depth, v_set1(4 * pad[a]));
        const vm there = m_from_bits(all >> v);
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
    begin_cells(all, bundle);
    return 1;
}

#endif
