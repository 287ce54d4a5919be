/* SPDX-License-Identifier: MIT */
/*
 * The tiles of a square of points, as seen from a point light, as a bundle without rays: of the rays to the points of a
 * tile only the hull is kept. A tile that stays closed needs no packets; the rays of the others are read again. A tile
 * none of whose points is finite, as where a picture shows nothing, is closed from the start, and is not traced.
 *
 * A ray ends at t = 1, at depth |d_main|. Its slope is a product with a reciprocal, which is off by 2.001 * 2^-24 of
 * itself and 2^-150 (ray_hulls.h). As in camera_cells.h, SLOPE_SLACK and SLOPE_FLOOR cover that.
 */
#ifndef MLRT_TRACE_POINT_CELLS_H
#define MLRT_TRACE_POINT_CELLS_H

#include "rays/read_arrays.h"
#include "trace/camera_cells.h"
#include "trace/ray_hulls.h"

/* Lane by lane, of all rays to the points of a tile. */
struct point_extremes {
    struct extremes slope[2];
    struct extremes pace; /* |d_main| */
    vf sum;               /* of all |slopes|: a NaN if one of them is */
};

/* What is known of a block, or of a tile. */
enum point_kind {
    HAS_HULL, /* of all rays */
    IS_VOID,  /* no ray is finite: they hit nothing (rule R1) */
    IS_MIXED
};

/*
 * Extends `of` by the rays of a block. It is mixed if one of them has an infinite slope or a NaN, or, where rays skip
 * triangles, another triangle than that of `pair`.
 */
static MLRT_NOINLINE enum point_kind add_block_of_points(const struct mlrt_array_reader *reader, size_t element,
                                                         const struct mlrt_waist *waist, const uint32_t pair[2],
                                                         struct point_extremes *of)
{
    MLRT_ALIGNED(64) float rows[3][MLRT_PACKET_RAYS];
    const struct mlrt_array_layout *points = &reader->points, *skip = &reader->skip;
    const int a = waist->main_axis;
    for (int v = 0; skip->data && v < MLRT_PACKET_RAYS; v += VW) {
        vi meshes, triangles;
        i_pairs_at(skip->data + element * skip->stride + offset_of_lane(skip, v), skip->step, skip->row_step, &meshes,
                   &triangles);
        const vm same = m_and(i_eq(meshes, i_set1(pair[0])), i_eq(triangles, i_set1(pair[1])));
        if (m_bits(same) != ALL_LANES) return IS_MIXED;
    }
    read_vectors(points, points->data + element * points->stride, reader->source->light, rows, NULL);
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf pace = v_flip(v_load(rows[a] + v), v_set1(waist->sign)), inverse = v_div(v_set1(1), pace);
        const vf zero = v_set1(0);
        of->pace.least = v_min(pace, of->pace.least);
        of->pace.negated = v_min(v_sub(zero, pace), of->pace.negated);
        MLRT_UNROLL
        for (int i = 0; i < 2; ++i) {
            const vf slope = v_mul(v_load(rows[mlrt_slope_axis(a, i)] + v), inverse);
            of->slope[i].least = v_min(slope, of->slope[i].least);
            of->slope[i].negated = v_min(v_sub(zero, slope), of->slope[i].negated);
            of->sum = v_add(v_abs(slope), of->sum);
        }
    }
    if (MLRT_LIKELY(m_bits(v_le(of->sum, v_set1(MLRT_SAFE_MAX))) == ALL_LANES)) return HAS_HULL;
    uint32_t finite = 0;
    for (int v = 0; v < MLRT_PACKET_RAYS; v += VW) {
        const vf zero = v_set1(0);
        vf zero_or_nan = zero;
        for (int k = 0; k < 3; ++k) zero_or_nan = v_mul_add(v_load(rows[k] + v), zero, zero_or_nan);
        finite |= m_bits(v_eq(zero_or_nan, zero));
    }
    return finite ? IS_MIXED : IS_VOID;
}

/* Sets the hull of a tile. It is mixed if float does not carry its rays. */
static enum point_kind set_point_cell(const struct point_extremes *of, uint32_t place, struct mlrt_bundle *bundle)
{
    struct mlrt_hulls *hulls = &bundle->hulls;
    MLRT_ALIGNED(16) float least[4];
    f4_store(least, v_hmin4(of->slope[0].least, of->slope[1].least, of->slope[0].negated, of->slope[1].negated));
    const float first = v_hmin(of->pace.least) * bundle->unit, last = -v_hmin(of->pace.negated) * bundle->unit;
    int fits = first >= LEAST_PACE && last <= GREATEST_PACE;
    for (int i = 0; i < 2; ++i) {
        const float lo = least[i], hi = -least[2 + i];
        hulls->term[i].lo[place] = lo - (fabsf(lo) * SLOPE_SLACK + SLOPE_FLOOR);
        hulls->term[i].hi[place] = hi + (fabsf(hi) * SLOPE_SLACK + SLOPE_FLOOR);
        fits &= lo >= -STEEPEST_SLOPE && hi <= STEEPEST_SLOPE;
    }
    hulls->core_last[place] = first;
    hulls->last[place] = last;
    return fits ? HAS_HULL : IS_MIXED;
}

/* Makes a cell of a tile of points, if it is a whole one. */
static enum point_kind add_point_cell(const struct mlrt_array_reader *reader, const struct mlrt_rectangle *tile,
                                      struct known_mesh *known, uint32_t place, struct mlrt_bundle *bundle)
{
    const struct mlrt_source *source = reader->source;
    const size_t element = (size_t)tile->y * source->width + tile->x;
    struct point_extremes of = {{NO_EXTREMES, NO_EXTREMES}, NO_EXTREMES, v_set1(0)};
    enum point_kind kind = HAS_HULL;
    uint32_t pair[2];
    if (tile->width + tile->height < 32 || element + 15 * (size_t)source->width + 16 > source->count) return IS_MIXED;
    if (reader->skip.data) {
        memcpy(pair, reader->skip.data + element * reader->skip.stride, sizeof pair);
        find_mesh(source->tree, pair[0], known);
        if (pair[1] < known->range.count) bundle->hulls.skip[place] = known->range.first + pair[1];
    }
    for (uint32_t block = 0; block < 16; ++block) {
        const size_t first = element + (size_t)(block & ~3u) * source->width + 4 * (block & 3);
        mlrt_prefetch_row(source, tile->x + 16, tile->y + block);
        const enum point_kind kind_of_block = add_block_of_points(reader, first, &bundle->waist, pair, &of);
        if (kind_of_block == IS_MIXED || (block && kind_of_block != kind)) return IS_MIXED;
        kind = kind_of_block;
    }
    return kind == HAS_HULL ? set_point_cell(&of, place, bundle) : kind;
}

/* Makes a bundle of the tiles of points in `area`. Returns 0 if there is none. */
static int gather_point_cells(const struct mlrt_job *job, const struct mlrt_rectangle *area, struct mlrt_bundle *bundle)
{
    struct mlrt_array_reader reader;
    struct known_mesh known = NO_MESH;
    const struct mlrt_source *source = &job->source;
    struct mlrt_waist *waist = &bundle->waist;
    uint32_t there = 0, is_void = 0;
    if (source->has_masks || !mlrt_begin_reading(source, &reader)) return 0;
    bundle->unit = job->tree->bvh.unit;
    if (!mlrt_set_apex(source->light, bundle->unit, waist)) return 0;
    begin_cells(0, bundle);
    for (uint32_t place = 0; place < MLRT_CELL_COUNT; ++place) {
        const struct mlrt_rectangle tile = mlrt_cut_piece(area, 16 * (place % 4), 16 * (place / 4), 16);
        if (16 * (place % 4) >= area->width || 16 * (place / 4) >= area->height) continue;
        if (!there) {
            float direction[3];
            const size_t element = (size_t)tile.y * source->width + tile.x;
            memcpy(direction, reader.points.data + element * reader.points.stride, sizeof direction);
            for (int k = 0; k < 3; ++k) direction[k] -= source->light[k];
            mlrt_set_main_axis(direction, waist);
        }
        const enum point_kind kind = add_point_cell(&reader, &tile, &known, place, bundle);
        there |= (uint32_t)(kind == HAS_HULL) << place;
        is_void |= (uint32_t)(kind == IS_VOID) << place;
    }
    bundle->going = bundle->apexes = there;
    bundle->closed = there | is_void;
    return bundle->closed != 0;
}

#endif
