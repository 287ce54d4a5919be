/* SPDX-License-Identifier: MIT */
/*
 * The tiles of a square of rays from the caller's arrays, as a bundle without rays. All rays must start at one point (a
 * point light, an array of one origin) or have one direction (a sun, an array of one direction). The rays of a tile are
 * read, but only its hull is kept. A tile that stays closed needs no packets; the rays of other tiles are read again. A
 * tile without finite rays, as where a picture shows nothing, is closed from the start, and is not traced.
 *
 * Of each ray two numbers across and one depth are computed. The waist of rays from a point is that point: the numbers
 * are slopes, and the depth is where the ray to a light ends. The waist of parallel rays is in the middle of the scene:
 * the numbers are j and l of the origin, and the depth is where the ray begins.
 *
 * Slopes and intercepts are computed as in ray_hulls.h, so L2, L3 and L10 bound them. As in corner_slopes.h,
 * SLOPE_FLOOR is added to the slopes of rays from a point, which may be denormal.
 */
#ifndef MLRT_TRACE_ARRAY_CELLS_H
#define MLRT_TRACE_ARRAY_CELLS_H

#include "rays/read_arrays.h"
#include "trace/cell_ends.h"
#include "trace/ray_hulls.h"

/* Extremes of the rays of a tile, for each lane of a vector apart. */
struct array_extremes {
    struct extremes across[2]; /* slopes; or intercepts */
    struct extremes box[3];    /* of points, from the main axis on (cell_ends.h) */
    struct extremes depth;     /* |d_main|, not in units; or depths of origins */
    vf sum;                    /* of all |slopes| or |intercepts|: NaN or infinite if one of them is */
};

/* What is known of a block, or of a tile. */
enum array_kind {
    HAS_HULL, /* of all rays */
    IS_VOID,  /* no ray is finite: they hit nothing (rule R1) */
    IS_MIXED  /* neither: there is no hull */
};

/* Do the rays at the corners of a tile skip one triangle? If not, as mostly, those of its blocks are not read. */
static int corners_skip_one(const struct mlrt_array_layout *skip, size_t element, size_t row_length)
{
    const unsigned char *first = skip->data + element * skip->stride, *last = first + 15 * row_length * skip->stride;
    const size_t across = 15 * skip->stride;
    return !memcmp(first, first + across, 8) && !memcmp(first, last, 8) && !memcmp(first, last + across, 8);
}

/* Extends `of` by the rays of a block. A hull needs slopes and intercepts of all rays that are finite, and no NaN. */
static MLRT_NOINLINE enum array_kind add_block(const struct mlrt_array_cells *cells, size_t element,
                                               const struct mlrt_waist *waist, struct array_extremes *of)
{
    MLRT_ALIGNED(64) float rows[3][MLRT_PACKET_RAYS];
    const int a = waist->main_axis;
    const vf zero = v_set1(0);
    read_points(cells, element, rows);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf point[3], across[2];
        MLRT_UNROLL
        for (int k = 0; k < 3; ++k) {
            point[k] = v_load(rows[(a + k) % 3] + v);
            add_to_extremes(point[k], &of->box[k]);
            if (cells->are_parallel) point[k] = v_sub(point[k], v_set1(cells->from[(a + k) % 3]));
        }
        vf depth = v_flip(point[0], v_set1(waist->sign));
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) across[i] = point[1 + i];
        if (cells->are_parallel) {
            depth = v_mul(depth, v_set1(cells->unit));
            MLRT_UNROLL
            for (int i = 0; i < 2; ++i) {
                across[i] = v_sub(v_mul(across[i], v_set1(cells->unit)), v_mul(v_set1(cells->slope[i]), depth));
            }
        } else {
            const vf inverse = v_div(v_set1(1), depth);
            MLRT_UNROLL
            for (int i = 0; i < 2; ++i) across[i] = v_mul(across[i], inverse);
        }
        add_to_extremes(depth, &of->depth);
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            add_to_extremes(across[i], &of->across[i]);
            of->sum = v_add(v_abs(across[i]), of->sum);
        }
    }
    if (MLRT_LIKELY(m_bits(v_le(of->sum, v_set1(MLRT_SAFE_MAX))) == ALL_LANES)) return HAS_HULL;
    uint32_t finite = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        vf zero_or_nan = zero;
        for (int k = 0; k < 3; ++k) zero_or_nan = v_mul_add(v_load(rows[k] + v), zero, zero_or_nan);
        finite |= m_bits(v_eq(zero_or_nan, zero));
    }
    return finite ? IS_MIXED : IS_VOID;
}

/* Sets a box from its extremes, which are given from an axis on. */
MLRT_INLINE void set_box(const struct extremes from_axis[3], int axis, struct mlrt_box *box)
{
    for (int k = 0; k < 3; ++k) {
        const struct extremes *of = &from_axis[(k + 3 - axis) % 3];
        box->lo[k] = v_hmin(of->least);
        box->hi[k] = -v_hmin(of->negated);
    }
}

/* Sets the hull of a tile. Returns IS_MIXED if float does not carry its rays. */
static enum array_kind set_array_cell(struct mlrt_array_cells *cells, const struct array_extremes *of, uint32_t place,
                                      struct mlrt_bundle *bundle)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    MLRT_ALIGNED(16) float least[4];
    f4_store(least, v_hmin4(of->across[0].least, of->across[1].least, of->across[0].negated, of->across[1].negated));
    const float scale = cells->are_parallel ? 1 : cells->unit;
    const float near = v_hmin(of->depth.least) * scale, far = -v_hmin(of->depth.negated) * scale;
    int fits = cells->are_parallel || (near >= LEAST_PACE && far <= GREATEST_PACE);
    for (int i = 0; i < 2; ++i) {
        const float lo = least[i], hi = -least[2 + i];
        struct mlrt_hull_row *slope = &hulls->term[MLRT_SLOPE_J + i], *at = &hulls->term[MLRT_INTERCEPT_J + i];
        slope->lo[place] = cells->are_parallel ? cells->slope[i] : lo - SLOPE_FLOOR;
        slope->hi[place] = cells->are_parallel ? cells->slope[i] : hi + SLOPE_FLOOR;
        if (cells->are_parallel) at->lo[place] = lo, at->hi[place] = hi;
        fits &= cells->are_parallel || (lo >= -STEEPEST_SLOPE && hi <= STEEPEST_SLOPE);
    }
    set_box(of->box, bundle->waist.main_axis, &cells->ends[place]);
    if (cells->are_parallel) hulls->first[place] = near, hulls->closed.common_first[place] = far;
    if (cells->have_ends) hulls->closed.common_last[place] = near, hulls->last[place] = far;
    return fits ? HAS_HULL : IS_MIXED;
}

/* Does a tile have 16x16 rays? The last row of a list may be short. */
MLRT_INLINE int is_whole_tile(const struct mlrt_source *source, const struct mlrt_rectangle *tile)
{
    const uint64_t last = ((uint64_t)tile->y + 15) * source->width + tile->x + 15;
    return tile->width == 16 && tile->height == 16 && last < source->count;
}

/* Makes a cell of a whole tile. */
static enum array_kind add_array_cell(struct mlrt_array_cells *cells, const struct mlrt_rectangle *tile,
                                      struct known_mesh *known, uint32_t place, struct mlrt_bundle *bundle)
{
    const struct mlrt_source *source = cells->reader.source;
    const struct mlrt_array_layout *skip = &cells->reader.skip;
    const size_t element = (size_t)tile->y * source->width + tile->x;
    struct array_extremes of = {.across = {NO_EXTREMES, NO_EXTREMES},
                                .box = {NO_EXTREMES, NO_EXTREMES, NO_EXTREMES},
                                .depth = NO_EXTREMES,
                                .sum = v_set1(0)};
    enum array_kind kind = HAS_HULL;
    int skips_one = 0;
    uint32_t pair[2];
    if (skip->data && corners_skip_one(skip, element, source->width)) {
        memcpy(pair, skip->data + element * skip->stride, sizeof pair);
        skips_one = 1;
    }
    struct mlrt_rows_ahead rows;
    mlrt_begin_source_rows(source, tile->x + 16, tile->y, &rows);
    for (uint32_t block = 0; block < 16; ++block) {
        const size_t first = element_of_block(cells, tile, block);
        mlrt_prefetch_rows(&rows, block);
        if (skips_one) skips_one = lanes_with_pair(skip, first, pair) == 0xFFFF;
        const enum array_kind kind_of_block = add_block(cells, first, &bundle->waist, &of);
        if (kind_of_block == IS_MIXED || (block && kind_of_block != kind)) return IS_MIXED;
        kind = kind_of_block;
    }
    if (skips_one) {
        find_mesh(source->tree, pair[0], known);
        if (pair[1] < known->range.count) bundle->hulls.closed.skip[place] = known->range.first + pair[1];
    }
    return kind == HAS_HULL ? set_array_cell(cells, &of, place, bundle) : kind;
}

/*
 * Makes a bundle of the tiles of `area`, which refers to *cells. Returns 0 if there is none: the nearest hit is asked
 * for, rays have masks or limits, neither origin nor direction is the same for all, or float does not carry them.
 */
static int gather_array_cells(const struct mlrt_job *job, const struct mlrt_rectangle *area,
                              struct mlrt_array_cells *cells, struct mlrt_bundle *bundle)
{
    struct known_mesh known = NO_MESH;
    const struct mlrt_source *source = &job->source;
    uint32_t there = 0, is_void = 0;
    if (!job->any || source->arrays.mask.data || !mlrt_begin_reading(source, &cells->reader)) return 0;
    if (cells->reader.t_min.data || cells->reader.t_max.data) return 0;
    const int is_light = source->kind != MLRT_SOURCE_RAYS;
    cells->area = *area;
    cells->from = NULL;
    cells->have_ends = 0;
    cells->are_parallel =
        source->kind == MLRT_SOURCE_DIRECTIONAL_LIGHT || (!is_light && !cells->reader.directions.step);
    if (!is_light && cells->reader.directions.step && cells->reader.points.step) return 0;
    bundle->scene.unit = cells->unit = job->tree->bvh.unit;
    bundle->scene.reach = job->tree->bvh.reach;
    mlrt_begin_cells(0, bundle);
    bundle->arrays = cells;
    if (cells->are_parallel && !mlrt_begin_parallel_cells(&job->tree->bvh, cells, &bundle->waist)) return 0;
    for (uint32_t place = 0; place < MLRT_BUNDLE_PACKETS; ++place) {
        const struct mlrt_rectangle tile = tile_of_cell(area, place);
        const size_t first = (size_t)tile.y * source->width + tile.x;
        if (16 * (place % 4) >= area->width || 16 * (place / 4) >= area->height) continue;
        if (!is_whole_tile(source, &tile)) continue;
        if (!there && !cells->are_parallel &&
            !mlrt_begin_apex_cells(&job->tree->bvh, source, first, cells, &bundle->waist))
            return 0;
        const enum array_kind kind = add_array_cell(cells, &tile, &known, place, bundle);
        there |= (uint32_t)(kind == HAS_HULL) << place;
        is_void |= (uint32_t)(kind == IS_VOID) << place;
    }
    if (cells->are_parallel) there = hulls_fit(bundle, there);
    bundle->state.going = there;
    bundle->state.apexes = cells->are_parallel ? 0 : there;
    bundle->state.closed = there | is_void;
    return bundle->state.closed != 0;
}

#endif
